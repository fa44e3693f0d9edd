"""A closed mesh of quads around a body that is given by a field: negative inside, zero on its surface."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]
Field = Callable[[Array], Array]
"""From points `(..., 3)` to about their distance from the surface `(...)`, negative inside; metres."""

# the corners of a cell, and the pairs of them that its edges join
_CORNERS = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)])
_EDGES = np.array(
    [(a, b) for a in range(8) for b in range(a) if np.abs(_CORNERS[a] - _CORNERS[b]).sum() == 1]
)
_SLOPE_STEP = 0.25
"""Of a cell's size, over which the field's slope is taken."""


def surface(field: Field, low: Array, high: Array, size: float) -> tuple[Array, NDArray[np.intp]]:
    """The field's surface by surface nets (Gibson 1998): one vertex in each cell that it passes through.

    Args:
        field: negative inside.
        low: `(3,)` a corner of a box that holds all of the body, metres.
        high: `(3,)` the opposite corner.
        size: of a cell, metres; a surface that is thinner is lost.

    Returns:
        Vertices `(V, 3)` and quads `(F, 4)`, counterclockwise seen from outside.
    """
    counts = np.ceil((np.asarray(high) - low) / size).astype(int) + 2
    indices = np.indices((int(counts[0]), int(counts[1]), int(counts[2])))
    grid: Array = low + size * (np.moveaxis(indices, 0, -1) - 0.5)
    values = field(grid)
    inside = values < 0.0
    corners = np.stack([inside[_window(corner, counts)] for corner in _CORNERS])
    crossed = corners.any(axis=0) & ~corners.all(axis=0)
    cells = np.argwhere(crossed)
    numbers = np.full(crossed.shape, -1, dtype=np.intp)
    numbers[crossed] = np.arange(len(cells))
    at = np.stack([values[tuple((cells + corner).T)] for corner in _CORNERS], axis=1)
    points: Array = grid[0, 0, 0] + size * (cells + _middles(at))
    return _settled(field, points, size), _quads(inside, numbers)


def _window(corner: Array, counts: NDArray[np.int_]) -> tuple[slice, ...]:
    return tuple(slice(int(c), int(c + n - 1)) for c, n in zip(corner, counts, strict=True))


def _middles(at: Array) -> Array:
    """Where in its cell each vertex is `(C, 3)`: the mean of the crossings of the edges; `at` `(C, 8)`."""
    a, b = at[:, _EDGES[:, 0]], at[:, _EDGES[:, 1]]
    cut = (a < 0.0) != (b < 0.0)
    share = np.where(cut, a / np.where(cut, a - b, 1.0), 0.0)[..., None]
    places = _CORNERS[_EDGES[:, 0]] * (1.0 - share) + _CORNERS[_EDGES[:, 1]] * share
    return (places * cut[..., None]).sum(axis=1) / cut.sum(axis=1)[:, None]


def _settled(field: Field, points: Array, size: float) -> Array:
    """The points moved along the field's slope onto its surface, by no more than half a cell."""
    step = _SLOPE_STEP * size
    moved = points
    for _ in range(2):
        ahead, behind = (
            np.stack([field(moved + sign * step * axis) for axis in np.eye(3)], axis=-1)
            for sign in (1.0, -1.0)
        )
        slope = (ahead - behind) / (2.0 * step)
        length = np.maximum((slope**2).sum(axis=-1, keepdims=True), 0.04)
        moved = moved - slope * field(moved)[..., None] / length
    shift = moved - points
    far = np.maximum(np.linalg.norm(shift, axis=-1, keepdims=True) / (0.5 * size), 1.0)
    return points + shift / far


def _quads(inside: NDArray[np.bool_], numbers: NDArray[np.intp]) -> NDArray[np.intp]:
    """A quad round each edge of the grid that the surface cuts."""
    found: list[NDArray[np.intp]] = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        first, second = np.moveaxis(inside, axis, 0)[:-1], np.moveaxis(inside, axis, 0)[1:]
        places = np.argwhere(first != second)
        # back to the order x, y, z
        places = np.insert(np.delete(places, 0, axis=1), axis, places[:, 0], axis=1)
        within = (places[:, [u, v]] > 0).all(axis=1) & (
            places[:, [u, v]] < np.array(numbers.shape)[[u, v]]
        ).all(axis=1)
        places = places[within]
        step_u, step_v = np.eye(3, dtype=int)[u], np.eye(3, dtype=int)[v]
        ring = [places - step_u - step_v, places - step_v, places, places - step_u]
        quad = np.stack([numbers[tuple(cell.T)] for cell in ring], axis=1)
        outwards = inside[tuple(places.T)]
        found.append(np.where(outwards[:, None], quad, quad[:, ::-1]))
    return np.concatenate(found)

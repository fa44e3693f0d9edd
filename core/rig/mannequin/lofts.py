"""Fields of bodies: lofts round an axis, and their smooth unions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]


@dataclass(frozen=True, slots=True, eq=False)
class Loft:
    """Ellipses along an axis, with round ends."""

    start: Array
    """`(3,)` where the axis starts, metres."""
    end: Array
    across: Array
    """`(3,)` direction of the ellipses' first half axis, at right angles to the axis."""
    knots: tuple[tuple[float, ...], ...]
    """Place along the axis (0 start, 1 end), first and second half axis, and shift of the middle along the second;
    metres."""

    def __call__(self, points: Array) -> Array:
        """About the distance from the surface `(...)` of points `(..., 3)`, negative inside; metres."""
        axis = self.end - self.start
        length = float(np.linalg.norm(axis))
        axis = axis / length
        second = np.cross(axis, self.across)
        relative = points - self.start
        along = relative @ axis / length
        at, first_radius, second_radius, shift = np.array(self.knots).T
        inside = np.clip(along, at[0], at[-1])
        a, b, c = (_smooth(inside, at, radius) for radius in (first_radius, second_radius, shift))
        over = (along - inside) * length
        least = np.minimum(a, b)
        u, v = relative @ self.across / a, (relative @ second - c) / b
        return (np.sqrt(u * u + v * v + (over / least) ** 2) - 1.0) * least

    def box(self) -> tuple[Array, Array]:
        """Opposite corners `(3,)` of a box that holds it."""
        knots = np.array(self.knots)
        widest = float(knots[:, 1:3].max() + np.abs(knots[:, 3]).max())
        ends = self.start + np.outer(knots[[0, -1], 0], self.end - self.start)
        return ends.min(axis=0) - widest, ends.max(axis=0) + widest


def _smooth(at: Array, knots: Array, values: Array) -> Array:
    """Values between knots by cubic Hermite curves, level at both ends, without overshoot at a knot's extreme."""
    slopes = np.zeros(len(knots))
    steps = np.diff(values) / np.diff(knots)
    rising = steps[1:] * steps[:-1] > 0.0
    slopes[1:-1] = np.where(
        rising, 2.0 * steps[1:] * steps[:-1] / np.where(rising, steps[1:] + steps[:-1], 1.0), 0.0
    )
    index = np.clip(np.searchsorted(knots, at, side="right") - 1, 0, len(knots) - 2)
    width = (knots[1:] - knots[:-1])[index]
    t = (at - knots[index]) / width
    a, b = values[index], values[index + 1]
    m, n = slopes[index] * width, slopes[index + 1] * width
    return (
        (2 * t**3 - 3 * t**2 + 1) * a
        + (t**3 - 2 * t**2 + t) * m
        + (3 * t**2 - 2 * t**3) * b
        + (t**3 - t**2) * n
    )


def union(a: Array, b: Array, blend: float) -> Array:
    """The field of both bodies together, the groove between them filled over `blend` metres."""
    near = np.clip(0.5 + 0.5 * (b - a) / blend, 0.0, 1.0)
    return b + (a - b) * near - blend * near * (1.0 - near)


def intersection(a: Array, b: Array, blend: float) -> Array:
    """The field of what both bodies have in common, its edges rounded over `blend` metres."""
    return -union(-a, -b, blend)

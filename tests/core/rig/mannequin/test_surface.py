"""Surfaces of fields whose true surface is known."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
import pytest
from footwork.core.rig.mannequin.lofts import Loft, intersection, union
from footwork.core.rig.mannequin.surface import surface
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]
MIDDLE = np.array([0.3, -0.2, 1.1])


def sphere(points: Array) -> Array:
    return np.linalg.norm(points - MIDDLE, axis=-1) - 0.25


def volume(points: Array, quads: NDArray[np.intp]) -> float:
    """Of a closed mesh; negative where its faces look inwards."""
    triangles = np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    return float(np.sum(a * np.cross(b, c)) / 6.0)


def edges(quads: NDArray[np.intp]) -> Counter[tuple[int, int]]:
    """How often each directed edge occurs."""
    pairs = np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2)
    return Counter(map(tuple, pairs.tolist()))


@pytest.mark.parametrize("size", [0.03, 0.05])
def test_a_sphere(size: float) -> None:
    points, quads = surface(sphere, MIDDLE - 0.3, MIDDLE + 0.3, size)
    assert np.abs(sphere(points)).max() < 0.02 * size
    assert volume(points, quads) == pytest.approx(4.0 / 3.0 * np.pi * 0.25**3, rel=0.03)


def test_it_is_closed_and_looks_outwards() -> None:
    _, quads = surface(sphere, MIDDLE - 0.3, MIDDLE + 0.3, 0.04)
    directed = edges(quads)
    assert set(directed.values()) == {1}
    assert all((b, a) in directed for a, b in directed)


def test_a_loft_is_as_wide_as_its_knots() -> None:
    axis = np.array([0.0, 0.6, 0.8])
    across = np.array([1.0, 0.0, 0.0])
    loft = Loft(
        np.zeros(3), 2.0 * axis, across, ((0.0, 0.2, 0.1, 0.0), (0.5, 0.4, 0.3, 0.05), (1.0, 0.1, 0.1, 0.0))
    )
    second = np.cross(axis, across)
    for at, first, other, shift in loft.knots:
        middle = 2.0 * at * axis + shift * second
        on = np.array([middle + first * across, middle - first * across, middle + other * second])
        assert loft(on) == pytest.approx(np.zeros(3), abs=1e-9)
        assert loft(middle) < 0.0
    # round ends, as large as the smaller half axis
    assert loft(-0.1 * axis) == pytest.approx(0.0, abs=1e-9)
    low, high = loft.box()
    assert (low <= -0.1 * axis).all() and (high >= 2.1 * axis - 1e-9).all()


def test_unions_fill_grooves_and_intersections_round_edges() -> None:
    far, near = np.array([1.0, -1.0, 0.0]), np.array([-1.0, 1.0, 0.0])
    assert union(far, near, 0.1) == pytest.approx([-1.0, -1.0, -0.025])
    assert intersection(far, near, 0.1) == pytest.approx([1.0, 1.0, 0.025])

"""Vectors against numpy's own slow functions, and the axes of planes by what they must be."""

from __future__ import annotations

import numpy as np
import pytest
from footwork.core.maths import vectors

SHAPES = [(), (1,), (7,), (2, 5), (2, 1, 3)]


def some(shape: tuple[int, ...], seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(*shape, 3))


@pytest.mark.parametrize("shape", SHAPES)
def test_products_and_lengths_are_numpys(shape: tuple[int, ...]) -> None:
    a, b = some(shape), some(shape, 1)
    np.testing.assert_allclose(vectors.dot(a, b), np.sum(a * b, axis=-1), atol=1e-15)
    np.testing.assert_allclose(vectors.norm(a), np.linalg.norm(a, axis=-1), rtol=1e-15)
    np.testing.assert_allclose(vectors.cross(a, b), np.cross(a, b), atol=1e-15)
    lengths = np.linalg.norm(a, axis=-1, keepdims=True)
    np.testing.assert_allclose(vectors.unit(a), a / lengths, rtol=1e-15)
    np.testing.assert_array_equal(vectors.level(a)[..., :2], a[..., :2])
    np.testing.assert_array_equal(vectors.level(a)[..., 2], np.zeros(shape))


def test_one_vector_goes_with_many() -> None:
    one, many = some(()), some((4, 6), 1)
    for function in (vectors.dot, vectors.cross):
        each = np.array([[function(one, v) for v in row] for row in many])
        np.testing.assert_allclose(function(one, many), each, atol=1e-15)
        each = np.array([[function(v, one) for v in row] for row in many])
        np.testing.assert_allclose(function(many, one), each, atol=1e-15)


def test_what_has_no_length_points_along_x() -> None:
    given = np.array([[0, 0, 0], [0, -3e-13, 4e-13], [0, -3e-12, 4e-12], [0.0, -3.0, 4.0]])
    expected = [[1, 0, 0], [1, 0, 0], [0, -0.6, 0.8], [0, -0.6, 0.8]]
    np.testing.assert_allclose(vectors.unit(given), expected, atol=1e-15)
    np.testing.assert_array_equal(vectors.unit(np.zeros(3)), [1.0, 0.0, 0.0])


@pytest.mark.parametrize("shape", SHAPES)
def test_the_part_across_and_the_part_along_make_the_vector(shape: tuple[int, ...]) -> None:
    given, axis = some(shape), vectors.unit(some(shape, 1))
    across = vectors.across(given, axis)
    np.testing.assert_allclose(np.sum(across * axis, axis=-1), 0.0, atol=1e-14)
    np.testing.assert_allclose(np.cross(given - across, axis), 0.0, atol=1e-14)


def assert_plane(found: np.ndarray, along: np.ndarray, side: np.ndarray) -> None:
    """Columns are right-handed axes; the first lies along, the second in the half plane of the side."""
    x, y = found[..., 0], found[..., 1]
    np.testing.assert_allclose(
        np.swapaxes(found, -1, -2) @ found, np.broadcast_to(np.eye(3), found.shape), atol=1e-7
    )
    np.testing.assert_allclose(np.linalg.det(found), 1.0, atol=1e-7)
    np.testing.assert_allclose(x, along / np.linalg.norm(along, axis=-1, keepdims=True), atol=1e-14)
    across = side - np.sum(side * x, axis=-1, keepdims=True) * x
    np.testing.assert_allclose(np.sum(across * y, axis=-1), np.linalg.norm(across, axis=-1), atol=1e-12)


@pytest.mark.parametrize("shape", SHAPES)
def test_the_axes_of_a_plane(shape: tuple[int, ...]) -> None:
    along, side = some(shape), some(shape, 1)
    found = vectors.plane(along, side)
    assert found.shape == (*shape, 3, 3)
    assert_plane(found, along, side)


def test_one_side_serves_many_lines_and_one_line_many_sides() -> None:
    one, many = some(()), some((2, 6), 1)
    assert_plane(vectors.plane(many, one), many, np.broadcast_to(one, many.shape))
    assert_plane(vectors.plane(one, many), np.broadcast_to(one, many.shape), many)


def test_a_side_along_the_line_tells_no_plane_and_any_will_do() -> None:
    along = np.concatenate([some((30,)), np.eye(3), -2.0 * np.eye(3)])
    side = along * np.linspace(-2.0, 2.0, 36)[:, None]
    # the others of the series keep their own planes
    side[::5] = some((8,), 1)
    side[7] = 0.0
    assert_plane(vectors.plane(along, side), along, side)
    for i in range(len(along)):
        assert_plane(vectors.plane(along[i], side[i]), along[i], side[i])


def test_a_side_a_nanometre_off_the_line_still_tells_the_plane() -> None:
    along = np.array([0.0, 0.0, 2.0])
    off = np.array([[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0]])
    found = vectors.plane(along, np.array([0.0, 0.0, 0.5]) + 2e-9 * off)
    np.testing.assert_allclose(found[..., 1], off, atol=1e-6)
    lost = vectors.plane(along, np.array([0.0, 0.0, 0.5]) + 0.5e-9 * off)
    np.testing.assert_array_equal(lost[0], lost[1])

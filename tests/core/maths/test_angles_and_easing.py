"""Angles about the vertical and the curves between 0 and 1, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from footwork.core.maths import angles, easing
from scipy.spatial.transform import Rotation


def test_wrapped_angles_turn_the_same_way_within_half_a_turn() -> None:
    given = np.random.default_rng(0).uniform(-40.0, 40.0, (5, 60))
    found = angles.wrap(given)
    assert (found >= -np.pi).all() and (found < np.pi).all()
    np.testing.assert_allclose(np.exp(1j * found), np.exp(1j * given), atol=1e-12)
    inside = np.linspace(-3.1, 3.1, 20)
    np.testing.assert_allclose(angles.wrap(inside), inside, atol=1e-15)


def test_half_a_turn_is_wrapped_to_the_negative_end() -> None:
    np.testing.assert_array_equal(angles.wrap([np.pi, -np.pi, 0.0]), [-np.pi, -np.pi, 0.0])


@pytest.mark.parametrize("kind", [np.float32, np.int64])
def test_angles_of_any_kind_give_full_precision(kind: type) -> None:
    given = np.array([-7, -2, 0, 1, 3, 9], dtype=kind)
    exact = given.astype(np.float64)
    for function in (angles.wrap, angles.direction):
        assert function(given).dtype == np.float64
        np.testing.assert_array_equal(function(given), function(exact))
    assert angles.wrap(9) == pytest.approx(9 - 2 * np.pi)


@pytest.mark.parametrize("shape", [(), (9,), (2, 4)])
def test_turns_about_the_vertical_are_scipys(shape: tuple[int, ...]) -> None:
    rng = np.random.default_rng(1)
    vector, yaw = rng.normal(size=(*shape, 2)), rng.uniform(-4.0, 4.0, shape)
    padded = np.concatenate([vector, np.zeros((*shape, 1))], axis=-1).reshape(-1, 3)
    expected = Rotation.from_euler("z", yaw.reshape(-1, 1)).apply(padded)[:, :2].reshape(*shape, 2)
    np.testing.assert_allclose(angles.turn(vector, yaw), expected, atol=1e-14)
    faced = Rotation.from_euler("z", yaw.reshape(-1, 1)).apply([0.0, 1.0, 0.0])[:, :2].reshape(*shape, 2)
    np.testing.assert_allclose(angles.direction(yaw), faced, atol=1e-14)


def test_one_yaw_turns_many_vectors_and_many_yaws_one() -> None:
    rng = np.random.default_rng(2)
    vectors, yaws = rng.normal(size=(6, 2)), rng.uniform(-3.0, 3.0, 6)
    np.testing.assert_allclose(
        angles.turn(vectors, 0.7), [angles.turn(vector, 0.7) for vector in vectors], atol=1e-15
    )
    np.testing.assert_allclose(
        angles.turn(vectors[0], yaws), [angles.turn(vectors[0], yaw) for yaw in yaws], atol=1e-15
    )


def test_yaw_is_zero_ahead_positive_to_the_left_and_blind_to_height() -> None:
    ground = np.array([[0.0, 2.0], [-3.0, 0.0], [2.0, 0.0], [-1.0, -1.0], [0.0, 0.0]])
    expected = [0.0, np.pi / 2, -np.pi / 2, 0.75 * np.pi, 0.0]
    np.testing.assert_allclose(angles.yaw_of(ground), expected, atol=1e-15)
    raised = np.concatenate([ground, np.full((5, 1), 7.0)], axis=1)
    np.testing.assert_array_equal(angles.yaw_of(raised), angles.yaw_of(ground))


@pytest.mark.parametrize(
    ("curve", "powers"), [(easing.smoothstep, [0, 0, 3, -2]), (easing.smootherstep, [0, 0, 0, 10, -15, 6])]
)
def test_easing_is_the_polynomial_without_slope_at_its_ends(curve, powers: list[int]) -> None:
    polynomial = np.polynomial.Polynomial(powers)
    t = np.linspace(0.0, 1.0, 24).reshape(2, 3, 4)
    np.testing.assert_allclose(curve(t), polynomial(t), atol=1e-15)
    assert curve(np.array(0.0)) == 0.0 and curve(np.array(1.0)) == 1.0
    for degree in range(1, len(powers) // 2):
        np.testing.assert_allclose(polynomial.deriv(degree)(np.array([0.0, 1.0])), 0.0, atol=1e-12)

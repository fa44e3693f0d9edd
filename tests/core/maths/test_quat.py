"""Quaternions against scipy's rotations."""

from __future__ import annotations

import numpy as np
import pytest
from footwork.core.maths import angles, kinematics, quat
from scipy.spatial.transform import Rotation

ORDERS = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")


def scipy_of(q: np.ndarray) -> Rotation:
    return Rotation.from_quat(np.roll(q, -1, axis=-1))


def random(n: int = 200, seed: int = 0) -> np.ndarray:
    return np.roll(Rotation.random(n, random_state=seed).as_quat(), 1, axis=-1)


def same(a: np.ndarray, b: np.ndarray, tolerance: float = 1e-12) -> bool:
    """Whether quaternions are the same rotations."""
    return bool(np.all(1.0 - np.abs(np.sum(a * b, axis=-1)) < tolerance))


def test_product_and_rotation() -> None:
    a, b = random(seed=1), random(seed=2)
    v = np.random.default_rng(0).normal(size=(200, 3))
    assert np.allclose(scipy_of(quat.multiply(a, b)).as_matrix(), (scipy_of(a) * scipy_of(b)).as_matrix())
    assert np.allclose(quat.rotate(a, v), scipy_of(a).apply(v))
    assert np.allclose(quat.rotate(quat.conjugate(a), v), scipy_of(a).inv().apply(v))


def test_matrix_both_ways() -> None:
    q = random()
    assert np.allclose(quat.to_matrix(q), scipy_of(q).as_matrix())
    assert same(quat.from_matrix(scipy_of(q).as_matrix()), q)
    half_turns = np.array([[0.0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [1, 0, 0, 0]])
    assert same(quat.from_matrix(quat.to_matrix(half_turns)), half_turns)


def test_rotation_vector_both_ways() -> None:
    q = random()
    assert np.allclose(quat.to_rotation_vector(q), scipy_of(q).as_rotvec())
    tiny = np.array([[1e-12, 0, 0], [0, 3e-9, 0], [0, 0, 1e-5], [0, 0, 0]])
    for vectors in (scipy_of(q).as_rotvec(), tiny):
        expected = np.roll(Rotation.from_rotvec(vectors).as_quat(), 1, axis=-1)
        assert same(quat.from_rotation_vector(vectors), expected)
    assert np.allclose(quat.to_rotation_vector(quat.from_rotation_vector(tiny)), tiny, atol=1e-15)


@pytest.mark.parametrize("order", ORDERS)
def test_euler_both_ways(order: str) -> None:
    angle = np.random.default_rng(3).uniform(-np.pi, np.pi, size=(300, 3))
    q = quat.from_euler(angle, order)
    assert np.allclose(quat.to_matrix(q), Rotation.from_euler(order, angle).as_matrix())
    assert same(quat.from_euler(quat.to_euler(q, order), order), q)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("middle", [np.pi / 2, -np.pi / 2])
def test_euler_at_gimbal_lock(order: str, middle: float) -> None:
    angle = np.random.default_rng(4).uniform(-np.pi, np.pi, size=(50, 3))
    angle[:, 1] = middle
    q = quat.from_euler(angle, order)
    assert same(quat.from_euler(quat.to_euler(q, order), order), q, 1e-9)


def test_sixd_both_ways() -> None:
    q = random()
    assert same(quat.from_sixd(quat.to_sixd(q) * 3.0), q)


def test_between_directions() -> None:
    a, b = np.random.default_rng(5).normal(size=(2, 100, 3))
    q = quat.between(a, b)
    unit = b / np.linalg.norm(b, axis=-1, keepdims=True)
    assert np.allclose(quat.rotate(q, a / np.linalg.norm(a, axis=-1, keepdims=True)), unit)
    cosine = np.sum(a * b, axis=-1) / np.linalg.norm(a, axis=-1) / np.linalg.norm(b, axis=-1)
    assert np.allclose(scipy_of(q).magnitude(), np.arccos(cosine))
    assert np.allclose(quat.rotate(quat.between(a, -a), a), -a)


def test_slerp_goes_the_short_way_at_even_speed() -> None:
    a, b = random(50, 6), random(50, 7)
    whole = (scipy_of(b) * scipy_of(a).inv()).magnitude()
    for t in (0.0, 0.3, 1.0):
        done = (scipy_of(quat.slerp(a, b, np.full(50, t))) * scipy_of(a).inv()).magnitude()
        assert np.allclose(done, t * whole)


def test_continuous_keeps_rotations_and_removes_flips() -> None:
    q = quat.from_yaw(np.linspace(0, 7 * np.pi, 500))
    flipped = q * np.random.default_rng(8).choice([-1.0, 1.0], size=(500, 1))
    smooth = quat.continuous(flipped)
    assert same(smooth, q)
    assert np.all(np.sum(smooth[1:] * smooth[:-1], axis=-1) > 0)


def test_heading_is_the_yaw_and_stays_put_when_looking_straight_down() -> None:
    yaw = np.linspace(-3, 3, 61)
    for pitch in (-np.pi / 2, -1.2, 0.0, 1.2, np.pi / 2):
        q = quat.multiply(quat.from_yaw(yaw), quat.from_axis("X", pitch))
        assert np.allclose(angles.wrap(quat.heading(q) - yaw), 0.0)


def test_angles() -> None:
    yaw = np.linspace(-3.1, 3.1, 50)
    assert np.allclose(angles.yaw_of(angles.direction(yaw)), yaw)
    assert np.allclose(angles.turn(np.array([0.0, 1.0]), yaw), angles.direction(yaw))
    assert np.allclose(
        angles.direction(yaw), quat.rotate(quat.from_yaw(yaw), np.array([0.0, 1.0, 0.0]))[:, :2]
    )


def test_angular_velocity_of_a_steady_turn() -> None:
    rotations = quat.from_rotation_vector(np.linspace(0, 4, 241)[:, None] * np.array([0.6, 0.0, 0.8]))
    assert np.allclose(kinematics.angular_velocity(rotations, 60.0), np.array([0.6, 0.0, 0.8]))

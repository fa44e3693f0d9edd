"""Kinematics of joints that turn about axes which change all the time, against scipy and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from footwork.core.body import forward_kinematics
from footwork.core.body.motion import Motion
from footwork.core.database.poses import clip_poses
from footwork.core.maths import kinematics, quat
from scipy.spatial.transform import Rotation

FPS = 60.0


def scipy_of(q: np.ndarray) -> Rotation:
    return Rotation.from_quat(np.roll(q, -1, axis=-1))


def wxyz(rotation: Rotation) -> np.ndarray:
    return np.roll(rotation.as_quat(), 1, axis=-1)


def test_angular_velocity_of_a_spinning_top() -> None:
    """A top of tilt b that spins at c and precesses at a: a about the vertical and c about its own axis."""
    fps, a, b, c = 2000.0, 1.7, 0.8, -2.9
    times = np.arange(2001) / fps
    precession, tilt = Rotation.from_euler("z", a * times[:, None]), Rotation.from_euler("x", b)
    top = wxyz(precession * tilt * Rotation.from_euler("z", c * times[:, None]))
    expected = np.array([0.0, 0.0, a]) + c * (precession * tilt).apply([0.0, 0.0, 1.0])
    found = kinematics.angular_velocity(quat.continuous(top), fps)
    np.testing.assert_allclose(found[1:-1], expected[1:-1], atol=2e-5)
    # one-sided at the ends: half a step late, half a step early
    np.testing.assert_allclose(found[[0, -1]], expected[[0, -1]], atol=2e-3)


def test_angular_velocity_is_that_of_scipy_for_any_number_of_joints(tumble) -> None:
    rotations = tumble(90, FPS, count=6).reshape(90, 2, 3, 4)
    found = kinematics.angular_velocity(rotations, FPS)
    assert found.shape == (90, 2, 3, 3)
    for joint in np.ndindex(2, 3):
        turns = scipy_of(rotations[(slice(None), *joint)])
        steps = (turns[1:] * turns[:-1].inv()).as_rotvec() * FPS
        expected = np.concatenate([steps[:1], 0.5 * (steps[1:] + steps[:-1]), steps[-1:]])
        np.testing.assert_allclose(found[(slice(None), *joint)], expected, atol=1e-9)


def test_velocities_of_points_are_those_of_the_turn_that_carries_them(tumble) -> None:
    fps = 3000.0
    rotations, arm = tumble(900, fps)[:, 0], np.array([0.3, -0.5, 0.7])
    carried = scipy_of(rotations).apply(arm)
    found = kinematics.velocity(carried, fps)
    turning = kinematics.angular_velocity(rotations, fps)
    np.testing.assert_allclose(found[1:-1], np.cross(turning, carried)[1:-1], atol=1e-4)


def test_poses_keep_angular_velocities_in_the_parents_axes(unequal, tumble) -> None:
    skeleton = unequal()
    rotations = tumble(120, FPS, count=len(skeleton), seed=3)
    yaws, places = np.linspace(2.0, 5.0, 120), np.cumsum(np.full((120, 2), 0.01), axis=0)
    motion = Motion(skeleton, FPS, np.pad(places, ((0, 0), (0, 1)), constant_values=1.0), rotations)
    poses = clip_poses(motion, places, yaws, np.zeros((120, 2), np.bool_))
    for joint in range(len(skeleton)):
        turns = scipy_of(rotations[:, joint])
        if joint == 0:
            turns = Rotation.from_euler("z", -yaws[:, None]) * turns
        central = (turns[2:] * turns[:-2].inv()).as_rotvec() * 0.5 * FPS
        np.testing.assert_allclose(poses.angular_velocities[1:-1, joint], central, atol=0.02)


def test_forward_is_the_chain_of_scipy_and_local_rotations_lead_back(unequal, tumble) -> None:
    skeleton = unequal()
    rotations = tumble(40, FPS, count=len(skeleton), seed=1)
    hips = np.random.default_rng(2).normal(size=(40, 3))
    positions, world = forward_kinematics.forward(hips, rotations, skeleton.offsets, skeleton.parents)
    turns: list[Rotation] = []
    places: list[np.ndarray] = []
    for joint, parent in enumerate(skeleton.parents.tolist()):
        local = scipy_of(rotations[:, joint])
        turns.append(local if joint == 0 else turns[parent] * local)
        places.append(hips if joint == 0 else places[parent] + turns[parent].apply(skeleton.offsets[joint]))
        np.testing.assert_allclose(positions[:, joint], places[joint], atol=1e-12)
        apart = (scipy_of(world[:, joint]) * turns[joint].inv()).magnitude()
        assert apart.max() < 1e-7
    back = forward_kinematics.local_rotations(world, skeleton.parents)
    assert np.abs(np.sum(back * rotations, axis=-1)).min() == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("shape", [(), (3,), (2, 3)])
def test_velocities_of_a_throw_are_exact_but_at_the_ends(shape: tuple[int, ...]) -> None:
    rng = np.random.default_rng(4)
    place, speed, gravity = rng.normal(size=(3, *shape))
    times = (np.arange(9) / FPS).reshape(-1, *(1 for _ in shape))
    found = kinematics.velocity(place + speed * times + gravity * times**2, FPS)
    expected = speed + 2.0 * gravity * times
    np.testing.assert_allclose(found[1:-1], expected[1:-1], atol=1e-12)
    # one-sided: the velocity half a step inside
    np.testing.assert_allclose(found[0], expected[0] + gravity / FPS, atol=1e-12)
    np.testing.assert_allclose(found[-1], expected[-1] - gravity / FPS, atol=1e-12)


def test_velocities_of_one_frame_are_zero_and_of_two_the_same() -> None:
    values = np.random.default_rng(5).normal(size=(2, 4, 3))
    rotations = quat.normalize(np.random.default_rng(6).normal(size=(2, 5, 4)))
    for found, shape in (
        (kinematics.velocity(values[:1], 30.0), (1, 4, 3)),
        (kinematics.angular_velocity(rotations[:1], 30.0), (1, 5, 3)),
    ):
        assert found.shape == shape and not found.any()
    np.testing.assert_allclose(kinematics.velocity(values, 30.0), [30.0 * (values[1] - values[0])] * 2)
    turn = (scipy_of(rotations[1]) * scipy_of(rotations[0]).inv()).as_rotvec()
    np.testing.assert_allclose(kinematics.angular_velocity(rotations, 30.0), [30.0 * turn] * 2, atol=1e-9)

from __future__ import annotations

import numpy as np
from footwork.core.body.motion import Motion
from footwork.core.database.virtual_root import to_root_space, virtual_root
from footwork.core.maths import quat
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal
from scipy.spatial.transform import Rotation


def with_hips(motion: Motion, rotations: np.ndarray) -> Motion:
    out = motion.rotations.copy()
    out[:, 0] = rotations
    return Motion(motion.skeleton, motion.fps, motion.positions, out)


def test_bending_hips_keep_the_heading(glide) -> None:
    yaws = np.linspace(0.0, 6.0 * np.pi, 400)
    path = np.column_stack([np.cos(yaws), 0.3 * yaws])
    t = np.arange(400) / 60.0
    pitch, roll = 1.3 * np.sin(3.0 * t), 0.4 * np.cos(2.0 * t)
    # scipy's intrinsic Z-X-Y: heading, then pitch about the body's own X, then roll about its own Y
    turns = Rotation.from_euler("ZXY", np.column_stack([yaws, pitch, roll])).as_quat()[:, [3, 0, 1, 2]]
    positions, found = virtual_root(with_hips(glide(path, yaws), turns))
    np.testing.assert_allclose(positions, path, atol=1e-12)
    np.testing.assert_allclose(found, yaws, atol=1e-9)


def test_vertical_forward_keeps_the_heading(glide) -> None:
    pitch = np.linspace(0.0, -np.pi / 2.0, 90)
    motion = glide(np.zeros((90, 2)), np.full(90, 0.7))
    turns = quat.multiply(quat.from_yaw(np.full(90, 0.7)), quat.from_axis("X", pitch))
    np.testing.assert_allclose(virtual_root(with_hips(motion, turns))[1], 0.7, atol=1e-9)


def test_smoothing_is_savitzky_golays(glide) -> None:
    rng = np.random.default_rng(5)
    path = rng.normal(size=(200, 2)).cumsum(axis=0) * 0.01
    yaws = 3.0 + rng.normal(size=200).cumsum() * 0.02
    positions, found = virtual_root(glide(path, yaws), 31 / 60)
    np.testing.assert_allclose(positions, signal.savgol_filter(path, 31, 3, axis=0), atol=1e-9)
    ahead = np.column_stack([-np.sin(yaws), np.cos(yaws)])
    smooth = signal.savgol_filter(ahead, 31, 3, axis=0)
    smooth /= np.linalg.norm(smooth, axis=-1, keepdims=True)
    np.testing.assert_allclose(np.column_stack([-np.sin(found), np.cos(found)]), smooth, atol=1e-9)
    assert np.abs(np.diff(found)).max() < 0.5


def test_smoothing_keeps_full_turns(glide) -> None:
    yaws = np.linspace(0.0, 8.0 * np.pi, 600)
    _, found = virtual_root(glide(np.zeros((600, 2)), yaws), 0.25)
    np.testing.assert_allclose(found, yaws, atol=2e-3)


def test_one_frame(glide) -> None:
    positions, yaws = virtual_root(glide(np.ones((1, 2)), np.ones(1)), 0.5)
    np.testing.assert_allclose(positions, 1.0)
    np.testing.assert_allclose(yaws, 1.0)


@given(st.floats(-3, 3), st.lists(st.floats(-5, 5), min_size=3, max_size=3))
def test_root_space_is_the_inverse_rotation(yaw: float, vector: list[float]) -> None:
    world = np.array([vector])
    expected = Rotation.from_euler("Z", yaw).inv().apply(world)
    np.testing.assert_allclose(to_root_space(world, np.array([yaw])), expected, atol=1e-12)
    np.testing.assert_allclose(to_root_space(world[:, :2], np.array([yaw])), expected[:, :2], atol=1e-12)

"""The paper's 42 inputs against closed forms and scipy."""

from __future__ import annotations

import numpy as np
from footwork.core.maths import quat
from footwork.nn.inputs import group_scaler, sixd_to_yaw, tracker_inputs, turn_sixd, yaw_to_sixd
from scipy.spatial.transform import Rotation


def _matrix(q: np.ndarray) -> np.ndarray:
    return Rotation.from_quat(np.roll(q, -1, axis=-1)).as_matrix()


def _walk(frames: int = 60, fps: float = 60.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions, rotations and the head's heading of a body that walks at 1 m/s and turns at 0.5 rad/s."""
    t = np.arange(frames) / fps
    yaw = 0.3 + 0.5 * t
    positions = np.zeros((frames, 3, 3))
    positions[:, :, 1] = t[:, None]
    rotations = np.repeat(quat.from_yaw(yaw)[:, None], 3, axis=1)
    return positions, rotations, yaw


def test_velocities_are_seen_in_the_axes_of_the_headset():
    positions, rotations, yaw = _walk()
    x = tracker_inputs(positions, rotations, 60.0).reshape(-1, 3, 12)
    # +Y in the world is to the right of someone who has turned left
    expected = np.stack([np.sin(yaw), np.cos(yaw), np.zeros_like(yaw)], axis=-1)
    np.testing.assert_allclose(x[:, :, 6:9], np.repeat(expected[:, None], 3, axis=1), atol=1e-9)
    np.testing.assert_allclose(x[:, :, 9:12], np.broadcast_to([0, 0, 0.5], (60, 3, 3)), atol=1e-9)


def test_rotations_are_two_matrix_columns_without_the_heading():
    rng = np.random.default_rng(3)
    rotations = quat.normalize(rng.normal(size=(5, 3, 4)))
    x = tracker_inputs(np.zeros((5, 3, 3)), rotations, 60.0).reshape(5, 3, 12)
    for t in range(5):
        forward = _matrix(rotations[t, 0])[:, 1]
        yaw = np.arctan2(-forward[0], forward[1])
        back = Rotation.from_euler("z", -yaw).as_matrix()
        for k in range(3):
            matrix = back @ _matrix(rotations[t, k])
            np.testing.assert_allclose(x[t, k, :6], np.concatenate([matrix[:, 0], matrix[:, 1]]), atol=1e-9)


def test_velocities_look_back_and_never_ahead():
    positions, rotations, _ = _walk()
    whole = tracker_inputs(positions, rotations, 60.0)
    np.testing.assert_array_equal(whole[:30], tracker_inputs(positions[:30], rotations[:30], 60.0))


def test_turning_the_world_changes_no_input():
    rng = np.random.default_rng(4)
    positions = rng.normal(size=(20, 3, 3))
    rotations = quat.normalize(rng.normal(size=(20, 3, 4)))
    turn = quat.from_yaw(2.0)
    turned = tracker_inputs(quat.rotate(turn, positions), quat.multiply(turn, rotations), 60.0)
    np.testing.assert_allclose(turned, tracker_inputs(positions, rotations, 60.0), atol=1e-9)


def test_six_numbers_of_a_yaw_and_back():
    yaw = np.linspace(-3.1, 3.1, 50)
    np.testing.assert_allclose(sixd_to_yaw(yaw_to_sixd(yaw)), yaw, atol=1e-12)
    np.testing.assert_allclose(turn_sixd(yaw_to_sixd(yaw), 0.7), yaw_to_sixd(yaw + 0.7), atol=1e-12)


def test_a_group_shares_one_deviation_and_a_constant_one_stays_finite():
    rng = np.random.default_rng(5)
    x = np.concatenate([rng.normal(2.0, [1.0, 3.0], (50_000, 2)), np.full((50_000, 2), 7.0)], axis=1)
    scaler = group_scaler(x, (slice(0, 2), slice(2, 4)))
    np.testing.assert_allclose(scaler.mean, [2, 2, 7, 7], atol=0.05)
    np.testing.assert_allclose(scaler.deviation, [2, 2, 1, 1], atol=0.05)

"""Windows: when they look, what they cannot depend on, and mirroring against reflected bodies."""

from __future__ import annotations

import numpy as np
import pytest
from footwork.core.maths import quat
from footwork.core.recording.windows import (
    CAUSAL,
    LOOK_AHEAD,
    WindowLayout,
    mirror_inputs,
    stream,
    take_windows,
    window_inputs,
)

SMALL = WindowLayout(np.array([-0.4, -0.2, -0.1, 0.0, 0.1, 0.2, 0.4]), 3)


def _body(frames: int = 120, seed: int = 2) -> tuple[np.ndarray, np.ndarray]:
    """A smooth random movement of three trackers, metres and unit quaternions."""
    rng = np.random.default_rng(seed)
    t = np.arange(frames)[:, None, None] / 60.0
    wave = np.sin(t * rng.uniform(1, 4, (3, 3)) + rng.uniform(0, 6, (3, 3)))
    positions = 0.3 * wave + np.array([[0, 0, 1.6], [-0.3, 0.2, 1.1], [0.3, 0.2, 1.1]])
    return positions, quat.from_rotation_vector(0.8 * np.roll(wave, 1, axis=1))


def _inputs(positions, rotations, layout=SMALL, head_height=1.6):
    rows = stream(positions, rotations, np.ones((len(positions), 3), bool), head_height)
    windows = take_windows(rows, np.arange(len(rows)) / 60.0, 60.0, layout)
    return window_inputs(windows, quat.heading(rotations[:, 0]), layout)


def test_rotations_are_carried_from_the_moment_outwards():
    np.testing.assert_array_equal(SMALL.turning, [0, 3, 6])
    assert SMALL.inputs == 7 * 13 + 3 * 18
    assert LOOK_AHEAD.centre in LOOK_AHEAD.turning
    assert CAUSAL.centre == len(CAUSAL.offsets) - 1
    assert CAUSAL.causal
    assert not LOOK_AHEAD.causal


def test_place_heading_and_size_of_a_body_do_not_matter():
    positions, rotations = _body()
    expected = _inputs(positions, rotations)
    turn = quat.from_yaw(1.3)
    moved = quat.rotate(turn, positions) + np.array([5.0, -3.0, 0.0])
    np.testing.assert_allclose(_inputs(moved, quat.multiply(turn, rotations)), expected, atol=2e-5)
    np.testing.assert_allclose(
        _inputs(0.85 * positions, rotations, head_height=0.85 * 1.6), expected, atol=2e-6
    )


def test_values_are_those_of_the_axes_of_the_headset():
    positions = np.zeros((5, 3, 3)) + np.array([[0, 0, 1.6], [-0.3, 0.4, 1.0], [0.3, 0.4, 1.0]])
    rotations = np.tile(quat.IDENTITY, (5, 3, 1))
    # the same body, turned a quarter to the left: seen from the headset nothing changes
    turn = quat.from_yaw(np.pi / 2)
    x = _inputs(quat.rotate(turn, positions), quat.multiply(turn, rotations))[2]
    head, hands, facing = (x[group] for group in SMALL.groups[:3])
    np.testing.assert_allclose(head, 0.0, atol=1e-6)
    np.testing.assert_allclose(
        hands.reshape(7, 2, 3)[3] * 1.6, [[-0.3, 0.4, -0.6], [0.3, 0.4, -0.6]], atol=1e-6
    )
    np.testing.assert_allclose(facing.reshape(7, 2)[0], [0.0, 1.0], atol=1e-6)


def test_samples_between_frames_are_linear_and_held_at_the_ends():
    rows = np.zeros((10, 31), np.float32)
    rows[:, 0] = np.arange(10) ** 2
    layout = WindowLayout(np.array([-0.05, 0.0, 0.05]), 1)
    found = take_windows(rows, np.array([0.0, 0.25, 0.9]), 10.0, layout)[..., 0]
    np.testing.assert_allclose(found, [[0, 0, 0.5], [4, 6.5, 9], [72.5, 81, 81]], atol=1e-4)


def test_mirrored_inputs_are_those_of_the_reflected_body():
    positions, rotations = _body()
    swap = [0, 2, 1]
    mirror = np.array([-1.0, 1.0, 1.0])
    matrix = quat.to_matrix(rotations[:, swap]) * mirror[:, None] * mirror
    reflected = _inputs(positions[:, swap] * mirror, quat.from_matrix(matrix))
    np.testing.assert_allclose(mirror_inputs(_inputs(positions, rotations), SMALL), reflected, atol=1e-5)


@pytest.mark.parametrize("tracker", [1, 2])
def test_a_lost_hand_leaves_no_trace(tracker):
    positions, rotations = _body()
    valid = np.ones((len(positions), 3), bool)
    valid[:, tracker] = False
    heading = quat.heading(rotations[:, 0])

    def lost() -> np.ndarray:
        rows = stream(positions, rotations, valid, 1.6)
        return window_inputs(take_windows(rows, np.arange(120) / 60.0, 60.0, SMALL), heading, SMALL)

    before = lost()
    positions[:, tracker] += 7.0
    rotations[:, tracker] = quat.IDENTITY
    np.testing.assert_array_equal(lost(), before)

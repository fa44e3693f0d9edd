"""Mounts, joint targets and simulated trackers against closed forms and each other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.body.motion import Motion
from footwork.core.errors import InputError
from footwork.core.maths import quat
from footwork.core.mocap.demo import demo_motion, demo_skeleton
from footwork.core.recording.mounts import DEVICE_MOUNTS, SIMULATED_MOUNTS, grip_mounts
from footwork.core.recording.simulate import simulate_recording
from footwork.core.recording.targets import joint_targets, scale
from hypothesis import given, settings
from hypothesis import strategies as st

AXES = np.eye(3)
# how a T-pose hand turns to point forward with the thumb up: its own X, Y, Z go to these
HANDSHAKE = {1: np.array([[0, -1, 0], [0, 0, 1], [-1, 0, 0]]), 2: np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]])}


def random_motion(seed: int, frames: int = 12) -> Motion:
    rng = np.random.default_rng(seed)
    skeleton = demo_skeleton(rng.uniform(1.4, 2.1))
    rotations = quat.continuous(quat.normalize(rng.normal(size=(frames, len(skeleton), 4))))
    return Motion(skeleton, 60.0, rng.normal(size=(frames, 3)), rotations)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(-0.2, 0.2), st.floats(0.0, 0.3), st.floats(-1.0, 1.0))
def test_targets_of_simulated_trackers_are_the_joints(
    seed: int, z: float, reach: float, pitch: float
) -> None:
    motion = random_motion(seed)
    mounts = grip_mounts((0.0, 0.1, z), reach, pitch)
    positions, rotations = joint_targets(simulate_recording(motion, "random", mounts))
    true_positions, true_rotations = motion.forward()
    joints = [motion.skeleton.joint(role) for role in ("head", "hand.L", "hand.R")]
    np.testing.assert_allclose(positions, true_positions[:, joints], atol=1e-12)
    dots = np.abs(np.sum(rotations * true_rotations[:, joints], axis=-1))
    np.testing.assert_allclose(dots, 1.0, atol=1e-12)


@pytest.mark.parametrize("side", [1, 2])
def test_a_handshake_is_the_identity_of_a_controller(side: int) -> None:
    turned = quat.rotate(quat.conjugate(SIMULATED_MOUNTS.turns[side]), AXES)
    np.testing.assert_allclose(turned, HANDSHAKE[side], atol=1e-12)
    # and the controller sits on the fingers' side of the wrist: left hand at -X, right at +X
    ahead = quat.rotate(quat.conjugate(SIMULATED_MOUNTS.turns[side]), SIMULATED_MOUNTS.offsets[side])
    np.testing.assert_allclose(ahead, [0.0, 0.08, 0.0], atol=1e-12)


@pytest.mark.parametrize("side", [1, 2])
def test_real_controllers_point_above_the_fingers(side: int) -> None:
    handshake = quat.conjugate(SIMULATED_MOUNTS.turns[side])
    forward = quat.rotate(quat.multiply(handshake, DEVICE_MOUNTS.turns[side]), AXES[1])
    np.testing.assert_allclose(forward, [0.0, np.cos(np.radians(15)), np.sin(np.radians(15))], atol=1e-12)


def test_a_t_pose_gives_the_stated_tracker_places() -> None:
    skeleton = demo_skeleton()
    rotations = np.tile(quat.IDENTITY, (2, len(skeleton), 1))
    recording = simulate_recording(
        Motion(skeleton, 60.0, np.tile(skeleton.offsets[0], (2, 1)), rotations), "t"
    )
    joints = skeleton.tpose_positions()[[skeleton.joint(r) for r in ("head", "hand.L", "hand.R")]]
    away = recording.positions[0] - joints
    np.testing.assert_allclose(away, [[0, 0.1, 0], [-0.08, 0, 0], [0.08, 0, 0]], atol=1e-12)
    assert recording.eye_height == pytest.approx(joints[0, 2])
    np.testing.assert_allclose(recording.times, [0.0, 1 / 60])
    assert recording.valid.all()


def test_scaling_the_recording_scales_the_body_in_it() -> None:
    recording = simulate_recording(demo_motion("turn", 0), "turn", DEVICE_MOUNTS)
    larger = scale(recording, 1.3)
    old, new = joint_targets(recording), joint_targets(larger)
    np.testing.assert_allclose(new[0], 1.3 * old[0], atol=1e-12)
    np.testing.assert_array_equal(new[1], old[1])
    assert larger.eye_height == pytest.approx(1.3 * recording.eye_height)


def test_eye_height_of_a_simulated_recording_can_be_given() -> None:
    assert simulate_recording(demo_motion("turn", 0), "turn", eye_height=1.5).eye_height == 1.5


def test_one_frame_is_no_recording() -> None:
    motion = random_motion(0)
    short = replace(motion, positions=motion.positions[:1], rotations=motion.rotations[:1])
    with pytest.raises(InputError, match="too few"):
        simulate_recording(short, "short")

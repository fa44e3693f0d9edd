from __future__ import annotations

from dataclasses import replace

import numpy as np
from footwork.core.body import forward_kinematics as fk
from footwork.core.body.motion import Motion
from footwork.core.body.skeleton import Skeleton
from footwork.core.database.carry import carry_over, tpose_turns
from footwork.core.maths import quat
from footwork.core.mocap.demo import demo_motion, demo_skeleton
from scipy.spatial.transform import Rotation

RNG = np.random.default_rng(8)


def read_again(motion: Motion, degrees: float) -> tuple[Motion, np.ndarray]:
    """The same movement of the same body told since another T-pose, whose bones are turned by small angles."""
    skeleton = motion.skeleton
    turns = Rotation.from_rotvec(RNG.normal(size=(len(skeleton), 3)) * np.radians(degrees))
    wxyz = turns.as_quat()[:, [3, 0, 1, 2]]
    offsets, tips = skeleton.offsets.copy(), skeleton.tips.copy()
    offsets[1:] = quat.rotate(wxyz[skeleton.parents[1:]], skeleton.offsets[1:])
    tips[:] = quat.rotate(wxyz, skeleton.tips)
    rotations = quat.multiply(motion.forward()[1], quat.conjugate(wxyz))
    other = Skeleton(skeleton.names, skeleton.parents, offsets, skeleton.roles, tips)
    told = Motion(other, motion.fps, motion.positions, fk.local_rotations(rotations, skeleton.parents))
    return told, wxyz


def test_the_fixture_moves_no_joint() -> None:
    motion = demo_motion("walk")
    told, _ = read_again(motion, 8.0)
    np.testing.assert_allclose(told.forward()[0], motion.forward()[0], atol=1e-9)
    assert np.abs(told.skeleton.offsets - motion.skeleton.offsets).max() > 0.01


def test_another_tpose_of_the_same_body_moves_no_joint() -> None:
    motion = demo_motion("walk")
    told, _ = read_again(motion, 8.0)
    back = carry_over(told, motion.skeleton)
    assert back.skeleton is motion.skeleton
    np.testing.assert_allclose(back.forward()[0], motion.forward()[0], atol=1e-6)


def test_joints_with_several_bones_turn_exactly() -> None:
    motion = demo_motion("turn")
    told, turns = read_again(motion, 8.0)
    found = tpose_turns(told.skeleton, motion.skeleton)
    for joint in (0, motion.skeleton.joint("chest")):
        error = quat.to_rotation_vector(quat.multiply(quat.conjugate(turns[joint]), found[joint]))
        assert np.linalg.norm(error) < 1e-5


def test_same_tpose_changes_nothing() -> None:
    skeleton = demo_skeleton()
    np.testing.assert_allclose(tpose_turns(skeleton, skeleton), np.tile(quat.IDENTITY, (23, 1)), atol=1e-9)
    motion = demo_motion("turn")
    same = carry_over(motion, replace(skeleton, names=("a",) * 23))
    np.testing.assert_array_equal(same.rotations, motion.rotations)
    np.testing.assert_array_equal(same.positions, motion.positions)


def test_another_body_is_retargeted() -> None:
    motion, target = demo_motion("turn", height=1.6), demo_skeleton(1.9)
    carried = carry_over(motion, target)
    assert carried.skeleton is target
    ratio = carried.positions[:, 2] / motion.positions[:, 2]
    np.testing.assert_allclose(ratio, 1.9 / 1.6, atol=0.01)
    np.testing.assert_allclose(carried.forward()[1], motion.forward()[1], atol=1e-6)

from __future__ import annotations

import numpy as np
from footwork.core.database.poses import clip_poses, join_poses
from footwork.core.database.virtual_root import virtual_root
from footwork.core.maths import quat
from footwork.core.mocap.demo import demo_motion
from scipy.spatial.transform import Rotation


def poses_of(motion, smoothing: float = 0.0):
    positions, yaws = virtual_root(motion, smoothing)
    return clip_poses(motion, positions, yaws, np.zeros((len(motion), 2), dtype=bool))


def test_root_and_hips_give_the_motion_back() -> None:
    motion = demo_motion("sidestep")
    for smoothing in (0.0, 0.5):
        poses = poses_of(motion, smoothing)
        turn = Rotation.from_rotvec(poses.root_yaws[:, None] * [0, 0, 1])
        hips = turn.apply(poses.hips_positions)
        hips[:, :2] += poses.root_positions
        np.testing.assert_allclose(hips, motion.positions, atol=1e-9)
        own = Rotation.from_quat(poses.rotations[:, 0][:, [1, 2, 3, 0]])
        given = Rotation.from_quat(motion.rotations[:, 0][:, [1, 2, 3, 0]])
        assert ((turn * own).inv() * given).magnitude().max() < 1e-7
        np.testing.assert_array_equal(poses.rotations[:, 1:], motion.rotations[:, 1:])


def test_without_smoothing_hips_stay_over_the_root() -> None:
    poses = poses_of(demo_motion("walk"))
    np.testing.assert_allclose(poses.hips_positions[:, :2], 0.0, atol=1e-12)
    forward = quat.rotate(poses.rotations[:, 0], np.array([0.0, 1.0, 0.0]))
    np.testing.assert_allclose(forward[:, 0], 0.0, atol=1e-12)
    assert (forward[:, 1] > 0.0).all()


def test_steps_add_up_to_the_path() -> None:
    motion = demo_motion("walk")
    poses = poses_of(motion)
    at, yaw = poses.root_positions[0].copy(), poses.root_yaws[0]
    for n in range(len(poses) - 1):
        c, s = np.cos(yaw), np.sin(yaw)
        at += np.array([[c, -s], [s, c]]) @ poses.root_velocities[n] / motion.fps
        yaw += poses.root_yaw_velocities[n] / motion.fps
    np.testing.assert_allclose(at, poses.root_positions[-1], atol=1e-9)
    np.testing.assert_allclose(yaw, poses.root_yaws[-1], atol=1e-9)
    np.testing.assert_array_equal(poses.root_yaw_velocities[-1], poses.root_yaw_velocities[-2])


def test_velocities_of_a_steady_spin(glide) -> None:
    frames = np.arange(240)
    yaws = 0.5 * frames / 60.0
    motion = glide(np.zeros((240, 2)), yaws)
    axis = np.array([1.0, 2.0, -2.0]) / 3.0
    spin = Rotation.from_rotvec(axis * 1.7 * (frames / 60.0)[:, None]).as_quat()[:, [3, 0, 1, 2]]
    motion.rotations[:, 9] = spin
    motion.positions[:, 2] = 0.9 + 0.2 * frames / 60.0
    poses = poses_of(motion)
    np.testing.assert_allclose(poses.angular_velocities[:, 9], np.tile(axis * 1.7, (240, 1)), atol=1e-9)
    np.testing.assert_allclose(poses.angular_velocities[:, 0], 0.0, atol=1e-9)
    np.testing.assert_allclose(poses.root_yaw_velocities, 0.5, atol=1e-9)
    np.testing.assert_allclose(poses.hips_velocities, [[0.0, 0.0, 0.2]] * 240, atol=1e-9)


def test_joined_poses_survive_single_precision() -> None:
    joined = join_poses([poses_of(demo_motion("turn")), poses_of(demo_motion("walk"))])
    assert len(joined) == len(demo_motion("turn")) + len(demo_motion("walk"))
    for values in (joined.rotations, joined.root_positions, joined.angular_velocities):
        assert values.dtype == np.float64
        np.testing.assert_array_equal(values.astype(np.float32), values)
    assert joined.contacts.dtype == np.bool_

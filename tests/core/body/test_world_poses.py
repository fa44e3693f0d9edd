"""Forward kinematics and poses in the world, against scipy's rotations multiplied out joint by joint."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from footwork.core.body import forward_kinematics as fk
from footwork.core.body import pose
from footwork.core.body.motion import Motion
from footwork.core.body.skeleton import Skeleton
from scipy.spatial.transform import Rotation

ATOL = 1e-9


def scipy_of(q: np.ndarray) -> Rotation:
    return Rotation.from_quat(np.roll(q, -1, axis=-1))


def chain(
    root: np.ndarray, rotations: np.ndarray, offsets: np.ndarray, parents: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """World positions `(T, J, 3)` and matrices `(T, J, 3, 3)`, by scipy."""
    places = np.empty((*rotations.shape[:2], 3))
    matrices = np.empty((*rotations.shape[:2], 3, 3))
    for joint, parent in enumerate(parents.tolist()):
        local = scipy_of(rotations[:, joint]).as_matrix()
        matrices[:, joint] = matrices[:, parent] @ local if joint else local
        step = np.broadcast_to(offsets[..., joint, :], (len(root), 3))
        places[:, joint] = (
            places[:, parent] + np.einsum("tij,tj->ti", matrices[:, parent], step) if joint else root
        )
    return places, matrices


def assert_turned(found: np.ndarray, matrices: np.ndarray) -> None:
    np.testing.assert_allclose(np.linalg.norm(found, axis=-1), 1.0, atol=1e-12)
    flat = scipy_of(found.reshape(-1, 4)).as_matrix()
    np.testing.assert_allclose(flat.reshape(matrices.shape), matrices, atol=ATOL)


@pytest.mark.parametrize("frames", [1, 2, 25])
def test_forward_is_the_product_down_the_chain(crooked, moved, frames: int) -> None:
    motion: Motion = moved(crooked(3), frames)
    body = motion.skeleton
    places, matrices = chain(motion.positions, motion.rotations, body.offsets, body.parents)
    for positions, rotations in (
        motion.forward(),
        fk.forward(motion.positions, motion.rotations, body.offsets, body.parents),
    ):
        np.testing.assert_allclose(positions, places, atol=ATOL)
        assert_turned(rotations, matrices)
    assert_turned(fk.global_rotations(motion.rotations, body.parents), matrices)


def test_offsets_may_change_and_that_of_the_root_is_not_used(crooked, moved) -> None:
    motion: Motion = moved(crooked())
    body = motion.skeleton
    offsets = body.offsets * np.linspace(0.7, 1.4, len(motion))[:, None, None]
    places, matrices = chain(motion.positions, motion.rotations, offsets, body.parents)
    offsets[:, 0] = np.nan
    positions, rotations = fk.forward(motion.positions, motion.rotations, offsets, body.parents)
    np.testing.assert_allclose(positions, places, atol=ATOL)
    positions = fk.joint_positions(motion.positions, rotations, offsets, body.parents)
    np.testing.assert_allclose(positions, places, atol=ATOL)
    assert_turned(rotations, matrices)


def test_single_precision_is_carried_down_in_full_precision(crooked, moved) -> None:
    motion: Motion = moved(crooked())
    small = motion.rotations.astype(np.float32)
    found = fk.global_rotations(small, motion.skeleton.parents)
    assert found.dtype == np.float64
    np.testing.assert_allclose(
        found, fk.global_rotations(motion.rotations, motion.skeleton.parents), atol=1e-5
    )


def test_local_rotations_lead_back_and_are_continuous(crooked, moved) -> None:
    motion: Motion = moved(crooked(), 90)
    parents = motion.skeleton.parents
    world = fk.global_rotations(motion.rotations, parents)
    # signs at random must not come through
    world *= np.random.default_rng(0).choice([-1.0, 1.0], (*world.shape[:2], 1))
    before = world.copy()
    local = fk.local_rotations(world, parents)
    np.testing.assert_array_equal(world, before)
    np.testing.assert_allclose(np.abs(np.sum(local * motion.rotations, axis=-1)), 1.0, atol=1e-12)
    assert (np.sum(local[1:] * local[:-1], axis=-1) > 0.0).all()
    np.testing.assert_allclose(local[0, 0], world[0, 0])


@pytest.mark.parametrize("roles", [("hand.L",), ("head", "foot.R", "hips"), ("toe.L", "thigh.L")])
def test_poses_of_some_joints_are_those_of_the_whole_body(crooked, moved, roles: tuple[str, ...]) -> None:
    motion: Motion = moved(crooked(5))
    body = motion.skeleton
    places, matrices = chain(motion.positions, motion.rotations, body.offsets, body.parents)
    joints = [body.joint(role) for role in roles]
    positions, rotations = pose.role_poses(motion, roles)
    np.testing.assert_allclose(positions, places[:, joints], atol=ATOL)
    assert_turned(rotations, matrices[:, joints])

    wanted = set(joints)
    for joint in joints:
        while joint:
            joint = int(body.parents[joint])
            wanted.add(joint)
    found, turned = pose.world_poses(motion, joints)
    assert set(found) == set(turned) == wanted
    for joint in wanted:
        np.testing.assert_allclose(found[joint], places[:, joint], atol=ATOL)
        assert_turned(turned[joint], matrices[:, joint])


def in_world(motion: Motion) -> np.ndarray:
    body = motion.skeleton
    return chain(motion.positions, motion.rotations, body.offsets, body.parents)[1]


@pytest.mark.parametrize(
    "roles", [("hips",), ("shin.L",), ("head", "chest", "hand.R"), ("hips", "foot.L", "spine1"), ()]
)
def test_joints_take_the_world_rotations_that_are_wanted(
    crooked: Callable[..., Skeleton], moved, tumble, roles: tuple[str, ...]
) -> None:
    motion: Motion = moved(crooked(7), 60)
    body = motion.skeleton
    rng = np.random.default_rng(1)
    given = dict(
        zip([body.joint(role) for role in roles], np.moveaxis(tumble(60, 60.0, 5, 9), 1, 0), strict=False)
    )
    signs = rng.choice([-1.0, 1.0], (60, 1))
    before = motion.rotations.copy()
    result = pose.with_world_rotations(motion, {joint: turn * signs for joint, turn in given.items()})
    np.testing.assert_array_equal(motion.rotations, before)
    assert result.skeleton is body and result.fps == motion.fps
    np.testing.assert_array_equal(result.positions, motion.positions)
    matrices = in_world(result)
    for joint, turn in given.items():
        np.testing.assert_allclose(matrices[:, joint], scipy_of(turn).as_matrix(), atol=ATOL)
        smooth = result.rotations[:, joint]
        assert (np.sum(smooth[1:] * smooth[:-1], axis=-1) > 0.0).all()
    others = [joint for joint in range(len(body)) if joint not in given]
    np.testing.assert_array_equal(result.rotations[:, others], before[:, others])


def test_hips_may_be_put_elsewhere(crooked, moved) -> None:
    motion: Motion = moved(crooked())
    places = motion.positions[::-1] + 3.0
    result = pose.with_world_rotations(motion, {}, places)
    np.testing.assert_array_equal(result.positions, places)
    np.testing.assert_array_equal(result.rotations, motion.rotations)


def test_a_skeleton_knows_its_joints_and_measures(crooked) -> None:
    for seed in (None, 1, 2):
        body: Skeleton = crooked(seed)
        assert len(body) == 23
        for joint, role in enumerate(body.roles):
            if role:
                assert body.find(role) == body.joint(role) == joint
        assert body.find("toe.R") == -1
        with pytest.raises(KeyError, match=r"toe\.R"):
            body.joint("toe.R")
        rest = np.tile([1.0, 0.0, 0.0, 0.0], (1, 23, 1))
        standing, _ = chain(body.offsets[None, 0], rest, body.offsets, body.parents)
        np.testing.assert_allclose(body.tpose_positions(), standing[0], atol=1e-15)
        # by hand from the table: thigh to knee and knee to ankle, a twist joint or not
        left = np.linalg.norm([0.03, 0.01, -0.42]) + np.linalg.norm([-0.03, -0.03, -0.4])
        right = np.linalg.norm([0.01, 0.03, -0.41]) + np.linalg.norm([0.02, -0.05, -0.39])
        assert body.leg_length() == pytest.approx((left + right) / 2.0, abs=1e-12)

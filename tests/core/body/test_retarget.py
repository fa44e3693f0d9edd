"""Retargeting: what must hold between any two bodies, and scaled bodies whose answer is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.body.motion import Motion
from footwork.core.body.retarget import pelvis, retarget, spine
from footwork.core.body.skeleton import Skeleton
from footwork.core.mocap.demo import demo_skeleton
from scipy.spatial.transform import Rotation, Slerp


def scaled(skeleton: Skeleton, factor: float) -> Skeleton:
    return replace(skeleton, offsets=skeleton.offsets * factor, tips=skeleton.tips * factor)


def test_the_same_body_takes_the_motion_as_it_is(walk: Motion) -> None:
    copy = replace(walk.skeleton, offsets=walk.skeleton.offsets.copy())
    assert retarget(walk, copy) is walk


def test_a_scaled_body_does_the_scaled_motion(walk: Motion) -> None:
    small = scaled(walk.skeleton, 0.8)
    moved = retarget(walk, small, scale_travel=True)
    np.testing.assert_allclose(moved.forward()[0], 0.8 * walk.forward()[0], atol=1e-9)


def test_travel_stays_in_metres_by_default(walk: Motion) -> None:
    moved = retarget(walk, scaled(walk.skeleton, 0.8))
    steps = [np.diff(m.positions[:, :2], axis=0) for m in (moved, walk)]
    np.testing.assert_allclose(steps[0], steps[1], atol=2e-3)
    np.testing.assert_allclose(moved.positions[:, 2], 0.8 * walk.positions[:, 2], atol=1e-9)


@pytest.mark.parametrize(
    "parts",
    [(), ("clavicle", "toe"), ("neck",), ("spine2", "spine3"), ("spine1", "spine2", "spine3", "chest")],
)
def test_joints_with_the_same_role_turn_alike_in_the_world(
    parts: tuple[str, ...], without, random_pose, degrees_between, world
) -> None:
    target = without(scaled(demo_skeleton(), 0.9), *parts)
    motion = random_pose(demo_skeleton(), 20)
    moved = retarget(motion, target)
    for role in ("hips", "head", "upper_arm.L", "forearm.R", "hand.L", "thigh.R", "shin.L", "foot.R"):
        assert degrees_between(world(motion, role)[1], world(moved, role)[1]).max() < 1e-5
    if "chest" not in parts:
        assert degrees_between(world(motion, "chest")[1], world(moved, "chest")[1]).max() < 1e-5


@pytest.mark.parametrize("parts", [("clavicle", "toe"), ("neck",), ("spine1", "spine2", "spine3", "chest")])
def test_joints_that_the_source_lacks_follow_their_parent(
    parts: tuple[str, ...], without, random_pose, degrees_between, world
) -> None:
    full = demo_skeleton()
    motion = random_pose(without(full, *parts), 10)
    moved = retarget(motion, full)
    for role in ("hips", "head", "hand.R", "foot.L"):
        assert degrees_between(world(motion, role)[1], world(moved, role)[1]).max() < 1e-5
    if "toe" in parts:
        np.testing.assert_allclose(moved.rotations[:, full.joint("toe.L")], [[1, 0, 0, 0]] * 10)
        np.testing.assert_allclose(moved.rotations[:, full.joint("clavicle.R")], [[1, 0, 0, 0]] * 10)


def test_a_spine_of_other_joints_is_read_along_its_length(
    without, random_pose, turns, degrees_between, world
) -> None:
    source = demo_skeleton()
    motion = random_pose(source, 1)
    rotations = np.tile([1.0, 0, 0, 0], (1, len(source), 1))
    for joint, angle in zip(spine(source)[1:], (0.3, 0.2, 0.1, 0.2), strict=True):
        rotations[0, joint] = [np.cos(angle / 2), 0, 0, np.sin(angle / 2)]
    motion = replace(motion, rotations=rotations)
    target = without(source, "spine1", "spine3")
    moved = retarget(motion, target)

    heights = source.tpose_positions()[spine(source), 2]
    given = motion.forward()[1][0][spine(source)]
    place = target.tpose_positions()[target.joint("spine2"), 2]
    wanted = Slerp(heights, turns(given))(place)
    got = turns(world(moved, "spine2")[1])[0]
    assert np.degrees((wanted * got.inv()).magnitude()) < 1e-6
    assert degrees_between(world(motion, "chest")[1], world(moved, "chest")[1]).max() < 1e-6


def test_what_thighs_hang_from_moves_with_the_hips(walk: Motion, world) -> None:
    body = walk.skeleton
    parents = body.parents.copy()
    offsets = body.offsets.copy()
    for side in "LR":
        thigh = body.joint(f"thigh.{side}")
        parents[thigh] = body.joint("spine1")
        offsets[thigh] -= body.offsets[body.joint("spine1")]
    biped = replace(body, parents=parents, offsets=offsets)
    assert [biped.roles[j] for j in pelvis(biped)] == ["hips", "spine1"]
    moved = retarget(walk, biped)
    for role in ("thigh.L", "foot.R", "toe.L"):
        np.testing.assert_allclose(world(moved, role)[0], world(walk, role)[0], atol=1e-9)


def test_feet_of_other_proportions_stay_on_the_floor(walk: Motion, world) -> None:
    target = scaled(walk.skeleton, 1.1)
    offsets = target.offsets.copy()
    for side in "LR":
        offsets[target.joint(f"shin.{side}")] *= 1.15
    offsets[0, 2] += 0.15 * np.linalg.norm(target.offsets[target.joint("shin.L")])
    target = replace(target, offsets=offsets)
    toes = world(retarget(walk, target), "toe.L")[0][:, 2]
    assert abs(np.median(toes) - target.tpose_positions()[target.joint("toe.L"), 2]) < 0.02


def test_signs_are_continuous(without) -> None:
    frames = 200
    skeleton = demo_skeleton()
    angle = np.linspace(0.0, 6.0 * np.pi, frames)
    rotations = np.tile([1.0, 0, 0, 0], (frames, len(skeleton), 1))
    rotations[:, 0] = np.roll(Rotation.from_rotvec(angle[:, None] * [0, 0, 1.0]).as_quat(), 1, axis=-1)
    flips = np.sum(rotations[1:, 0] * rotations[:-1, 0], axis=-1, keepdims=True) < 0
    rotations[1:, 0] *= np.where(np.cumsum(flips, axis=0) % 2 == 1, -1.0, 1.0)
    motion = Motion(skeleton, 60.0, np.tile([0.0, 0.0, 0.9], (frames, 1)), rotations)
    moved = retarget(motion, without(scaled(skeleton, 0.9), "spine2"))
    assert (np.sum(moved.rotations[1:] * moved.rotations[:-1], axis=-1) > 0.9).all()

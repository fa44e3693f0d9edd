"""Retargeting: what must hold between any two bodies, and scaled bodies whose answer is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.body.motion import Motion
from footwork.core.body.retarget import pelvis, retarget, same_skeleton, spine
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


def thighs(motion: Motion) -> np.ndarray:
    """Middle of the thigh joints in the world `(T, 3)`."""
    positions, _ = motion.forward()
    return positions[:, [motion.skeleton.joint(f"thigh.{side}") for side in "LR"]].mean(axis=1)


@pytest.mark.parametrize("scale_travel", [False, True])
def test_the_middle_of_the_thighs_takes_its_way_by_leg_length(
    crooked, unequal, moved, scale_travel: bool
) -> None:
    for source, target in ((crooked(2), unequal(1.5)), (unequal(1.9), crooked())):
        motion = moved(source, 12)
        result = retarget(motion, target, scale_travel=scale_travel)
        assert result.skeleton is target and result.fps == motion.fps and len(result) == 12
        ratio = target.leg_length() / source.leg_length()
        expected = thighs(motion) * ([ratio, ratio, 1.0] if scale_travel else 1.0)
        rest = [
            body.tpose_positions()[[body.joint("thigh.L"), body.joint("thigh.R")], 2].mean()
            for body in (source, target)
        ]
        expected[:, 2] = rest[1] + ratio * (expected[:, 2] - rest[0])
        np.testing.assert_allclose(thighs(result), expected, atol=1e-9)


def test_any_two_bodies_share_the_world_rotations_of_their_roles(
    crooked, unequal, moved, degrees_between, world
) -> None:
    for source, target in ((crooked(2), unequal()), (unequal(), crooked(5)), (crooked(1), crooked(3))):
        motion = moved(source)
        result = retarget(motion, target)
        np.testing.assert_allclose(np.linalg.norm(result.rotations, axis=-1), 1.0, atol=1e-12)
        for role in set(source.roles) & set(target.roles) - {"", "spine1", "spine2", "spine3", "neck"}:
            assert degrees_between(world(motion, role)[1], world(result, role)[1]).max() < 1e-5, role
        _, turned = result.forward()
        for joint, role in enumerate(target.roles):
            chain = target.names[joint] in ("pelvis", "between", "atlas") or role in (
                "spine2",
                "spine3",
                "neck",
            )
            if (not role or role not in source.roles) and not chain:
                above = int(target.parents[joint])
                assert degrees_between(turned[:, joint], turned[:, above]).max() < 1e-5
                np.testing.assert_allclose(
                    result.rotations[:, joint], [[1.0, 0, 0, 0]] * len(result), atol=1e-7
                )


def share_along(skeleton: Skeleton, chain: list[int]) -> np.ndarray:
    steps = np.linalg.norm(skeleton.offsets[chain[1:]], axis=-1)
    return np.r_[0.0, np.cumsum(steps)] / steps.sum()


def test_a_spine_turns_in_shares_of_its_length(crooked, without, moved, turns) -> None:
    """Between two joints of the source the target's turns are scipy's, at the same share of the chain's length."""
    source = crooked()
    target = without(source, "spine1")
    motion = moved(source, 8)
    result = retarget(motion, target)
    _, given = motion.forward()
    _, got = result.forward()
    names = ("pelvis", "back", "between", "breast")
    chain = [source.names.index(name) for name in names]
    own = [target.names.index(name) for name in names if name in target.names]
    knots, places = share_along(source, chain), share_along(target, own)
    for joint, place in zip(own, places, strict=True):
        for frame in range(8):
            wanted = Slerp(knots, turns(given[frame, chain]))(place)
            assert (wanted * turns(got[frame, joint]).inv()).magnitude() < 1e-6


def test_a_spine_bone_without_length_is_passed_over(crooked, without, moved, degrees_between, world) -> None:
    source = crooked()
    offsets = source.offsets.copy()
    offsets[source.names.index("between")] = 0.0
    motion = moved(replace(source, offsets=offsets))
    result = retarget(motion, without(source, "spine1"))
    assert np.isfinite(result.rotations).all() and np.isfinite(result.positions).all()
    assert degrees_between(world(motion, "chest")[1], world(result, "chest")[1]).max() < 1e-5


@pytest.mark.parametrize("what", ["names", "roles", "parents", "offsets"])
def test_skeletons_are_the_same_only_in_every_respect(crooked, what: str) -> None:
    body = crooked()
    twin = crooked()
    assert same_skeleton(body, twin) and same_skeleton(body, body)
    changed = {
        "names": ("root", *body.names[1:]),
        "roles": (*body.roles[:-1], ""),
        "parents": np.r_[body.parents[:-1], 3],
        "offsets": body.offsets + 1e-9,
    }
    assert not same_skeleton(body, replace(twin, **{what: changed[what]}))

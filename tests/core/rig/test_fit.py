"""Rigs to skeletons and back, against Blender's formulas written out in 4x4 matrices."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.body.motion import Motion
from footwork.core.errors import InputError
from footwork.core.mocap.demo import demo_skeleton
from footwork.core.rig.fit import fit_rig, rig_from_skeleton
from footwork.core.rig.keys import to_bone_tracks
from footwork.core.rig.rig import BoneTracks, Rig
from scipy.spatial.transform import Rotation

SKELETON = demo_skeleton()


def placed(rig: Rig, scale: float = 0.01, euler: tuple[float, float, float] = (90.0, 0.0, 30.0)) -> Rig:
    """The same rig as an importer leaves it: in other units and axes, its object scaled, turned and moved."""
    world = np.eye(4)
    world[:3, :3] = scale * Rotation.from_euler("xyz", euler, degrees=True).as_matrix()
    world[:3, 3] = [2.0, -1.0, 0.0]
    back = np.linalg.inv(world[:3, :3])
    rest = rig.rest.copy()
    rest[:, :3, :3] = back @ rig.rest[:, :3, :3] * scale
    rest[:, :3, 3] = rig.rest[:, :3, 3] @ back.T
    return replace(rig, rest=rest, tails=rig.tails @ back.T, world=world)


def turned_axes(rig: Rig) -> Rig:
    """Each bone with axes of its own, where importers leave them."""
    rest = rig.rest.copy()
    rest[:, :3, :3] = Rotation.random(len(rest), rng=np.random.default_rng(5)).as_matrix()
    return replace(rig, rest=rest)


def with_extra_bones(rig: Rig) -> Rig:
    """A root above the hips, a helper between upper arm and forearm, a finger."""
    root = np.eye(4)
    root[:3, :3] = Rotation.from_euler("x", 90, degrees=True).as_matrix()
    left, right = rig.bones.index("LeftElbow"), rig.bones.index("RightWrist")
    helper, finger = rig.rest[left - 1].copy(), rig.rest[right].copy()
    helper[:3, :3] = helper[:3, :3] @ Rotation.from_euler("y", 40, degrees=True).as_matrix()
    helper[:3, 3] = rig.rest[[left - 1, left], :3, 3].mean(axis=0)
    finger[:3, 3] += [0.1, 0, 0]
    names, parents, rest, roles = ["root"], [-1], [root], [""]
    at = {}
    for b, name in enumerate(rig.bones):
        above = at[int(rig.parents[b])] if rig.parents[b] >= 0 else 0
        if b == left:
            names.append("helper")
            parents.append(above)
            rest.append(helper)
            roles.append("")
            above = len(names) - 1
        at[b] = len(names)
        names.append(name)
        parents.append(above)
        rest.append(rig.rest[b])
        roles.append(rig.roles[b])
    names.append("finger")
    parents.append(at[right])
    rest.append(finger)
    roles.append("")
    return Rig(
        "more",
        tuple(names),
        np.array(parents),
        np.array(rest),
        np.zeros((len(names), 3)),
        rig.world,
        tuple(roles),
    )


def pose_matrices(rig: Rig, tracks: BoneTracks, frame: int) -> np.ndarray:
    """World matrices of all bones: `object @ parent_pose @ parent_rest^-1 @ rest @ basis`."""
    poses = np.empty((len(rig.bones), 4, 4))
    for b, name in enumerate(rig.bones):
        basis = np.eye(4)
        if name in tracks.bones:
            q = tracks.rotations[frame, tracks.bones.index(name)]
            basis[:3, :3] = Rotation.from_quat(np.roll(q, -1)).as_matrix()
        if name == tracks.bones[0]:
            basis[:3, 3] = tracks.locations[frame]
        p = int(rig.parents[b])
        above = poses[p] @ np.linalg.inv(rig.rest[p]) if p >= 0 else np.eye(4)
        poses[b] = above @ rig.rest[b] @ basis
    return rig.world @ poses


@pytest.mark.parametrize(
    "make",
    [
        lambda r: r,
        placed,
        turned_axes,
        with_extra_bones,
        lambda r: placed(with_extra_bones(r)),
        lambda r: placed(turned_axes(with_extra_bones(r))),
    ],
)
def test_bones_end_where_the_motion_has_its_joints(make, random_pose) -> None:
    rig = make(rig_from_skeleton(SKELETON, "rig"))
    fit = fit_rig(rig)
    motion = random_pose(fit.skeleton, 4)
    if "helper" in rig.bones:
        motion.rotations[:, fit.skeleton.names.index("helper")] = [1.0, 0, 0, 0]
    tracks = to_bone_tracks(motion, fit, motion.fps)
    assert "helper" not in tracks.bones and "root" not in tracks.bones
    wanted, turned = motion.forward()
    for frame in range(4):
        got = pose_matrices(rig, tracks, frame)[fit.bones]
        np.testing.assert_allclose(got[:, :3, 3], wanted[frame], atol=1e-9)
        # what the bone's rotation is since T-pose must be the motion's, whatever the bone's own axes
        standing = Rotation.from_quat(np.roll(fit.tpose, -1, axis=-1)).as_matrix()
        since = got[:, :3, :3] / fit.scale @ np.swapaxes(standing, 1, 2)
        now = Rotation.from_quat(np.roll(turned[frame], -1, axis=-1)).as_matrix()
        np.testing.assert_allclose(since, now, atol=1e-6)


@pytest.mark.parametrize("scale", [1.0, 0.01, 100.0])
@pytest.mark.parametrize("euler", [(0, 0, 0), (90, 0, 0), (0, 0, -135), (-90, 20, 60)])
def test_the_object_does_not_change_the_body(scale: float, euler: tuple[float, float, float]) -> None:
    fit = fit_rig(placed(rig_from_skeleton(SKELETON, "rig"), scale, euler))
    if euler[1]:
        # a body that lies on its side at rest: upright all the same, only its floor is unknown
        np.testing.assert_allclose(fit.skeleton.offsets[1:], SKELETON.offsets[1:], atol=1e-6)
    else:
        np.testing.assert_allclose(fit.skeleton.offsets, SKELETON.offsets, atol=1e-6)


def test_arms_that_hang_at_rest_are_the_same_body() -> None:
    rig = rig_from_skeleton(SKELETON, "rig")
    rest = rig.rest.copy()
    for side, sign in (("L", 1), ("R", -1)):
        shoulder = rig.roles.index(f"upper_arm.{side}")
        # the rig faces -Y, so its left is at +X: arms go down about Y
        turn = np.eye(4)
        turn[:3, :3] = Rotation.from_euler("y", 45 * sign, degrees=True).as_matrix()
        pivot = np.eye(4)
        pivot[:3, 3] = rest[shoulder, :3, 3]
        for part in ("upper_arm", "forearm", "hand"):
            bone = rig.roles.index(f"{part}.{side}")
            rest[bone] = pivot @ turn @ np.linalg.inv(pivot) @ rest[bone]
    assert rest[rig.roles.index("hand.L"), 2, 3] < rig.rest[rig.roles.index("hand.L"), 2, 3] - 0.3
    fit = fit_rig(replace(rig, rest=rest))
    np.testing.assert_allclose(fit.skeleton.offsets, SKELETON.offsets, atol=1e-6)


def test_an_armature_is_mirrored_as_blender_wants_it() -> None:
    rig = rig_from_skeleton(SKELETON, "rig")
    np.testing.assert_allclose(np.linalg.det(rig.rest[:, :3, :3]), 1.0)
    along = rig.tails - rig.rest[:, :3, 3]
    np.testing.assert_allclose(
        rig.rest[:, :3, 1], along / np.linalg.norm(along, axis=1, keepdims=True), atol=1e-12
    )
    flip = np.diag([-1.0, 1.0, 1.0])
    for role in ("upper_arm", "hand", "thigh", "shin", "foot", "toe", "clavicle"):
        left, right = (rig.rest[rig.roles.index(f"{role}.{side}"), :3, :3] for side in "LR")
        np.testing.assert_allclose(right, flip @ left @ flip, atol=1e-9)
    # facing -Y: toes in front, the left side at +X
    assert rig.rest[rig.roles.index("toe.L"), 1, 3] < 0 < rig.rest[rig.roles.index("toe.L"), 0, 3]


def test_rest_is_no_turn_but_the_facing() -> None:
    fit = fit_rig(rig_from_skeleton(SKELETON, "rig"))
    standing = np.tile([1.0, 0, 0, 0], (1, len(SKELETON), 1))
    tracks = to_bone_tracks(Motion(fit.skeleton, 60.0, fit.skeleton.offsets[:1], standing), fit, 60.0)
    np.testing.assert_allclose(np.abs(tracks.rotations[0, 1:, 0]), 1.0, atol=1e-9)
    np.testing.assert_allclose(tracks.locations[0], 0.0, atol=1e-9)
    half_turn = Rotation.from_quat(np.roll(tracks.rotations[0, 0], -1)).magnitude()
    assert half_turn == pytest.approx(np.pi, abs=1e-6)


@pytest.mark.parametrize("fps", [24.0, 30.0, 60.0, 29.97, 120.0])
def test_tracks_at_another_rate_cover_the_motion(walk: Motion, fps: float) -> None:
    fit = fit_rig(rig_from_skeleton(walk.skeleton, "rig"))
    tracks = to_bone_tracks(walk, fit, fps)
    assert tracks.fps == fps
    assert 0 <= (len(walk) - 1) / walk.fps - (len(tracks.locations) - 1) / fps < 1 / fps + 1e-9
    assert (np.sum(tracks.rotations[1:] * tracks.rotations[:-1], axis=-1) > 0.5).all()
    frame = 24
    exact = frame / fps * walk.fps
    if exact == round(exact):
        back = pose_matrices(fit.rig, tracks, frame)[fit.bones][:, :3, 3]
        np.testing.assert_allclose(back, walk.forward()[0][round(exact)], atol=1e-9)


def _changed(**fields) -> Rig:
    return replace(rig_from_skeleton(SKELETON, "Hero"), **fields)


def _roles(**changes: str) -> tuple[str, ...]:
    return tuple(changes.get(role.replace(".", "_"), role) for role in SKELETON.roles)


@pytest.mark.parametrize(
    ("rig", "words"),
    [
        (_changed(world=np.diag([1.0, 1.0, 2.0, 1.0])), "scaled unevenly (1, 1, 2)"),
        (_changed(world=np.diag([-1.0, 1.0, 1.0, 1.0])), "mirrored"),
        (_changed(world=np.diag([0.0, 0.0, 0.0, 1.0])), "scale is zero"),
        (_changed(roles=_roles(hand_L="", head="")), "no bone for head, hand.L"),
        (_changed(roles=_roles(neck="head")), "2 bones have the role head"),
        (_changed(roles=_roles(neck="nose")), "'nose' is no joint role"),
        (_changed(roles=_roles(hips="spine1", spine1="hips")), "is not below the hips bone"),
        (_changed(rest=np.tile(np.eye(4), (23, 1, 1))), "upper_arm.L and forearm.L are at the same place"),
    ],
)
def test_a_rig_that_cannot_be_used_is_told_in_one_line(rig: Rig, words: str) -> None:
    with pytest.raises(InputError) as error:
        fit_rig(rig)
    assert (
        words in str(error.value) and str(error.value).startswith("Hero: ") and "\n" not in str(error.value)
    )


TOWARDS = {
    "head": [0, 0, 1],
    "hand.L": [1, 0, 0],
    "hand.R": [-1, 0, 0],
    "toe.L": [0, -1, 0],
    "toe.R": [0, -1, 0],
}
"""Where last bones point in an armature that faces -Y."""
HALF_TURN = np.array([-1.0, -1.0, 1.0])
"""A half turn about Z: from an armature that faces -Y to a skeleton that faces +Y."""


def leaning(towards: np.ndarray, degrees: float, seed: int) -> np.ndarray:
    """A unit vector at an angle to another one, on any side of it."""
    side = np.cross(towards, np.random.default_rng(seed).normal(size=3))
    side /= np.linalg.norm(side)
    return np.cos(np.radians(degrees)) * towards + np.sin(np.radians(degrees)) * side


@pytest.mark.parametrize("make", [lambda r: r, placed, lambda r: placed(turned_axes(r))])
@pytest.mark.parametrize("degrees", [10.0, 55.0, 65.0, 120.0])
def test_tips_are_tails_of_last_bones_that_point_where_such_bones_do(make, degrees: float) -> None:
    rig = rig_from_skeleton(SKELETON, "rig")
    tails, ways = rig.tails.copy(), {}
    for k, (role, towards) in enumerate(TOWARDS.items()):
        bone = rig.roles.index(role)
        ways[role] = 0.07 * (1 + k) * leaning(np.array(towards, float), degrees, k)
        tails[bone] = rig.rest[bone, :3, 3] + ways[role]
    fit = fit_rig(make(replace(rig, tails=tails)))
    for role, tip in zip(fit.skeleton.roles, fit.skeleton.tips, strict=True):
        known = role in ways and degrees < 60.0
        np.testing.assert_allclose(tip, ways[role] * HALF_TURN if known else np.zeros(3), atol=1e-6)


def test_feet_without_toes_have_their_tails_as_tips(without) -> None:
    rig = rig_from_skeleton(without(SKELETON, "toe"), "rig")
    tails = rig.tails.copy()
    left, right = (rig.roles.index(f"foot.{side}") for side in "LR")
    tails[left] = rig.rest[left, :3, 3] + [0.03, -0.14, -0.08]
    tails[right] = rig.rest[right, :3, 3] + [0.02, 0.14, -0.05]
    skeleton = fit_rig(replace(rig, tails=tails)).skeleton
    np.testing.assert_allclose(skeleton.tips[skeleton.joint("foot.L")], [-0.03, 0.14, -0.08], atol=1e-6)
    np.testing.assert_array_equal(skeleton.tips[skeleton.joint("foot.R")], 0.0)


def test_one_end_bone_tells_more_than_a_tail() -> None:
    rig = rig_from_skeleton(SKELETON, "rig")
    head = rig.roles.index("head")
    end = rig.rest[head].copy()
    end[:3, 3] += [0.01, -0.02, 0.21]
    rig = Rig(
        "rig",
        (*rig.bones, "HeadEnd"),
        np.append(rig.parents, head),
        np.concatenate([rig.rest, end[None]]),
        np.concatenate([rig.tails, end[None, :3, 3]]),
        rig.world,
        (*rig.roles, ""),
    )
    skeleton = fit_rig(replace(rig, tails=rig.tails + 0.3)).skeleton
    np.testing.assert_allclose(skeleton.tips[skeleton.joint("head")], [-0.01, 0.02, 0.21], atol=1e-6)


def test_bones_whose_end_nothing_tells_are_short_and_point_where_such_bones_do(without) -> None:
    leg = sum(np.linalg.norm(SKELETON.offsets[SKELETON.joint(f"{part}.L")]) for part in ("shin", "foot"))
    for skeleton in (SKELETON, without(SKELETON, "toe")):
        rig = rig_from_skeleton(replace(skeleton, tips=np.zeros_like(skeleton.tips)), "rig")
        along = rig.tails - rig.rest[:, :3, 3]
        wanted = {"head": np.array([0.0, 0.0, 0.25 * leg])}
        for side in "LR":
            forearm = skeleton.offsets[skeleton.joint(f"hand.{side}")] * HALF_TURN
            wanted[f"hand.{side}"] = 0.1 * leg * forearm / np.linalg.norm(forearm)
            end = "toe" if f"toe.{side}" in skeleton.roles else "foot"
            wanted[f"{end}.{side}"] = np.array([0.0, -0.1 * leg, 0.0])
        for role, vector in wanted.items():
            np.testing.assert_allclose(along[rig.roles.index(role)], vector, atol=1e-9, err_msg=role)


@pytest.mark.parametrize(("sole", "counts"), [(0.062, True), (0.0, True), (-0.1, False), (0.6, False)])
def test_the_soles_of_a_mesh_stand_on_the_floor(sole: float, counts: bool) -> None:
    rig = placed(rig_from_skeleton(SKELETON, "rig"))
    plain, shod = (fit_rig(each).skeleton.tpose_positions()[:, 2] for each in (rig, replace(rig, sole=sole)))
    toes = [SKELETON.joint("toe.L"), SKELETON.joint("toe.R")]
    wanted = sole if counts else plain[toes].mean()
    assert shod[toes].mean() == pytest.approx(wanted, abs=1e-9)

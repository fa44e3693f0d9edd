"""Rigs whose limbs do not hang as a body's: keys that bring every bone to its joint all the same."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.errors import InputError
from footwork.core.mocap.demo import demo_skeleton
from footwork.core.rig.fit import fit_rig, rig_from_skeleton
from footwork.core.rig.gate import check_tracks
from footwork.core.rig.keys import to_bone_tracks
from footwork.core.rig.limbs import whole_limbs
from footwork.core.rig.rig import BoneTracks, Rig
from scipy.spatial.transform import Rotation

SKELETON = demo_skeleton(1.71)


def hung(moves: dict[str, str]) -> Rig:
    """A rig of tilted bones under a root, some of which hang on other bones; parents come first all the same."""
    rig = rig_from_skeleton(SKELETON, "rig")
    rng = np.random.default_rng(4)
    rest = rig.rest.copy()
    rest[:, :3, :3] = Rotation.random(len(rest), random_state=rng).as_matrix()
    root = np.eye(4)
    root[:3, 3] = [0.2, 0.1, 0.3]
    bones, roles = ["root", *rig.bones], ["", *rig.roles]
    parents = [-1, *(rig.parents + 1).tolist()]
    for role, above in moves.items():
        parents[roles.index(role)] = roles.index(above) if above else 0
    return Rig(
        "rig",
        tuple(bones),
        np.array(parents),
        np.concatenate([root[None], rest]),
        np.concatenate([np.zeros((1, 3)), rig.tails]),
        rig.world,
        tuple(roles),
    )


def heads(rig: Rig, tracks: BoneTracks, frame: int) -> dict[str, np.ndarray]:
    """World matrices of a rig's bones, each under the parent that the rig gives it."""
    poses: list[np.ndarray] = []
    for name, parent, rest in zip(rig.bones, rig.parents.tolist(), rig.rest, strict=True):
        basis = np.eye(4)
        if name in tracks.bones:
            turn = tracks.rotations[frame, tracks.bones.index(name)]
            basis[:3, :3] = Rotation.from_quat(np.roll(turn, -1)).as_matrix()
        if name == tracks.bones[0]:
            basis[:3, 3] = tracks.locations[frame]
        if name in tracks.placed:
            basis[:3, 3] = tracks.places[frame, tracks.placed.index(name)]
        above = poses[parent] @ np.linalg.inv(rig.rest[parent]) if parent >= 0 else np.eye(4)
        poses.append(above @ rest @ basis)
    return {name: rig.world @ pose for name, pose in zip(rig.bones, poses, strict=True)}


@pytest.mark.parametrize(
    "moves",
    [
        {"foot.L": "", "foot.R": ""},
        {"thigh.L": "", "thigh.R": ""},
        {"thigh.L": "", "shin.L": "", "foot.L": "", "toe.L": ""},
        {"foot.R": "hips", "hand.L": "chest"},
        {"clavicle.R": "", "forearm.R": "head"},
    ],
)
def test_every_bone_comes_to_its_joint_whatever_it_hangs_on(moves, random_pose) -> None:
    rig = hung(moves)
    fit = fit_rig(whole_limbs(rig))
    assert {fit.rig.roles[fit.rig.bones.index(name)] for name, _ in fit.rig.placed} == set(moves)
    motion = random_pose(fit.skeleton, 3)
    tracks = to_bone_tracks(motion, fit, motion.fps)
    positions, rotations = motion.forward()
    for frame in range(3):
        got = heads(rig, tracks, frame)
        for joint, name in enumerate(fit.skeleton.names):
            np.testing.assert_allclose(got[name][:3, 3], positions[frame, joint], atol=1e-9)
            standing = Rotation.from_quat(np.roll(fit.tpose[joint], -1)).as_matrix()
            now = Rotation.from_quat(np.roll(rotations[frame, joint], -1)).as_matrix()
            np.testing.assert_allclose(got[name][:3, :3] @ standing.T, now, atol=1e-6)


def test_the_body_is_the_same_however_its_bones_hang() -> None:
    usual, odd = (fit_rig(whole_limbs(hung(moves))).skeleton for moves in ({}, {"foot.L": "", "thigh.R": ""}))
    places = [dict(zip(s.names, s.tpose_positions().tolist(), strict=True)) for s in (usual, odd)]
    for name, place in places[0].items():
        np.testing.assert_allclose(place, places[1][name], atol=1e-9)


def test_a_rig_in_one_piece_stays_as_it_is() -> None:
    rig = rig_from_skeleton(SKELETON, "rig")
    whole = whole_limbs(rig)
    assert whole.bones == rig.bones and whole.placed == () and whole.absent == ()


def without_hands(stretch: float) -> Rig:
    rig = rig_from_skeleton(SKELETON, "rig")
    kept = [b for b, role in enumerate(rig.roles) if not role.startswith("hand")]
    place = {bone: k for k, bone in enumerate(kept)}
    tails = rig.tails.copy()
    for side in "LR":
        bone = rig.roles.index(f"forearm.{side}")
        tails[bone] = rig.rest[bone, :3, 3] + (tails[bone] - rig.rest[bone, :3, 3]) * stretch
    return replace(
        rig,
        bones=tuple(rig.bones[b] for b in kept),
        parents=np.array([place.get(int(rig.parents[b]), -1) for b in kept]),
        rest=rig.rest[kept],
        tails=tails[kept],
        roles=tuple(rig.roles[b] for b in kept),
    )


def test_arms_without_hands_end_at_the_wrist(random_pose) -> None:
    rig = without_hands(1.0)
    with pytest.raises(InputError, match="hand"):
        fit_rig(rig)
    fit = fit_rig(whole_limbs(rig))
    whole = SKELETON.tpose_positions()
    for side in "LR":
        hand = fit.skeleton.tpose_positions()[fit.skeleton.joint(f"hand.{side}")]
        np.testing.assert_allclose(hand, whole[SKELETON.joint(f"hand.{side}")], atol=1e-6)
    tracks = to_bone_tracks(random_pose(fit.skeleton, 4), fit, 60.0)
    assert set(tracks.bones) <= set(rig.bones)


@pytest.mark.parametrize("stretch", [0.02, 7.0, -1.0])
def test_tails_that_an_importer_made_up_do_not_tell_where_a_wrist_is(stretch: float) -> None:
    skeleton = fit_rig(whole_limbs(without_hands(stretch))).skeleton
    for side in "LR":
        elbow, wrist = (skeleton.offsets[skeleton.joint(f"{part}.{side}")] for part in ("forearm", "hand"))
        np.testing.assert_allclose(np.linalg.norm(wrist), np.linalg.norm(elbow), atol=1e-6)


@pytest.mark.parametrize("value", [np.nan, 1e6])
def test_a_limb_that_would_be_nowhere_is_named(value: float, random_pose) -> None:
    fit = fit_rig(whole_limbs(hung({"foot.L": ""})))
    tracks = to_bone_tracks(random_pose(fit.skeleton, 90), fit, 60.0)
    check_tracks(tracks, fit.rig)
    tracks.places[60, 0, 1] = value
    with pytest.raises(InputError, match=f"the bone {tracks.placed[0]} would get keys at"):
        check_tracks(tracks, fit.rig)

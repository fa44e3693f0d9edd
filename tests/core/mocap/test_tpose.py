"""The T-pose of skeletons with any joint axes, on motions whose T-pose is known, and on real takes."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from footwork.core.body import forward_kinematics as fk
from footwork.core.body.edit import cut
from footwork.core.body.motion import Motion
from footwork.core.maths import quat
from footwork.core.mocap.bvh import BvhFile, local_transforms, read_bvh
from footwork.core.mocap.demo import demo_motion, demo_skeleton
from footwork.core.mocap.takes import load_take, take_from_bvh
from footwork.core.mocap.tpose import looks_like_tpose, tpose_rotations
from scipy.spatial.transform import Rotation

TURNS = ("Zrotation", "Yrotation", "Xrotation")
CUBE = quat.from_matrix(Rotation.create_group("O").as_matrix())


def disguised(motion: Motion, axes: np.ndarray) -> BvhFile:
    """A file, Y up and in cm, of the same movement, whose joint j has the axes `axes[j]` when in T-pose."""
    skeleton = motion.skeleton
    order = depth_first(skeleton.parents)
    place = np.argsort(order)
    parents = np.array([-1, *place[skeleton.parents[order[1:]]]])
    axes = axes[order]
    up = quat.from_axis("X", -np.pi / 2)
    positions, since = motion.forward()
    turned = quat.multiply(up, quat.multiply(since[:, order], axes))
    local = turned.copy()
    local[:, 1:] = quat.multiply(quat.conjugate(turned[:, parents[1:]]), turned[:, 1:])
    offsets = 100.0 * quat.rotate(quat.conjugate(axes[parents]), skeleton.offsets[order])
    offsets[0] = 0.0
    angles = np.degrees(quat.to_euler(local, "ZYX")).reshape(len(motion), -1)
    ends = np.setdiff1d(np.arange(len(order)), parents)
    return BvhFile(
        names=tuple(skeleton.names[joint] for joint in order),
        parents=parents,
        offsets=offsets,
        channels=(("Xposition", "Yposition", "Zposition", *TURNS), *(TURNS,) * (len(order) - 1)),
        end_sites=100.0 * quat.rotate(quat.conjugate(axes[ends]), skeleton.tips[order][ends]),
        end_parents=ends,
        frame_time=1.0 / motion.fps,
        values=np.concatenate([100.0 * quat.rotate(up, positions[:, 0]), angles], axis=1),
        file="disguised.bvh",
        sha256="",
    )


def depth_first(parents: np.ndarray) -> list[int]:
    order, todo = [], [0]
    while todo:
        joint = todo.pop()
        order.append(joint)
        todo += np.flatnonzero(parents == joint)[::-1].tolist()
    return order


def errors(found: Motion, truth: Motion) -> dict[str, float]:
    """Median degrees between rotations since T-pose, by role."""
    _, a = found.forward()
    _, b = truth.forward()
    out = {}
    for role in truth.skeleton.roles:
        turn = quat.multiply(
            a[:, found.skeleton.joint(role)], quat.conjugate(b[:, truth.skeleton.joint(role)])
        )
        out[role] = float(np.degrees(np.median(np.linalg.norm(quat.to_rotation_vector(turn), axis=-1))))
    return out


def assert_same_places(found: Motion, truth: Motion, atol: float) -> None:
    a, b = found.forward()[0], truth.forward()[0]
    for role in truth.skeleton.roles:
        np.testing.assert_allclose(
            a[:, found.skeleton.joint(role)], b[:, truth.skeleton.joint(role)], atol=atol
        )


@pytest.fixture(scope="module")
def visit() -> Motion:
    return demo_motion("visit", 3)


@pytest.mark.parametrize("seed", range(6))
def test_any_joint_axes_at_right_angles(visit: Motion, seed: int):
    axes = CUBE[np.random.default_rng(seed).integers(0, 24, len(visit.skeleton))]
    take = take_from_bvh(disguised(visit, axes))
    # Euler angles at gimbal lock, which right angles lead to, are no better than this
    assert_same_places(take.motion, visit, 1e-4)
    wrong = {role: error for role, error in errors(take.motion, visit).items() if error > 15.0}
    assert wrong == {}


def test_every_bone_along_x_at_zero(visit: Motion):
    # as LAFAN1 and Bandai Namco have it
    skeleton = visit.skeleton
    axes = np.tile(quat.IDENTITY, (len(skeleton), 1))
    for joint in range(len(skeleton)):
        bone = skeleton.tips[joint]
        for child in np.flatnonzero(skeleton.parents == joint):
            if skeleton.roles[child].partition(".")[0] not in ("thigh", "clavicle"):
                bone = skeleton.offsets[child]
        x = bone / np.linalg.norm(bone)
        z = np.array([1.0, 0, 0]) if abs(x[0]) < 0.9 else np.array([0.0, 0, 1.0])
        z = z - x * (x @ z)
        z /= np.linalg.norm(z)
        axes[joint] = quat.from_matrix(np.stack([x, np.cross(z, x), z], axis=-1))
    take = take_from_bvh(disguised(visit, axes))
    assert "data" in take.found["T-pose"]
    # Euler angles at gimbal lock, which right angles lead to, are no better than this
    assert_same_places(take.motion, visit, 1e-4)
    wrong = {role: error for role, error in errors(take.motion, visit).items() if error > 15.0}
    assert wrong == {}


@pytest.mark.parametrize("drop", [0.0, 20.0, 45.0, 55.0])
def test_rest_pose_with_arms_down(drop: float):
    """A rig in A-pose, without data: arms are lifted by just what they hang, hands keep their place on them."""
    skeleton = demo_skeleton()
    rest = np.tile(quat.IDENTITY, (len(skeleton), 1))
    for joint, role in enumerate(skeleton.roles):
        part, _, side = role.partition(".")
        if part in ("upper_arm", "forearm", "hand"):
            rest[joint] = quat.from_axis("Y", np.radians(-drop if side == "L" else drop))
    facing_back = quat.from_yaw(np.pi)
    rest = quat.multiply(facing_back, rest)
    positions = np.zeros((len(skeleton), 3))
    for joint in range(1, len(skeleton)):
        parent = skeleton.parents[joint]
        positions[joint] = positions[parent] + quat.rotate(rest[parent], skeleton.offsets[joint])
    assert looks_like_tpose(skeleton.roles, positions, np.radians(60.0))
    assert looks_like_tpose(skeleton.roles, positions, np.radians(25.0)) == (drop < 25.0)
    found = tpose_rotations(skeleton.parents, skeleton.roles, rest, positions, None)
    # in its own T-pose facing +Y this rig has no rotation at all
    np.testing.assert_allclose(np.abs(found[:, 0]), 1.0, atol=1e-6)


def test_bones_with_any_roll_and_bent_limbs():
    """Bone axes, roll and a slight bend of elbows and knees do not matter: limbs come out straight."""
    rng = np.random.default_rng(8)
    skeleton = demo_skeleton()
    count = len(skeleton)
    rest = np.tile(quat.IDENTITY, (count, 1))
    for joint, role in enumerate(skeleton.roles):
        part, _, side = role.partition(".")
        if part in ("forearm", "hand"):
            rest[joint] = quat.from_axis("Z", np.radians(-20.0 if side == "L" else 20.0))
        if part == "shin":
            rest[joint] = quat.from_axis("X", np.radians(-12.0))
    positions = np.zeros((count, 3))
    for joint in range(1, count):
        parent = skeleton.parents[joint]
        positions[joint] = positions[parent] + quat.rotate(rest[parent], skeleton.offsets[joint])
    rolls = quat.normalize(rng.normal(size=(count, 4)))
    found = tpose_rotations(skeleton.parents, skeleton.roles, quat.multiply(rest, rolls), positions, None)
    expected = np.tile(quat.IDENTITY, (count, 1))
    difference = quat.multiply(quat.multiply(found, quat.conjugate(rolls)), quat.conjugate(expected))
    off = dict(
        zip(skeleton.roles, np.degrees(2.0 * np.arccos(np.clip(np.abs(difference[:, 0]), 0, 1))), strict=True)
    )
    assert {role: angle for role, angle in off.items() if angle > 0.01} == {}


REAL = {
    # take: whether the file's zero pose is the T-pose
    "xsens/100STYLE_Neutral_FW.bvh": True,
    "lafan1/walk1_subject1_walk2_filtered.bvh": False,
    "lafan1/obstacles1_subject2_walk2_filtered.bvh": False,
    "lafan1/walk2_subject3_walk2_filtered.bvh": False,
    "bandai_namco/dataset-2_walk_normal_001.bvh": False,
    "bandai_namco/dataset-2_walk-turn-left_normal_003.bvh": False,
    "cmu/007_01.bvh": False,
    "cmu/walk.bvh": True,
    "cmu/dance_and_martial/salsa_14.bvh": True,
    "fubot_vr/generic_0.bvh": True,
}


@pytest.fixture(scope="module", params=sorted(REAL))
def real(request, data: Path) -> tuple[str, Motion]:
    return request.param, load_take(data / "takes" / request.param).motion


def test_real_takes_keep_every_joint_where_the_file_has_it(real, data: Path):
    name, motion = real
    bvh = read_bvh(data / "takes" / name)
    local, turns = local_transforms(bvh)
    places, _ = fk.forward(local[:, 0], turns, local, bvh.parents)
    positions, _ = motion.forward()
    scale = 1.0 if "fubot" in name else 0.01
    expected = scale * np.stack([places[..., 0], -places[..., 2], places[..., 1]], axis=-1)
    expected = expected[len(expected) - len(motion) :]
    # the floor may have been moved
    shift = positions[0, 0] - expected[0, bvh.names.index(motion.skeleton.names[0])]
    np.testing.assert_allclose(shift[:2], 0.0, atol=1e-12)
    for joint, joint_name in enumerate(motion.skeleton.names):
        if joint_name in bvh.names:
            theirs = expected[:, bvh.names.index(joint_name)] + shift
            np.testing.assert_allclose(positions[:, joint], theirs, atol=2e-6)


def test_real_takes_stand_in_tpose_at_zero(real):
    _, motion = real
    skeleton = motion.skeleton
    places = dict(zip(skeleton.roles, skeleton.tpose_positions(), strict=True))
    for side, sign in (("L", -1.0), ("R", 1.0)):
        for a, b in itertools.pairwise(("upper_arm", "forearm", "hand")):
            bone = places[f"{b}.{side}"] - places[f"{a}.{side}"]
            np.testing.assert_allclose(bone / np.linalg.norm(bone), (sign, 0, 0), atol=1e-9)
        for a, b in itertools.pairwise(("thigh", "shin", "foot")):
            bone = places[f"{b}.{side}"] - places[f"{a}.{side}"]
            np.testing.assert_allclose(bone / np.linalg.norm(bone), (0, 0, -1), atol=1e-9)
        foot = places[f"toe.{side}"] - places[f"foot.{side}"]
        assert abs(foot[0]) < 1e-9
        assert foot[1] > 0.05
        assert places[f"clavicle.{side}"][0] * sign >= -0.005
        assert abs(places[f"toe.{side}"][2]) < 0.05
    assert abs(places["head"][0]) < 0.03
    assert abs(places["head"][1]) < 0.05
    assert places["head"][2] > places["neck"][2] > places["hips"][2] > 0.7


def test_real_knees_bend_backwards_and_elbows_forwards(real):
    _, motion = real
    skeleton = motion.skeleton
    positions, since = motion.forward()
    for side in "LR":
        for upper, lower, end, forward in (
            ("thigh", "shin", "foot", -1.0),
            ("upper_arm", "forearm", "hand", 1.0),
        ):
            joints = [skeleton.joint(f"{part}.{side}") for part in (upper, lower, end)]
            bone = positions[:, joints[2]] - positions[:, joints[1]]
            local = quat.rotate(quat.conjugate(since[:, joints[0]]), bone)
            local /= np.linalg.norm(local, axis=-1, keepdims=True)
            # in the upper bone's axes: along Y is forwards, the third axis is the bone itself
            aside = local[:, 0] if upper == "thigh" else local[:, 2]
            bent = np.hypot(local[:, 1], aside) > np.sin(np.radians(20.0))
            if bent.any():
                assert np.median(forward * local[bent, 1]) > 0.0
                way = np.median(np.arctan2(aside[bent], forward * local[bent, 1]))
                assert abs(np.degrees(way)) < 40.0


def test_real_feet_are_flat_when_they_stand(real):
    _, motion = real
    skeleton = motion.skeleton
    positions, since = motion.forward()
    for side in "LR":
        toe = positions[:, skeleton.joint(f"toe.{side}")]
        speed = np.linalg.norm(np.gradient(toe, axis=0), axis=-1) * motion.fps
        stands = (speed < 0.15) & (toe[:, 2] < np.quantile(toe[:, 2], 0.3) + 0.02)
        up = quat.rotate(since[stands, skeleton.joint(f"foot.{side}")], np.array([0.0, 0, 1.0]))
        assert np.degrees(np.arccos(np.median(up[:, 2]))) < 12.0


def test_real_heads_and_chests_face_where_the_hips_do(real):
    _, motion = real
    _, since = motion.forward()
    hips = quat.heading(since[:, 0])
    for role, bound in (("chest", 10.0), ("head", 15.0)):
        aside = quat.heading(since[:, motion.skeleton.joint(role)]) - hips
        assert abs(np.degrees(np.angle(np.exp(1j * aside).mean()))) < bound
        up = quat.rotate(since[:, motion.skeleton.joint(role)], np.array([0.0, 0, 1.0]))
        assert np.median(up[:, 2]) > np.cos(np.radians(35.0))


def test_takes_of_one_skeleton_have_one_tpose(data: Path):
    for pattern, count in (
        ("lafan1/*subject1_walk*", 5),
        ("bandai_namco/*00[12]*", 8),
        ("cmu/basketball/*", 7),
    ):
        files = sorted((data / "takes").glob(pattern))[:count]
        takes = [load_take(file).motion.skeleton for file in files]
        assert len(takes) >= 5
        for skeleton in takes[1:]:
            off = np.linalg.norm(skeleton.tpose_positions() - takes[0].tpose_positions(), axis=-1)
            # feet are levelled by how they stand, which takes do not agree on to the degree
            feet = [role.partition(".")[0] in ("foot", "toe") for role in skeleton.roles]
            assert off[~np.array(feet)].max() < 0.02
            assert off.max() < 0.03


def test_a_cut_take_has_nearly_the_same_tpose(visit: Motion):
    axes = CUBE[np.random.default_rng(1).integers(0, 24, len(visit.skeleton))]
    whole = take_from_bvh(disguised(visit, axes)).motion
    part = take_from_bvh(disguised(cut(visit, 0, 300), axes)).motion
    wrong = {r: e for r, e in errors(part, cut(whole, 0, 300)).items() if e > 10.0}
    assert wrong == {}

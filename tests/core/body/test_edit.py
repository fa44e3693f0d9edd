"""Resampling against scipy, mirroring against geometry, cutting."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.body.edit import cut, mirror, mirror_joints, resample
from footwork.core.body.motion import Motion
from footwork.core.body.skeleton import Skeleton
from footwork.core.errors import InputError
from footwork.core.maths import quat
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.takes import load_take
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp


@pytest.fixture(scope="module")
def walk() -> Motion:
    return cut(demo_motion("turn", 5), 60, 260)


@pytest.mark.parametrize("fps", [24.0, 30.0, 59.94, 72.0, 120.0, 144.0])
def test_resampling_agrees_with_scipy(walk: Motion, fps: float):
    result = resample(walk, fps)
    seconds = (len(walk) - 1) / walk.fps
    times = np.arange(len(result)) / fps
    assert result.fps == fps
    assert times[-1] <= seconds + 1e-9
    assert times[-1] + 1.0 / fps > seconds
    known = np.arange(len(walk)) / walk.fps
    for axis in range(3):
        expected = np.interp(times, known, walk.positions[:, axis])
        np.testing.assert_allclose(result.positions[:, axis], expected, atol=1e-12)
    for joint in (0, walk.skeleton.joint("shin.L"), walk.skeleton.joint("hand.R")):
        slerp = Slerp(known, Rotation.from_quat(np.roll(walk.rotations[:, joint], -1, axis=-1)))
        expected = np.roll(slerp(np.minimum(times, known[-1])).as_quat(), 1, axis=-1)
        cosine = np.abs(np.sum(expected * result.rotations[:, joint], axis=-1))
        np.testing.assert_allclose(cosine, 1.0, atol=1e-10)
    assert (np.sum(result.rotations[1:] * result.rotations[:-1], axis=-1) > 0.0).all()


def test_resampling_to_a_multiple_keeps_the_frames(walk: Motion):
    there = resample(walk, 3.0 * walk.fps)
    assert len(there) == 3 * (len(walk) - 1) + 1
    back = resample(there, walk.fps)
    assert len(back) == len(walk)
    np.testing.assert_allclose(back.positions, walk.positions, atol=1e-12)
    np.testing.assert_allclose(np.abs(np.sum(back.rotations * walk.rotations, axis=-1)), 1.0, atol=1e-12)


def test_resampling_one_frame(walk: Motion):
    one = cut(walk, 3, 4)
    assert len(resample(one, 30.0)) == 1
    assert resample(one, 30.0).fps == 30.0


@pytest.mark.parametrize("fps", [0.0, -30.0, float("nan"), float("inf")])
def test_no_rate_is_refused(walk: Motion, fps: float):
    with pytest.raises(InputError, match="positive number"):
        resample(walk, fps)


def reflected(points: np.ndarray) -> np.ndarray:
    return points * np.array([-1.0, 1.0, 1.0])


def assert_mirrored(motion: Motion) -> None:
    image = mirror(motion)
    positions, rotations = motion.forward()
    mirrored, turned = image.forward()
    skeleton = motion.skeleton
    assert image.skeleton.roles == skeleton.roles
    assert image.skeleton.names == skeleton.names
    for joint, role in enumerate(skeleton.roles):
        if role:
            other = {"L": f"{role[:-1]}R", "R": f"{role[:-1]}L"}.get(
                role[-1] if role[-2:-1] == "." else "", role
            )
            source = skeleton.joint(other)
            np.testing.assert_allclose(mirrored[:, joint], reflected(positions[:, source]), atol=1e-9)
            # a rotation seen in a mirror: S R S
            matrix = (
                np.diag([-1.0, 1.0, 1.0]) @ quat.to_matrix(rotations[:, source]) @ np.diag([-1.0, 1.0, 1.0])
            )
            np.testing.assert_allclose(quat.to_matrix(turned[:, joint]), matrix, atol=1e-9)
    tips = quat.rotate(turned, image.skeleton.tips) + mirrored
    for side, other in ("LR", "RL"):
        toe = skeleton.joint(f"toe.{other}")
        tip = positions[:, toe] + quat.rotate(rotations[:, toe], skeleton.tips[toe])
        np.testing.assert_allclose(tips[:, skeleton.joint(f"toe.{side}")], reflected(tip), atol=1e-9)


def assert_same(a: Motion, b: Motion) -> None:
    for x, y in [
        (a.positions, b.positions),
        (a.rotations, b.rotations),
        (a.skeleton.offsets, b.skeleton.offsets),
        (a.skeleton.tips, b.skeleton.tips),
    ]:
        np.testing.assert_array_equal(x, y)


def test_mirror_image_of_procedural_motion(walk: Motion):
    assert_mirrored(walk)
    assert_same(mirror(mirror(walk)), walk)


@pytest.mark.parametrize(
    "take",
    [
        "cmu/007_01.bvh",
        "cmu/dance_and_martial/salsa_10.bvh",
        "lafan1/aiming1_subject1_walk_filtered.bvh",
        "cmu/walk.bvh",
    ],
)
def test_mirror_image_of_real_takes(data, take: str):
    motion = load_take(data / "takes" / take).motion
    motion = replace(motion, positions=motion.positions[::9], rotations=motion.rotations[::9])
    assert_mirrored(motion)
    assert_same(mirror(mirror(motion)), motion)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_mirroring_twice_is_exact(seed: int):
    rng = np.random.default_rng(seed)
    walk = cut(demo_motion("walk", 1), 0, 5)
    skeleton = replace(walk.skeleton, offsets=rng.normal(size=walk.skeleton.offsets.shape))
    rotations = quat.normalize(rng.normal(size=walk.rotations.shape))
    motion = Motion(skeleton, 60.0, rng.normal(size=walk.positions.shape), rotations)
    assert_same(mirror(mirror(motion)), motion)
    assert_mirrored(motion)


def test_a_body_with_unlike_sides_is_not_mirrored(walk: Motion):
    skeleton = walk.skeleton
    roles = tuple("" if role == "toe.L" else role for role in skeleton.roles)
    with pytest.raises(InputError, match="no partner on the other side"):
        mirror_joints(replace(skeleton, roles=roles))
    parents = skeleton.parents.copy()
    parents[skeleton.joint("clavicle.L")] = skeleton.joint("neck")
    with pytest.raises(InputError, match="no partner"):
        mirror(replace(walk, skeleton=replace(skeleton, parents=parents)))


def test_joints_in_between_pair_by_what_hangs_on_them():
    names = ("hips", "l1", "l2", "foot l", "r1", "r2", "foot r")
    skeleton = Skeleton(
        names=names,
        parents=np.array([-1, 0, 1, 2, 0, 4, 5]),
        offsets=np.zeros((7, 3)),
        roles=("hips", "", "", "foot.L", "", "", "foot.R"),
        tips=np.zeros((7, 3)),
    )
    assert mirror_joints(skeleton).tolist() == [0, 4, 5, 6, 1, 2, 3]


def test_cutting(walk: Motion):
    part = cut(walk, 10, 25)
    np.testing.assert_array_equal(part.positions, walk.positions[10:25])
    np.testing.assert_array_equal(part.rotations, walk.rotations[10:25])
    assert len(cut(walk, -5, 10**6)) == len(walk)
    for start, stop in [(5, 5), (7, 3), (len(walk), len(walk) + 4)]:
        with pytest.raises(InputError, match="nothing is left"):
            cut(walk, start, stop)


def line(frames: int, fps: float, body: Skeleton) -> Motion:
    """Hips along a straight line, joints that turn evenly."""
    times = np.arange(frames) / fps
    axes = np.random.default_rng(0).normal(size=(len(body), 3))
    turns = quat.from_rotation_vector(times[:, None, None] * axes)
    return Motion(body, fps, np.array([0.1, 0.2, 0.9]) + times[:, None] * [1.0, -2.0, 0.5], turns)


@pytest.mark.parametrize(
    ("frames", "fps", "wanted", "count"),
    [(2, 30.0, 60.0, 3), (2, 30.0, 59.0, 2), (2, 60.0, 30.0, 1), (3, 60.0, 30.0, 2), (3, 30.0, 10.0, 1),
     (61, 60.0, 24.0, 25),
     (2, 100.0, 99.999, 1), (2, 100.0, 99.999999, 2)],
)  # fmt: skip
def test_the_last_frame_is_the_last_that_is_covered(
    crooked, frames: int, fps: float, wanted: float, count: int
) -> None:
    result = resample(line(frames, fps, crooked()), wanted)
    assert len(result) == len(result.rotations) == count and result.fps == wanted
    expected = line(count, wanted, crooked())
    np.testing.assert_allclose(result.positions, expected.positions, atol=1e-7)
    np.testing.assert_allclose(result.rotations, expected.rotations, atol=1e-7)


def test_at_its_own_rate_and_in_one_frame_a_motion_stays(crooked, moved) -> None:
    for motion, fps in ((moved(crooked()), 60.0), (cut(moved(crooked()), 0, 1), 25.0)):
        result = resample(motion, fps)
        assert result.fps == fps and result.skeleton is motion.skeleton
        np.testing.assert_array_equal(result.positions, motion.positions)
        np.testing.assert_array_equal(result.rotations, motion.rotations)


def bare(*rows: tuple[str, int, str]) -> Skeleton:
    """Joints as name, parent and role."""
    names, parents, roles = zip(*rows, strict=True)
    return Skeleton(names, np.array(parents), np.zeros((len(rows), 3)), roles, np.zeros((len(rows), 3)))


def test_joints_of_the_middle_without_a_role_are_their_own_partners() -> None:
    skeleton = bare(
        ("hips", -1, "hips"), ("waist", 0, ""), ("chest", 1, "chest"), ("atlas", 2, ""), ("head", 3, "head"),
        ("left", 1, "thigh.L"), ("right", 1, "thigh.R"),
    )  # fmt: skip
    found = mirror_joints(skeleton)
    assert found.tolist() == [0, 1, 2, 3, 4, 6, 5] and found.dtype == np.intp


@pytest.mark.parametrize(
    ("rows", "name"),
    [
        ([("hips", -1, "hips"), ("nub", 0, "")], "nub"),
        ([("hips", -1, "hips"), ("left", 0, "foot.L")], "left"),
        ([("hips", -1, "hips"), ("a", 0, "thigh.L"), ("b", 0, "thigh.R"), ("c", 2, "shin.R")], "c"),
        # the left foot hangs from a joint in between, the right one does not
        ([("hips", -1, "hips"), ("mid", 0, ""), ("left", 1, "foot.L"), ("right", 0, "foot.R")], "mid"),
        # each has a partner, but the partners hang elsewhere
        ([("hips", -1, "hips"), ("head", 0, "head"), ("left", 0, "foot.L"), ("right", 1, "foot.R")], "hips"),
    ],
)
def test_the_joint_that_has_no_partner_is_named(rows: list[tuple[str, int, str]], name: str) -> None:
    with pytest.raises(InputError, match=f"joint {name} has no partner"):
        mirror_joints(bare(*rows))


def test_only_what_ends_in_a_side_has_one() -> None:
    """`.L` and `.R` after the part of the body; a role of one letter or none is in the middle."""
    skeleton = bare(
        ("hips", -1, "hips"), ("a", 0, "hand.L"), ("b", 0, "hand.R"), ("c", 0, "R"), ("d", 0, "xL")
    )
    assert mirror_joints(skeleton).tolist() == [0, 2, 1, 3, 4]


def test_one_frame_can_be_cut_out_at_either_end(crooked, moved) -> None:
    motion = moved(crooked(), 9)
    for start, stop, at in ((0, 1, 0), (-3, 1, 0), (8, 9, 8), (8, 99, 8), (4, 5, 4)):
        part = cut(motion, start, stop)
        assert part.fps == motion.fps and part.skeleton is motion.skeleton
        np.testing.assert_array_equal(part.positions, motion.positions[at : at + 1])
        np.testing.assert_array_equal(part.rotations, motion.rotations[at : at + 1])
    with pytest.raises(InputError, match="frames 0 to 0 of 9"):
        cut(motion, -2, 0)
    with pytest.raises(InputError, match="frames 9 to 9 of 9"):
        cut(motion, 9, 12)

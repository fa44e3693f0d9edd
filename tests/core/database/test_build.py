from __future__ import annotations

import hashlib
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from footwork.core import VERSION
from footwork.core.body.edit import cut
from footwork.core.database.build import build_database
from footwork.core.database.clips import Exclusion
from footwork.core.database.describe import describe_database
from footwork.core.database.motion_database import MotionDatabase
from footwork.core.database.sidecar import save_database
from footwork.core.errors import InputError
from footwork.core.jobs import run
from footwork.core.matching.selection import check_databases
from footwork.core.mocap.demo import demo_motion
from footwork.core.settings import DatabaseSettings


def build(takes, **options) -> MotionDatabase:
    fields = set(DatabaseSettings.__dataclass_fields__)
    settings = DatabaseSettings(**{key: options.pop(key) for key in fields & set(options)})
    return run(build_database(takes, settings, name="test", **options))


def same(a: MotionDatabase, b: MotionDatabase, frames: slice = slice(None)) -> bool:
    return all(
        np.array_equal(getattr(a.poses, name)[frames], getattr(b.poses, name)[frames])
        for name in ("root_positions", "root_yaws", "rotations", "hips_velocities", "contacts")
    )


def test_clip_table_and_progress(as_take) -> None:
    takes = [as_take(demo_motion(name), name) for name in ("turn", "sidestep")]
    steps: list[float] = []
    database = run(
        build_database(takes, DatabaseSettings(), name="two", tags=["a"]), lambda f, _: steps.append(f)
    )
    assert [(clip.name, clip.start, clip.stop) for clip in database.clips] == [
        ("turn", 0, 840),
        ("sidestep", 840, 1710),
    ]
    assert [clip.file for clip in database.clips] == [Path(take.file).name for take in takes]
    assert [clip.sha256 for clip in database.clips] == [take.sha256 for take in takes]
    assert steps == sorted(steps)
    assert 0.0 <= steps[0] <= steps[-1] <= 1.0
    assert (database.name, database.tags, len(database)) == ("two", ("a",), 1710)
    invalid = np.flatnonzero(~database.features.trajectory_valid)
    np.testing.assert_array_equal(invalid, [*range(780, 840), *range(1650, 1710)])


def test_another_skeleton_can_be_given(as_take) -> None:
    tall, small = (as_take(demo_motion("turn", height=height), "turn") for height in (1.9, 1.6))
    database = build([small], skeleton=tall.motion.skeleton)
    assert database.skeleton is tall.motion.skeleton
    assert database.head_height == pytest.approx(build([tall]).head_height, rel=0.01)


def test_folders_of_the_takes_do_not_matter(as_take, tmp_path) -> None:
    take = as_take(demo_motion("turn"), "turn")
    for i, folder in enumerate(("/home/a/", "C:\\Users\\b\\")):
        file = f"{folder}turn.bvh"
        job = build_database(
            [replace(take, file=file)], DatabaseSettings(), name="a", exclude=[Exclusion(file, 0.0, 1.0)]
        )
        save_database(tmp_path / f"{i}.npz", run(job))
    assert (tmp_path / "0.npz").read_bytes() == (tmp_path / "1.npz").read_bytes()
    assert b"/home/" not in (tmp_path / "0.npz").read_bytes()


def test_head_height_is_the_head_joints_of_a_body_at_ease(as_take) -> None:
    motion = demo_motion("turn")
    # the demo stands with its hips, 0.95 m in T-pose, at 0.985 of that, the trunk as in T-pose
    tall = motion.skeleton.tpose_positions()[motion.skeleton.names.index("Head"), 2]
    assert build([as_take(motion)]).head_height == pytest.approx(tall - 0.015 * 0.95)


def test_mirror_follows_after_the_originals(as_take) -> None:
    takes = [as_take(demo_motion(name), name) for name in ("turn", "sidestep")]
    plain, both = build(takes), build(takes, mirror=True)
    half = len(plain)
    assert len(both) == 2 * half
    assert [clip.mirrored for clip in both.clips] == [False, False, True, True]
    assert same(plain, both, slice(0, half))
    np.testing.assert_allclose(both.poses.root_yaws[half:], -plain.poses.root_yaws, atol=1e-6)
    np.testing.assert_array_equal(both.poses.contacts[half:], plain.poses.contacts[:, ::-1])
    # a database and its mirror image together prefer no side
    np.testing.assert_allclose(both.features.mean[[0, 2, 4, 6, 8, 10, 24]], 0.0, atol=1e-9)
    # and the mirror image's mirror image is the original
    again = build([replace(take, motion=_mirrored(take.motion)) for take in takes], mirror=True)
    np.testing.assert_allclose(again.poses.rotations[half:], plain.poses.rotations, atol=1e-6)


def _mirrored(motion):
    """By matrices: the reflection S in the plane X = 0 turns a rotation R into S R S."""
    from scipy.spatial.transform import Rotation

    reflect = np.diag([-1.0, 1.0, 1.0])
    names = motion.skeleton.names
    swap = [names.index(n.replace("Left", "#").replace("Right", "Left").replace("#", "Right")) for n in names]
    frames, joints = motion.rotations.shape[:2]
    wxyz = motion.rotations[:, swap].reshape(-1, 4)
    matrices = reflect @ Rotation.from_quat(wxyz[:, [1, 2, 3, 0]]).as_matrix() @ reflect
    turned = Rotation.from_matrix(matrices).as_quat()[:, [3, 0, 1, 2]].reshape(frames, joints, 4)
    signs = np.sign(np.sum(turned * motion.rotations[:, swap] * [1, 1, -1, -1], axis=-1, keepdims=True))
    return replace(motion, positions=motion.positions @ reflect, rotations=turned * signs)


def test_a_cut_take_becomes_clips_of_its_own(as_take) -> None:
    motion = demo_motion("walk")
    database = build([as_take(motion)], exclude=[Exclusion("walk", 4.0, 6.5)])
    assert [(clip.name, clip.start, clip.stop) for clip in database.clips] == [
        ("walk 0.00-4.00 s", 0, 240),
        ("walk 6.50-24.00 s", 240, 240 + 1440 - 390),
    ]
    alone = build([as_take(cut(motion, 390, 1440))])
    np.testing.assert_array_equal(database.poses.rotations[240:], alone.poses.rotations)
    np.testing.assert_array_equal(database.poses.contacts[240:], alone.poses.contacts)
    assert json.loads(database.provenance["excluded"]) == ["walk:4-6.5"]


def test_short_clips_are_left_out_with_the_reason(as_take) -> None:
    short = as_take(cut(demo_motion("turn"), 0, 64), "short")
    database = build([as_take(demo_motion("turn"), "turn"), short])
    assert [clip.name for clip in database.clips] == ["turn"]
    (reason,) = json.loads(database.provenance["skipped"])
    assert reason.startswith("short: 1.07 s")
    assert [source["name"] for source in json.loads(database.provenance["sources"])] == ["turn", "short"]
    just = build([as_take(cut(demo_motion("turn"), 0, 65), "just")])
    assert just.features.trajectory_valid.sum() == 5


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"exclude": [Exclusion("walk", 0.0, 99.0)]}, "nothing to use: walk: excluded as a whole"),
        ({"exclude": [Exclusion("walk", 1.0, 99.0)]}, "nothing to use: walk 0.00-1.00 s: 1.00 s long"),
        ({"exclude": [Exclusion("run", 0.0, 1.0)]}, "no such take"),
        ({"height_low": 0.9, "height_high": 0.9}, "height range 0.9 to 0.9"),
        ({"contact_speed": -1.0}, "contact-speed"),
    ],
)
def test_faults(as_take, options, words: str) -> None:
    with pytest.raises(InputError) as caught:
        build([as_take(demo_motion("walk"))], **options)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_no_takes() -> None:
    with pytest.raises(InputError, match="no takes"):
        build([])


def test_other_rates_are_resampled(as_take) -> None:
    fast, slow = demo_motion("walk", fps=60.0), demo_motion("walk", fps=30.0)
    a, b = build([as_take(fast)]), build([as_take(slow)])
    assert (a.fps, b.fps) == (60.0, 60.0)
    count = len(b)
    assert len(a) - count <= 1
    np.testing.assert_allclose(a.poses.root_positions[:count], b.poses.root_positions, atol=0.05)
    agree = (a.poses.contacts[:count] == b.poses.contacts).mean()
    assert agree > 0.95


def test_takes_on_another_skeleton_are_carried_over(as_take) -> None:
    tall, short = demo_motion("turn", height=1.9), demo_motion("turn", height=1.6)
    both = build([as_take(tall, "tall"), as_take(short, "short")])
    own = build([as_take(tall, "tall")])
    half = len(own)
    assert both.skeleton is tall.skeleton
    assert same(own, both, slice(0, half))
    # the same script on a shorter body: on the tall one its feet reach the floor again
    np.testing.assert_allclose(
        both.poses.hips_positions[half:, 2].mean(), own.poses.hips_positions[:, 2].mean(), atol=0.01
    )
    assert both.head_height == own.head_height


def test_same_bones_keep_the_motion_as_it_is(as_take) -> None:
    motion = demo_motion("turn")
    lifted = motion.skeleton.offsets.copy()
    lifted[0, 2] += 0.03
    twin = replace(motion, skeleton=replace(motion.skeleton, offsets=lifted, names=("a",) * 23))
    both = build([as_take(motion, "one"), as_take(twin, "two")])
    half = len(motion)
    np.testing.assert_array_equal(both.poses.hips_positions[:half], both.poses.hips_positions[half:])
    np.testing.assert_array_equal(both.features.values[:half], both.features.values[half:])


def test_deterministic_and_provenance(as_take) -> None:
    takes = [as_take(demo_motion("walk"))]
    a, b = (build(takes, mirror=True, height_low=0.5) for _ in range(2))
    assert same(a, b)
    digests = {hashlib.sha256(db.features.values.tobytes()).hexdigest() for db in (a, b)}
    assert len(digests) == 1
    assert a.provenance == b.provenance
    assert a.provenance["producer"] == f"footwork {VERSION}"
    assert json.loads(a.provenance["settings"])["mirror"] is True
    (source,) = json.loads(a.provenance["sources"])
    assert (source["sha256"], source["frames"], source["fps"]) == (takes[0].sha256, 1440, 60.0)
    assert a.height_range == (0.5, 2.0)


def test_variants_go_with_the_upright_database(as_take) -> None:
    takes = [as_take(demo_motion(name), name) for name in ("walk", "turn")]
    upright, crouched, risen = (build(takes, mirror=True, body_height=height) for height in (1.0, 0.7, 1.04))
    check_databases([upright, crouched, risen])
    assert (upright.height_range, crouched.height_range, risen.height_range) == (
        (0.0, 2.0),
        (0.0, 0.85),
        (1.02, 2.0),
    )
    for variant, share in ((crouched, 0.7), (risen, 1.04)):
        assert variant.head_height == upright.head_height
        assert json.loads(variant.provenance["settings"])["body_height"] == share
        np.testing.assert_array_equal(variant.poses.contacts, upright.poses.contacts)
        told = [describe_database(database)["headset_height_ratio"] for database in (upright, variant)]
        assert told[1]["median"] / told[0]["median"] == pytest.approx(share, abs=0.01)
    # what a person says of the range counts
    said = build(takes, body_height=0.7, height_low=0.6, height_high=0.9)
    assert said.height_range == (0.6, 0.9)


def test_a_clip_is_brought_to_a_height_by_its_own_frames(as_take) -> None:
    """Mirror images and cuts are variants as their clips are."""
    take = as_take(demo_motion("walk"))
    whole = build([take], body_height=0.7, mirror=True)
    half = len(whole) // 2
    np.testing.assert_allclose(whole.poses.root_yaws[half:], -whole.poses.root_yaws[:half], atol=1e-6)
    part = build([take], body_height=0.7, exclude=[Exclusion("walk", 0.0, 4.0)])
    inside = slice(60, 400)
    shifted = slice(60 + 240, 400 + 240)
    np.testing.assert_allclose(
        part.poses.hips_positions[inside, 2], whole.poses.hips_positions[shifted, 2], atol=0.005
    )

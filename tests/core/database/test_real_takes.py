"""The database of real takes against a second way to the same numbers, and against what bodies do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pymotion.rotations.quat as pymotion_quat
import pytest
from footwork.core.database.build import build_database
from footwork.core.database.describe import describe_database
from footwork.core.database.motion_database import MotionDatabase
from footwork.core.database.sidecar import load_database, save_database
from footwork.core.jobs import run
from footwork.core.maths import quat
from footwork.core.mocap.takes import load_take
from footwork.core.settings import DatabaseSettings
from pymotion.io.bvh import BVH
from pymotion.ops.skeleton import fk


def build(paths: list[Path], **settings) -> MotionDatabase:
    takes = [load_take(path) for path in paths]
    return run(build_database(takes, DatabaseSettings(**settings), name="real"))


@pytest.fixture(scope="session")
def walk(data: Path) -> MotionDatabase:
    return build([data / "takes" / "xsens" / "100STYLE_Neutral_FW.bvh"])


def test_features_by_pymotion(data: Path, walk: MotionDatabase) -> None:
    """Xsens stands in T-pose at zero, faces +Z with Y up, in centimetres; nothing of ours reads it here."""
    bvh = BVH()
    bvh.load(str(data / "takes" / "xsens" / "100STYLE_Neutral_FW.bvh"))
    rotations, positions, parents, offsets, _, _ = bvh.get_data()
    joints, _ = fk(pymotion_quat.normalize(rotations), positions[:, 0], offsets, parents)
    joints = 0.01 * joints @ np.array([[-1.0, 0, 0], [0, 0, 1.0], [0, 1.0, 0]])
    names = list(bvh.data["names"])
    ahead = quat.rotate(rotations[:, 0], np.array([0.0, 0.0, 1.0]))[:, [0, 2]] * [-1.0, 1.0]
    ahead /= np.linalg.norm(ahead, axis=-1, keepdims=True)
    found = walk.features.values * walk.features.deviation + walk.features.mean
    shift = len(joints) - len(walk)
    floor = None
    for n in range(0, len(walk) - 61, 97):
        m = n + shift
        axes = np.array([[ahead[m, 1], -ahead[m, 0], 0.0], [*ahead[m], 0.0], [0.0, 0.0, 1.0]])
        root = joints[m, 0] * [1.0, 1.0, 0.0]
        z = [axes[:2] @ (joints[m + k, 0] - root) for k in (20, 40, 60)]
        z += [axes[:2, :2] @ ahead[m + k] for k in (20, 40, 60)]
        for name in ("LeftAnkle", "RightAnkle"):
            j = names.index(name)
            z += [axes @ (joints[m, j] - root), 60.0 * axes @ (joints[m + 1, j] - joints[m, j])]
        z += [60.0 * axes @ (joints[m + 1, 0] - joints[m, 0])]
        expected = np.concatenate(z)
        # the reader puts the lowest sole on the floor: one height for the whole take
        floor = expected[14] - found[n, 14] if floor is None else floor
        expected[[14, 20]] -= floor
        np.testing.assert_allclose(found[n], expected, atol=5e-5)


def test_a_walk_walks(walk: MotionDatabase) -> None:
    described = describe_database(walk)
    coverage, feet = described["coverage"], described["feet"]
    assert coverage["direction_shares"]["forward"] > 0.8
    assert 0.6 < coverage["speed_m_s"]["median"] < 1.8
    # each foot is down for somewhat more than half of a walk
    assert all(0.45 < share < 0.8 for share in feet["contact_share"].values())
    assert feet["airborne_share"] < 0.1
    assert feet["foot_skate_cm_s"] < 6.0
    assert -0.02 < feet["toe_height_m"]["median"] < 0.06
    assert 1.4 < walk.head_height < 1.9
    assert 0.9 < described["headset_height_ratio"]["median"] < 1.05


def test_takes_of_several_bodies_and_rates_in_one(data: Path, tmp_path: Path) -> None:
    takes = data / "takes"
    paths = [
        takes / "lafan1" / "aiming1_subject1_walk_filtered.bvh",
        takes / "lafan1" / "fallAndGetUp1_subject1_jog2walk_filtered.bvh",
        takes / "bandai_namco" / "dataset-2_walk_normal_001.bvh",
        takes / "cmu" / "walk.bvh",
    ]
    database = build(paths, mirror=True)
    assert len(database.clips) == 8
    save_database(tmp_path / "a.npz", database)
    loaded = load_database(tmp_path / "a.npz")
    np.testing.assert_array_equal(loaded.features.values, database.features.values)
    toes = describe_database(loaded)["feet"]
    # whoever walked, on the one skeleton the toes stand on the floor
    assert -0.03 < toes["toe_height_m"]["p5"] <= toes["toe_height_m"]["p95"] < 0.09
    assert toes["foot_skate_cm_s"] < 9.0


def test_two_takes_of_one_body_keep_their_joints(data: Path) -> None:
    folder = data / "takes" / "lafan1"
    paths = [
        folder / "aiming1_subject1_walk_filtered.bvh",
        folder / "fallAndGetUp1_subject1_jog_filtered.bvh",
    ]
    database = build(paths)
    motion = load_take(paths[1]).motion
    clip = database.clips[1]
    run_of = slice(clip.start, clip.stop)
    positions = motion.forward()[0]
    feet = [motion.skeleton.joint("foot.L"), motion.skeleton.joint("foot.R")]
    values = database.features.values[run_of] * database.features.deviation + database.features.mean
    heights = positions[:, feet, 2]
    np.testing.assert_allclose(values[:, [14, 20]], heights, atol=2e-3)


@pytest.mark.parametrize("share", [0.7, 1.04])
def test_variants_of_a_real_walk(data: Path, walk: MotionDatabase, share: float) -> None:
    variant = build([data / "takes" / "xsens" / "100STYLE_Neutral_FW.bvh"], body_height=share)
    np.testing.assert_array_equal(variant.poses.contacts, walk.poses.contacts)
    upright, other = describe_database(walk), describe_database(variant)
    ratios = [report["headset_height_ratio"]["median"] for report in (upright, other)]
    assert ratios[1] / ratios[0] == pytest.approx(share, abs=0.01)
    # feet slide no more, and stand as high
    assert other["feet"]["foot_skate_cm_s"] == pytest.approx(upright["feet"]["foot_skate_cm_s"], abs=0.1)
    heights = [report["feet"]["toe_height_m"] for report in (upright, other)]
    assert heights[1] == pytest.approx(heights[0], abs=1e-3)
    # nothing turns faster by more than a half
    fastest = [np.linalg.norm(base.poses.angular_velocities, axis=-1).max() for base in (walk, variant)]
    assert fastest[1] < 1.5 * fastest[0]

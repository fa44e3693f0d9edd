"""The report's metrics on motions whose faults are put in by hand."""

from __future__ import annotations

import json
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from footwork.core.body.motion import Motion
from footwork.core.body.toes import toe_positions
from footwork.core.database.contacts import find_contacts
from footwork.core.database.motion_database import FEATURE_COUNT, FeatureDatabase, MotionDatabase
from footwork.core.database.virtual_root import virtual_root
from footwork.core.errors import InputError
from footwork.core.matching.playback import Playback
from footwork.core.maths import quat
from footwork.core.measure.catalogue import measure as measure_all
from footwork.core.measure.catalogue import summarise
from footwork.core.measure.played import pose_jumps
from footwork.core.measure.subject import Yardstick, body_of
from footwork.core.mocap.demo import demo_motion
from footwork.core.recording.recording import Recording
from footwork.core.recording.simulate import simulate_recording

DISTRIBUTIONS = (
    "root_error_cm", "yaw_error_deg", "foot_skate_cm_s", "head_position_error_cm", "head_rotation_error_deg",
    "hand_position_error_cm", "penetration_cm", "lower_body_mpjpe_cm", "mpjpe_cm", "mpjre_deg", "mpjae_deg",
    "mpjve_cm_s", "hips_error_cm", "body_yaw_error_deg", "orientation_error_deg", "floating_cm",
    "slide_per_contact_cm", "nsm_skate_cm_s", "pose_jump",
)  # fmt: skip
NUMBERS = (
    "transitions_per_s",
    "poses_used",
    "clamped_fraction",
    "unreachable_fraction",
    "jitter",
    "skating_ratio",
)


@pytest.fixture(scope="module")
def truth() -> Motion:
    return demo_motion("turn", 1)


@pytest.fixture(scope="module")
def trackers(truth: Motion) -> Recording:
    return simulate_recording(truth, "turn")


class _Base(SimpleNamespace):
    def __len__(self) -> int:
        return self.count


def databases(count: int, motion: Motion | None = None) -> list[MotionDatabase]:
    """Two databases with one feature that counts: column 12 + i of database i runs 0, 1, 2 ... in normalised units."""
    out: list[Any] = []
    for i in range(2):
        values = np.zeros((count, FEATURE_COUNT), dtype=np.float32)
        values[:, 12] = np.arange(count)
        values[:, 0] = 99.0 * np.arange(count)
        deviation = np.full(FEATURE_COUNT, 1.0 + i)
        mean = np.full(FEATURE_COUNT, 5.0 * i)
        features = FeatureDatabase(values, mean, deviation, np.ones(count, dtype=bool))
        motion = motion or demo_motion("turn", 1)
        hips = np.tile([0.0, 0.0, 0.9], (count, 1))
        rotations = np.tile(quat.IDENTITY, (count, len(motion.skeleton), 1))
        poses = SimpleNamespace(hips_positions=hips, rotations=rotations)
        out.append(_Base(features=features, poses=poses, skeleton=motion.skeleton, fps=60.0, count=count))
    return cast(list[MotionDatabase], out)


def playback(truth: Motion) -> Playback:
    """Frames 0, 1, 2 ... with a jump to frame 10 at 50, targets on the true virtual root."""
    count = len(truth)
    frame = np.arange(count)
    frame[50:] = np.arange(10, count - 40)
    positions, yaws = virtual_root(truth)
    return Playback(
        database=np.zeros(count, dtype=np.intp), frame=frame.astype(np.intp), root_positions=positions,
        root_yaws=yaws, transitions=np.array([50]), clamped=np.arange(count) < count // 4,
        target_positions=positions, target_yaws=yaws, searches=1,
    )  # fmt: skip


def bake_metrics(motion: Motion, *against: Any, **more: Any) -> dict[str, Any]:
    return summarise(measure_all(Yardstick(*against, **more), body_of(motion)))


def measure(motion: Motion, truth: Motion, trackers: Recording) -> dict[str, Any]:
    contacts = find_contacts(toe_positions(truth), truth.fps)
    unreachable = np.zeros((len(truth), 2), dtype=bool)
    play = playback(truth)
    return bake_metrics(motion, contacts, trackers, play, databases(len(truth)), unreachable, truth=truth)


def test_the_true_motion_has_no_errors_but_its_own(truth: Motion, trackers: Recording) -> None:
    metrics = measure(truth, truth, trackers)
    for name in DISTRIBUTIONS:
        assert set(metrics[name]) - {"floor"} == {"mean", "std", "p95", "max", "count"}, name
        if "error" in name or "mpj" in name:
            assert metrics[name]["max"] < 1e-5, name
        if "floor" in metrics[name]:
            floor = metrics[name]["floor"]
            assert floor == {key: metrics[name][key] for key in floor}, name
    assert {"foot_skate_cm_s", "penetration_cm", "root_error_cm", "floating_cm"} <= {
        name for name in DISTRIBUTIONS if "floor" in metrics[name]
    }
    assert metrics["jitter"] == metrics["jitter_floor"] > 0.0
    assert metrics["foot_skate_cm_s"]["mean"] < 2.0, "the demo plants its feet"
    assert metrics["penetration_cm"]["max"] < 0.5


def test_it_is_ready_for_json(truth: Motion, trackers: Recording) -> None:
    metrics = measure(truth, truth, trackers)
    assert json.loads(json.dumps(metrics, allow_nan=False)) == metrics
    for name in NUMBERS:
        assert isinstance(metrics[name], int | float), name


def test_a_shifted_avatar(truth: Motion, trackers: Recording) -> None:
    metrics = measure(
        replace(truth, positions=truth.positions + np.array([0.03, -0.04, 0.0])), truth, trackers
    )
    for name in ("root_error_cm", "hips_error_cm", "head_position_error_cm", "hand_position_error_cm"):
        assert metrics[name]["mean"] == pytest.approx(5.0), name
        assert metrics[name]["max"] == pytest.approx(5.0), name
    for name in ("mpjpe_cm", "lower_body_mpjpe_cm", "upper_body_mpjpe_cm"):
        assert metrics[name]["mean"] == pytest.approx(5.0), name
        assert metrics[name]["std"] == pytest.approx(0.0, abs=1e-9), name
    assert metrics["root_error_cm"]["floor"]["max"] < 1e-9
    for name in ("yaw_error_deg", "head_rotation_error_deg", "mpjre_deg", "mpjae_deg", "mpjve_cm_s"):
        assert metrics[name]["max"] < 1e-5, name


def test_a_sunken_avatar(truth: Motion, trackers: Recording) -> None:
    plain = measure(truth, truth, trackers)
    metrics = measure(replace(truth, positions=truth.positions - [0.0, 0.0, 0.05]), truth, trackers)
    # the demo's toe joint stands 2 cm above the floor, inside the foot
    assert plain["penetration_cm"]["max"] < 0.01
    assert metrics["penetration_cm"]["max"] == pytest.approx(3.0, abs=0.01)
    assert metrics["sinking_cm"]["max"] == pytest.approx(5.0, abs=0.01)
    assert metrics["floating_cm"]["max"] == 0.0
    assert metrics["penetration_cm"]["floor"] == plain["penetration_cm"]["floor"]
    assert metrics["root_error_cm"]["max"] < 1e-9, "the root lies on the ground"
    assert metrics["head_position_error_cm"]["mean"] == pytest.approx(5.0)


def test_a_turned_avatar(truth: Motion, trackers: Recording) -> None:
    """Turned by 30 degrees about its own hips: yaw and head are off, local rotations but the hips' are not."""
    rotations = truth.rotations.copy()
    rotations[:, 0] = quat.multiply(quat.from_yaw(np.radians(30.0)), rotations[:, 0])
    metrics = measure(replace(truth, rotations=rotations), truth, trackers)
    for name in ("yaw_error_deg", "body_yaw_error_deg", "head_rotation_error_deg", "hand_rotation_error_deg"):
        assert metrics[name]["mean"] == pytest.approx(30.0, abs=1e-4), name
    assert metrics["orientation_error_deg"]["max"] < 1e-9, "it was asked for the right orientation"
    joints = len([role for role in truth.skeleton.roles if role])
    assert metrics["mpjae_deg"]["mean"] == pytest.approx(30.0 / joints, abs=1e-4)
    assert metrics["mpjae_deg"]["max"] == pytest.approx(30.0, abs=1e-4)


def test_a_drifting_avatar_skates(truth: Motion, trackers: Recording) -> None:
    drift = np.outer(np.arange(len(truth)) / truth.fps, [0.0, 0.2, 0.0])
    still = replace(truth, positions=np.tile(truth.positions[:1], (len(truth), 1)),
                    rotations=np.tile(truth.rotations[:1], (len(truth), 1, 1)))  # fmt: skip
    contacts = np.ones((len(truth), 2), dtype=bool)
    metrics = bake_metrics(
        replace(still, positions=still.positions + drift), contacts, trackers, playback(truth), databases(len(truth)),
        np.zeros((len(truth), 2), dtype=bool), truth=still,
    )  # fmt: skip
    for name in ("foot_skate_cm_s", "mpjve_cm_s"):
        assert metrics[name]["mean"] == pytest.approx(20.0), name
    assert metrics["slide_per_contact_cm"]["max"] == pytest.approx(20.0 * (len(truth) - 1) / 60.0)
    assert metrics["foot_skate_cm_s"]["floor"]["max"] < 1e-9
    assert metrics["jitter"] < 1e-6


def test_untracked_frames_do_not_count(truth: Motion, trackers: Recording) -> None:
    broken = trackers.positions.copy()
    broken[:100, 1] += 7.0
    valid = trackers.valid.copy()
    valid[:100, 1] = False
    metrics = measure(truth, truth, replace(trackers, positions=broken, valid=valid))
    assert metrics["hand_position_error_cm"]["max"] < 1e-9
    nothing = replace(trackers, valid=np.zeros_like(valid))
    assert measure(truth, truth, nothing)["head_position_error_cm"]["max"] == 0.0


def test_unreachable_hands(truth: Motion, trackers: Recording) -> None:
    unreachable = np.zeros((len(truth), 2), dtype=bool)
    unreachable[: len(truth) // 2, 1] = True
    away = trackers.positions.copy()
    away[: len(truth) // 2, 2, 2] += 0.5
    metrics = bake_metrics(
        truth, np.zeros((len(truth), 2), bool), replace(trackers, positions=away), playback(truth),
        databases(len(truth)), unreachable,
    )  # fmt: skip
    assert metrics["unreachable_fraction"] == pytest.approx(0.25, abs=0.01)
    assert metrics["hand_position_error_cm"]["max"] == pytest.approx(50.0)
    assert metrics["hand_position_error_in_reach_cm"]["max"] < 1e-9
    assert metrics["foot_skate_cm_s"]["mean"] == 0.0, "nothing in contact, nothing to measure"
    assert "mpjpe_cm" not in metrics and "floor" not in metrics["root_error_cm"]


def test_what_was_played(truth: Motion, trackers: Recording) -> None:
    metrics = measure(truth, truth, trackers)
    count = len(truth)
    assert metrics["transitions_per_s"] == pytest.approx(60.0 / (count - 1))
    # frames 0..49 and then 10..: all of the second run from 50 on is new
    assert metrics["poses_used"] == count - 40
    assert metrics["clamped_fraction"] == pytest.approx(0.25, abs=0.01)
    # frame 10 instead of 50, in a feature that counts frames
    assert metrics["pose_jump"]["max"] == pytest.approx(40.0)


def test_a_jump_between_databases_is_measured_by_the_new_one(truth: Motion) -> None:
    play = playback(truth)
    database = np.where(np.arange(len(truth)) < 50, 0, 1)
    # left: frame 50 at 50; in the other's measure (50 - 5) / 2, everywhere else (0 - 5) / 2 = -2.5 against 0
    jump = pose_jumps(replace(play, database=database), databases(len(truth)))
    assert jump[0] == pytest.approx(np.sqrt((10 - 22.5) ** 2 + 14 * 2.5**2))


def test_targets_are_scaled_to_the_avatar(truth: Motion, trackers: Recording) -> None:
    half = replace(playback(truth), target_positions=playback(truth).target_positions / 2.0)
    metrics = bake_metrics(
        truth, np.ones((len(truth), 2), bool), trackers, half, databases(len(truth)),
        np.zeros((len(truth), 2), bool), scale=2.0,
    )  # fmt: skip
    assert metrics["root_error_cm"]["max"] < 1e-9


def test_skeletons_with_other_spines_are_compared_by_role(truth: Motion, trackers: Recording) -> None:
    """Two spine joints without a role: the chain from hips to chest is compared as one."""
    roles = tuple("" if role in ("spine2", "spine3") else role for role in truth.skeleton.roles)
    other = replace(truth, skeleton=replace(truth.skeleton, roles=roles))
    metrics = measure(truth, other, trackers)
    for name in ("mpjpe_cm", "mpjae_deg", "mpjre_deg"):
        assert metrics[name]["max"] < 1e-5, name


def test_another_length_is_an_error(truth: Motion, trackers: Recording) -> None:
    short = replace(truth, positions=truth.positions[1:], rotations=truth.rotations[1:])
    with pytest.raises(InputError, match="resample"):
        measure(truth, short, trackers)

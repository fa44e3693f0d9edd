"""The whole of matching on real people: the database and its user never share a take or a person."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from footwork.core.body.motion import Motion
from footwork.core.body.standing import standing_head_height
from footwork.core.database.build import build_database
from footwork.core.database.motion_database import MotionDatabase
from footwork.core.database.virtual_root import virtual_root
from footwork.core.jobs import run
from footwork.core.matching.body_target import body_posture
from footwork.core.matching.inertialization import assemble
from footwork.core.matching.playback import Playback, match
from footwork.core.matching.search import BoxSearch, MatrixSearch
from footwork.core.matching.trajectory import make_trajectory
from footwork.core.mocap.takes import load_take
from footwork.core.recording.simulate import simulate_recording
from footwork.core.recording.targets import joint_targets
from footwork.core.settings import BakeSettings, DatabaseSettings

GREEDY = replace(BakeSettings(), search="greedy")

OWN = (
    "walk1_subject1_walk2_filtered",
    "multipleActions1_subject1_jog2_filtered",
    "obstacles2_subject2_walk_filtered",
)
STOOPING = "obstacles5_subject3_jog_filtered"
OTHERS = ("walk2_subject3_walk2_filtered", "obstacles4_subject3_walk_filtered")


@pytest.fixture(scope="module")
def locomotion(data: Path) -> MotionDatabase:
    takes = [load_take(data / "takes/lafan1" / f"{name}.bvh", 60.0) for name in OWN]
    return run(build_database(takes, DatabaseSettings(mirror=True), name="locomotion"))


@pytest.fixture(scope="module")
def users(data: Path) -> list[Motion]:
    return [load_take(data / "takes/lafan1" / f"{name}.bvh", 60.0).motion for name in OTHERS]


def targets_of(db: MotionDatabase, motion: Motion) -> np.ndarray:
    recording = simulate_recording(motion, "user")
    positions, rotations = joint_targets(recording)
    height = standing_head_height(motion)
    posture = body_posture(positions, rotations, recording.valid, height, motion.fps, [db])
    return positions[:, 0, :2] + posture.hips


def play(db: MotionDatabase, motion: Motion, settings: BakeSettings) -> tuple[Playback, Motion]:
    root, yaws = virtual_root(motion, 0.0)
    targets = targets_of(db, motion)
    trajectory = make_trajectory(targets, yaws, 60.0, settings)
    playback = run(match(trajectory, np.ones(len(root)), [db], settings))
    return playback, assemble(playback, [db], settings)[0]


def test_both_searches_agree_on_real_features(locomotion):
    rng = np.random.default_rng(0)
    features = locomotion.features
    ways = [way(features, np.ones(27)) for way in (MatrixSearch, BoxSearch)]
    for frame in rng.integers(0, len(locomotion), 200):
        query = features.values[frame] + rng.normal(0, rng.choice([0.01, 0.3, 2.0]), 27)
        cost = np.sum((features.values.astype(np.float64) - query) ** 2, axis=-1)
        cost[~features.trajectory_valid] = np.inf
        for way in ways:
            assert way.nearest(query)[0] == np.argmin(cost)


def test_the_lean_of_other_people_is_mostly_found(locomotion, users, data):
    users = [*users, load_take(data / "takes/lafan1" / f"{STOOPING}.bvh", 60.0).motion]
    before: list[np.ndarray] = []
    after: list[np.ndarray] = []
    for motion in users:
        root, _ = virtual_root(motion, 0.0)
        head = motion.forward()[0][:, motion.skeleton.joint("head"), :2]
        before.append(np.linalg.norm(head - root, axis=-1))
        after.append(np.linalg.norm(targets_of(locomotion, motion) - root, axis=-1))
    assert np.concatenate(after).mean() < 0.75 * np.concatenate(before).mean()


def test_looking_ahead_follows_better_than_extrapolating(locomotion, users):
    errors: dict[str, list[float]] = {}
    for form in ("causal", "look-ahead"):
        for motion in users:
            playback, result = play(locomotion, motion, replace(GREEDY, trajectory=form))
            root, yaws = virtual_root(motion, 0.0)
            off = np.linalg.norm(playback.root_positions - root, axis=-1)
            turned = np.abs(np.arctan2(np.sin(playback.root_yaws - yaws), np.cos(playback.root_yaws - yaws)))
            errors.setdefault(form, []).append(float(off.mean() + turned.mean()))
            # the body stays over its root, whatever is blended
            assert np.linalg.norm(result.positions[:, :2] - playback.root_positions, axis=-1).max() < 0.25
    assert np.mean(errors["look-ahead"]) < 0.8 * np.mean(errors["causal"])


def test_a_larger_database_follows_better(locomotion, users, data):
    take = load_take(data / "takes/lafan1" / f"{OWN[1]}.bvh", 60.0)
    small = run(build_database([take], DatabaseSettings(), name="small"))
    settings = GREEDY
    errors = []
    for db in (locomotion, small):
        plays = [play(db, motion, settings)[0] for motion in users]
        errors.append(
            np.concatenate(
                [np.linalg.norm(p.root_positions - p.target_positions, axis=-1) for p in plays]
            ).mean()
        )
    assert errors[0] < errors[1] <= settings.alpha

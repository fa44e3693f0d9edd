"""Path search: what it must find by its nature, and that it is worth its time."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from footwork.core.database.motion_database import MotionDatabase
from footwork.core.jobs import run
from footwork.core.matching.path_search import POSITION_M, find_path
from footwork.core.matching.playback import match
from footwork.core.matching.schedule import Schedule
from footwork.core.matching.trajectory import Trajectory, make_trajectory
from footwork.core.settings import BakeSettings
from hypothesis import given, settings
from hypothesis import strategies as st

FPS = 60.0
SETTINGS = replace(BakeSettings(), search="path", trajectory="look-ahead")


def along(database: MotionDatabase, start: int, stop: int) -> Trajectory:
    """The trajectory of somebody who moves as frames of the database do."""
    path, yaws = database.poses.root_positions[start:stop], database.poses.root_yaws[start:stop]
    return make_trajectory(path, yaws, FPS, SETTINGS)


def schedule(trajectory: Trajectory, database: MotionDatabase) -> Schedule:
    return run(find_path(trajectory, np.zeros(len(trajectory), np.intp), [database], SETTINGS))


@given(seed=st.integers(0, 100), start=st.integers(0, 60))
@settings(max_examples=15, deadline=None)
def test_who_moves_as_a_clip_does_is_played_that_clip(make_database, seed: int, start: int) -> None:
    database = make_database(seed=seed, lengths=(300, 250))
    trajectory = along(database, start, start + 150)
    playback = run(match(trajectory, np.ones(150), [database], SETTINGS))
    assert len(playback.transitions) <= 1
    # less than what costs 1: the targets are smoothed, the clip is not
    assert np.linalg.norm(playback.root_positions - trajectory.targets, axis=-1).max() < POSITION_M


def test_the_frames_played_are_those_that_were_walked(make_database) -> None:
    apart = []
    for seed in range(20):
        database = make_database(seed=seed, lengths=(300, 250))
        playback = run(match(along(database, 31, 181), np.ones(150), [database], SETTINGS))
        apart.append(np.abs(playback.frame - np.arange(31, 181)).max())
    # the first frame is chosen by its future alone, so it may be a neighbour
    assert np.median(apart) <= 1 and np.mean(np.array(apart) <= 3) >= 0.95


def test_a_schedule_stays_within_clips_and_says_where_it_changes(make_database) -> None:
    database = make_database(lengths=(90, 150, 200, 75))
    other = make_database(seed=7, lengths=(400,))
    trajectory = along(other, 0, 380)
    found = schedule(trajectory, database)
    assert found.times[0] == 0
    lengths = np.diff([*found.times, len(trajectory) - 1])
    assert (lengths > 0).all()
    ends = np.array([clip.stop for clip in database.clips])
    clips = np.searchsorted(ends, found.frames, side="right")
    assert (found.frames + lengths < ends[clips]).all()
    goes_on = [b == a + length for (a, b), length in zip(pairwise(found.frames), lengths, strict=False)]
    np.testing.assert_array_equal(found.changes[1:], ~np.array(goes_on))
    assert not found.changes[0]


def test_each_database_plays_when_it_is_wanted(make_database) -> None:
    low = replace(make_database(seed=1, lengths=(300,)), height_range=(0.0, 0.8))
    high = replace(make_database(seed=2, lengths=(250, 200)), height_range=(0.8, 2.0))
    trajectory = along(make_database(seed=3, lengths=(400,)), 0, 400)
    heights = np.where(np.arange(400) // 77 % 2 == 0, 1.0, 0.6)
    playback = run(match(trajectory, heights, [high, low], SETTINGS))
    np.testing.assert_array_equal(playback.database, (heights < 0.8).astype(int))
    assert set(np.flatnonzero(np.diff(playback.database)) + 1) <= set(playback.transitions.tolist())


@given(seed=st.integers(0, 1000), alpha=st.floats(0.01, 1.0))
@settings(max_examples=20, deadline=None)
def test_the_root_stays_within_alpha(make_database, seed: int, alpha: float) -> None:
    trajectory = along(make_database(seed=seed + 1, lengths=(200,)), 0, 200)
    options = replace(SETTINGS, alpha=alpha)
    playback = run(match(trajectory, np.ones(200), [make_database(seed=seed)], options))
    away = np.linalg.norm(playback.root_positions - trajectory.targets, axis=-1)
    assert away.max() <= alpha + 1e-9


def test_the_same_again_is_the_same(make_database) -> None:
    database, trajectory = make_database(), along(make_database(seed=9, lengths=(400,)), 0, 400)
    first, second = schedule(trajectory, database), schedule(trajectory, database)
    np.testing.assert_array_equal(first.frames, second.frames)


def test_recordings_of_one_and_two_frames(make_database) -> None:
    database = make_database()
    for count in (1, 2):
        playback = run(match(along(database, 10, 10 + count), np.ones(count), [database], SETTINGS))
        assert len(playback) == count


def test_it_follows_better_than_the_greedy_search(make_database) -> None:
    database = make_database(lengths=(300, 300, 300, 300))
    errors = {"path": 0.0, "greedy": 0.0}
    for seed in range(20, 26):
        trajectory = along(make_database(seed=seed, lengths=(400,)), 0, 400)
        for search in errors:
            playback = run(
                match(trajectory, np.ones(400), [database], replace(SETTINGS, search=search, alpha=2.0))
            )
            errors[search] += np.linalg.norm(playback.root_positions - trajectory.targets, axis=-1).mean()
    assert errors["path"] < 0.8 * errors["greedy"]

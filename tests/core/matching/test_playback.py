from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from footwork.core.database.motion_database import MotionDatabase
from footwork.core.errors import InputError
from footwork.core.jobs import run
from footwork.core.matching.greedy_search import quick_changes
from footwork.core.matching.playback import Playback, match
from footwork.core.matching.selection import choose_databases
from footwork.core.matching.trajectory import Trajectory, make_trajectory
from footwork.core.settings import BakeSettings
from hypothesis import given, settings
from hypothesis import strategies as st

GREEDY = replace(BakeSettings(), search="greedy")

FPS = 60.0
QUIET = replace(GREEDY, adjustment=0.0, alpha=2.0)


def user(seed: int, count: int = 300, pace: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """A wandering user: path and body orientation."""
    rng = np.random.default_rng(seed)
    heading = np.cumsum(np.repeat(rng.normal(0, 0.05, count // 20 + 1), 20)[:count])
    step = pace * np.repeat(rng.uniform(0, 2, count // 30 + 1), 30)[:count, None] / FPS
    return np.cumsum(np.stack([-np.sin(heading), np.cos(heading)], -1) * step, axis=0), heading


def play(
    databases: list[MotionDatabase],
    trajectory: Trajectory,
    options: BakeSettings,
    heights: np.ndarray | None = None,
) -> Playback:
    heights = np.ones(len(trajectory)) if heights is None else heights
    return run(match(trajectory, heights, databases, options))


def followers(playback: Playback) -> np.ndarray:
    """Frames from the second on that simply follow the one before."""
    same = np.diff(playback.database) == 0
    return np.flatnonzero(same & (np.diff(playback.frame) == 1)) + 1


@given(
    seed=st.integers(0, 1000),
    alpha=st.floats(0.01, 2.0),
    adjustment=st.floats(0.0, 1.0),
    form=st.sampled_from(["causal", "look-ahead"]),
)
@settings(max_examples=40, deadline=None)
def test_root_stays_within_alpha(make_database, seed, alpha, adjustment, form):
    options = replace(GREEDY, alpha=alpha, adjustment=adjustment, trajectory=form)
    path, yaws = user(seed, pace=2.0)
    playback = play([make_database()], make_trajectory(path, yaws, FPS, options), options)
    away = np.linalg.norm(playback.root_positions - path, axis=-1)
    assert away.max() <= alpha + 1e-9
    np.testing.assert_allclose(away[playback.clamped], alpha, atol=1e-9)
    assert (away[~playback.clamped] <= alpha).all()


@given(seed=st.integers(0, 1000), form=st.sampled_from(["causal", "look-ahead"]))
@settings(max_examples=25, deadline=None)
def test_every_pose_has_a_successor_and_only_transitions_jump(make_database, seed, form):
    db = make_database(lengths=(70, 150, 65))
    options = replace(GREEDY, trajectory=form)
    path, yaws = user(seed)
    playback = play([db], make_trajectory(path, yaws, FPS, options), options)
    clip_of = np.repeat(np.arange(3), (70, 150, 65))
    assert (clip_of[playback.frame + 1] == clip_of[playback.frame]).all()
    jumps = np.setdiff1d(np.arange(1, len(playback)), followers(playback))
    assert set(playback.transitions) == set(jumps)
    assert db.features.trajectory_valid[playback.frame[playback.transitions]].all()


def test_without_adjustment_the_root_moves_as_in_the_clip(make_database):
    db = make_database(1)
    path, yaws = user(7)
    playback = play([db], make_trajectory(path, yaws, FPS, QUIET), QUIET)
    assert len(playback.transitions) > 3
    borders = [0, *playback.transitions, len(playback) - 1]
    for start, stop in pairwise(borders):
        if stop - start < 2:
            continue
        # a rigid movement takes the clip's own root path to what was played
        frames = playback.frame[start] + np.arange(stop - start + 1)
        turn = playback.root_yaws[start] - db.poses.root_yaws[frames[0]]
        c, s = np.cos(turn), np.sin(turn)
        away = db.poses.root_positions[frames] - db.poses.root_positions[frames[0]]
        expected = playback.root_positions[start] + away @ np.array([[c, s], [-s, c]])
        if not playback.clamped[start : stop + 1].any():
            np.testing.assert_allclose(playback.root_positions[start : stop + 1], expected, atol=1e-9)
        np.testing.assert_allclose(
            playback.root_yaws[start : stop + 1], db.poses.root_yaws[frames] + turn, atol=1e-9
        )


def test_a_user_who_moves_as_a_clip_gets_that_clip(make_database):
    db = make_database(2, lengths=(200, 400))
    poses, frames = db.poses, np.arange(230, 430)
    horizons = np.array([20, 40, 60])
    trajectory = Trajectory(
        FPS,
        poses.root_positions[frames],
        poses.root_yaws[frames],
        np.zeros((200, 2)),
        poses.root_positions[frames[:, None] + horizons],
        poses.root_yaws[frames[:, None] + horizons],
    )
    playback = play([db], trajectory, GREEDY)
    np.testing.assert_array_equal(playback.frame, frames)
    assert len(playback.transitions) == 0
    np.testing.assert_allclose(playback.root_positions, poses.root_positions[frames], atol=1e-9)
    np.testing.assert_allclose(playback.root_yaws, poses.root_yaws[frames], atol=1e-9)


def test_adjustment_is_a_share_of_the_clips_own_speed(make_database):
    db = make_database(3)
    path, yaws = user(3)
    options = replace(GREEDY, alpha=2.0, adjustment=0.1)
    playback = play([db], make_trajectory(path, yaws, FPS, options), options)
    assert not playback.clamped.any()
    steps = np.diff(playback.root_positions, axis=0) * FPS
    # the step to frame t is that of the frame which played before it, also where a transition is at t
    own = db.poses.root_velocities[playback.frame[:-1]]
    c, s = np.cos(playback.root_yaws[:-1]), np.sin(playback.root_yaws[:-1])
    own = np.stack([c * own[:, 0] - s * own[:, 1], s * own[:, 0] + c * own[:, 1]], -1)
    added = steps - own
    assert (np.linalg.norm(added, axis=-1) <= 0.1 * np.linalg.norm(own, axis=-1) + 1e-9).all()
    assert np.abs(added).max() > 0.01
    towards = path[1:] - (playback.root_positions[1:] - added / FPS)
    assert (np.sum(added * towards, axis=-1) >= -1e-12).all()
    own_turn = db.poses.root_yaw_velocities[playback.frame[:-1]]
    added_turn = np.diff(playback.root_yaws) * FPS - own_turn
    assert (np.abs(added_turn) <= 0.1 * np.abs(own_turn) + 1e-9).all()


def test_adjustment_halves_the_distance_in_its_halflife(make_database):
    db = make_database(4)
    # a fast character with the whole of its speed to spare, a target that is out of reach by little
    poses = replace(
        db.poses,
        root_velocities=np.broadcast_to([0.0, 3.0], (len(db), 2)),
        root_yaw_velocities=np.zeros(len(db)),
    )
    db = replace(db, poses=poses)
    count = 8
    path = np.stack([np.full(count, 0.0), 3.0 / FPS * np.arange(count)], -1)
    path[1:, 0] += 0.05
    flat = np.zeros((count, 3))
    trajectory = Trajectory(FPS, path, np.zeros(count), np.zeros((count, 2)), np.zeros((count, 3, 2)), flat)
    options = replace(GREEDY, adjustment=1.0, search_every=2.0)
    playback = play([db], trajectory, options)
    left = 0.05 - playback.root_positions[1:, 0]
    np.testing.assert_allclose(left, 0.05 * 0.5 ** (np.arange(1, count) / FPS / 0.1), atol=1e-12)


def test_searches_come_every_ten_frames_and_on_quick_changes(make_database):
    db = make_database(5, lengths=(900,))
    count = 181
    still = np.zeros((count, 2))
    trajectory = make_trajectory(still, np.zeros(count), FPS, GREEDY)
    playback = play([db], trajectory, GREEDY)
    assert playback.searches == 1 + 17
    assert all(t % 10 == 0 for t in playback.transitions)
    dash = np.zeros((count, 2))
    dash[45:, 1] = 2.0
    changed = replace(trajectory, velocities=dash)
    assert np.flatnonzero(quick_changes(dash, FPS)).tolist() == [45]
    assert play([db], changed, GREEDY).searches == 1 + 4 + 1 + 13


def test_quick_change_is_a_rise_of_the_squared_speed():
    speeds = np.array([1.0, 1.0, np.sqrt(1.039), np.sqrt(1.08), 0.0, 0.19, 0.3])
    velocities = np.stack([np.zeros(7), speeds], -1)
    assert quick_changes(velocities, 60.0).tolist() == [False, False, False, True, False, False, True]
    # at twice the rate each frame may rise by half as much
    assert quick_changes(velocities, 120.0).tolist() == [False, False, True, True, False, True, True]


def test_height_picks_the_database(make_database):
    high = make_database(6, height_range=(0.85, 2.0), name="upright")
    low = make_database(7, height_range=(0.0, 0.85), name="crouched")
    heights = np.r_[np.full(57, 1.0), np.full(60, 0.7), np.full(83, 1.0)]
    path, yaws = user(8, 200)
    playback = play([high, low], make_trajectory(path, yaws, FPS, GREEDY), GREEDY, heights)
    np.testing.assert_array_equal(playback.database, np.repeat([0, 1, 0], (57, 60, 83)))
    assert {57, 117} <= set(playback.transitions)


def test_heights_have_hysteresis_and_gaps_have_an_owner():
    ranges = [(0.8, 2.0), (0.5, 0.8)]
    ratios = np.array([1.0, 0.81, 0.79, 0.781, 0.779, 0.79, 0.81, 0.819, 0.821, 0.2, 3.0])
    chosen = choose_databases(ratios, ranges, 0.02)
    assert chosen.tolist() == [0, 0, 0, 0, 1, 1, 1, 1, 0, 1, 0]
    assert choose_databases(ratios, ranges, 0.0).tolist() == [0, 0, 1, 1, 1, 1, 0, 0, 0, 1, 0]
    # equal ranges: the first; a border belongs to the upper one; midway in a gap: the first
    assert choose_databases(np.array([1.0]), [(0.0, 2.0), (0.0, 2.0)], 0.02).tolist() == [0]
    assert choose_databases(np.array([0.8]), [(0.5, 0.8), (0.8, 2.0)], 0.02).tolist() == [1]
    assert choose_databases(np.array([0.75]), [(0.0, 0.5), (1.0, 2.0)], 0.02).tolist() == [0]


def test_same_input_gives_the_same_bytes(make_database):
    databases = [make_database(9, height_range=(0.9, 2)), make_database(10, height_range=(0, 0.9))]
    path, yaws = user(11)
    heights = 0.9 + 0.1 * np.sin(np.arange(300) / 20)

    def bake() -> list[bytes]:
        trajectory = make_trajectory(path, yaws, FPS, GREEDY)
        playback = play(databases, trajectory, GREEDY, heights)
        return [np.asarray(getattr(playback, name)).tobytes() for name in Playback.__slots__]

    assert bake() == bake()


def test_turning_the_world_changes_no_choice(make_database):
    db = make_database(12)
    path, yaws = user(13)
    turn = np.array([[0.0, 1.0], [-1.0, 0.0]])
    here = play([db], make_trajectory(path, yaws, FPS, GREEDY), GREEDY)
    there = play([db], make_trajectory(path @ turn + 3.0, yaws + np.pi / 2, FPS, GREEDY), GREEDY)
    np.testing.assert_array_equal(there.frame, here.frame)
    np.testing.assert_allclose(there.root_positions, here.root_positions @ turn + 3.0, atol=1e-9)
    np.testing.assert_allclose(there.root_yaws, here.root_yaws + np.pi / 2, atol=1e-9)


@pytest.mark.parametrize("count", [1, 2, 11, 12])
def test_shortest_recordings(make_database, count):
    options = GREEDY
    trajectory = make_trajectory(np.zeros((count, 2)), np.ones(count), FPS, options)
    playback = play([make_database()], trajectory, options)
    assert len(playback) == count
    assert playback.root_yaws[0] == 1.0


def test_databases_that_do_not_go_together_are_refused(make_database):
    db = make_database()
    trajectory = make_trajectory(np.zeros((20, 2)), np.zeros(20), FPS, GREEDY)
    slow, tall = make_database(fps=30.0, name="slow"), make_database(name="tall")
    tall = replace(tall, skeleton=replace(tall.skeleton, offsets=tall.skeleton.offsets * 1.1))
    bare = replace(db, name="bare", skeleton=replace(db.skeleton, roles=("hips", "", "head", "", "")))
    short = make_database(lengths=(40, 50), name="short")
    for databases, words in [
        ([], "none is given"),
        ([db, slow], "'slow': 30 frames per second"),
        ([db, tall], "'tall': its body differs"),
        ([db, bare], "'bare': other joints"),
        ([short], "'short': no clip is longer"),
    ]:
        with pytest.raises(InputError, match=words):
            play(databases, trajectory, GREEDY)
    with pytest.raises(InputError, match=r"60 frames per second.*resample"):
        play([slow], trajectory, GREEDY)


def test_what_comes_by_itself_is_not_jumped_to(make_database):
    db = make_database(14, lengths=(900,))
    path, yaws = user(15, 600)
    playback = play([db], make_trajectory(path, yaws, FPS, GREEDY), GREEDY)
    at = playback.transitions
    assert len(at) > 5
    leaps = np.abs(playback.frame[at] - (playback.frame[at - 1] + 1))
    # at the clip's end, frame 899, everything else is allowed
    assert (leaps[playback.frame[at - 1] < 898] > 20).all()

"""What the path search weighs: drift that alpha will hold, changes to neighbours of the frame that plays."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.database.motion_database import (
    FEATURE_GROUPS,
    HORIZONS_S,
    Clip,
    FeatureDatabase,
    MotionDatabase,
    PoseDatabase,
)
from footwork.core.jobs import run
from footwork.core.matching import path_search
from footwork.core.matching.path_search import Schedule, find_path
from footwork.core.matching.playback import Playback, match
from footwork.core.matching.trajectory import Trajectory, make_trajectory
from footwork.core.settings import BakeSettings

FPS = 60.0
NEAR = 20
"""Frames: a third of a second."""
SETTINGS = replace(BakeSettings(), search="path", trajectory="look-ahead")


Piece = tuple[np.ndarray, np.ndarray, np.ndarray]
STEP = 10
"""Frames between two choices."""
AHEAD = 60
"""Frames by which the paths of a piece go on past its poses, so that each of these has a future."""


def spliced(like: MotionDatabase, pieces: list[Piece], ends: int = AHEAD) -> MotionDatabase:
    """A database of clips of T frames, each a root path `(T + AHEAD, 2)` in metres, yaws `(T + AHEAD,)` and pose
    features `(T, 15)`; the last `ends` frames of each cannot be changed to."""
    raw = np.concatenate([features(*piece) for piece in pieces])
    deviation = np.ones(27)
    for group in FEATURE_GROUPS.values():
        spread = raw[:, group].std(axis=0).mean()
        deviation[group] = spread if spread > 1e-5 else 1.0
    mean = raw.mean(axis=0)
    steps = [(np.diff(path, axis=0) * FPS, np.diff(yaws) * FPS, yaws) for path, yaws, _ in pieces]
    counts = [len(pose) for _, _, pose in pieces]
    stops, count, joints = np.cumsum(counts), sum(counts), len(like.skeleton)

    def joined(columns: list[np.ndarray]) -> np.ndarray:
        return np.concatenate([column[:number] for column, number in zip(columns, counts, strict=True)])

    poses = PoseDatabase(
        root_positions=joined([path for path, _, _ in pieces]),
        root_yaws=joined([yaws for _, yaws, _ in pieces]),
        hips_positions=np.tile([0.0, 0.0, 0.9], (count, 1)),
        rotations=np.tile([1.0, 0.0, 0.0, 0.0], (count, joints, 1)),
        root_velocities=joined([seen_from(step, yaws[:-1]) for step, _, yaws in steps]),
        root_yaw_velocities=joined([turn for _, turn, _ in steps]),
        hips_velocities=np.zeros((count, 3)),
        angular_velocities=np.zeros((count, joints, 3)),
        contacts=np.ones((count, 2), np.bool_),
    )
    clips = [
        Clip(f"clip{i}", int(stop) - number, int(stop), "", "", False)
        for i, (number, stop) in enumerate(zip(counts, stops, strict=True))
    ]
    values = ((raw - mean) / deviation).astype(np.float32)
    known = joined([np.arange(number) < number - ends for number in counts])
    return replace(
        like, clips=tuple(clips), poses=poses, features=FeatureDatabase(values, mean, deviation, known)
    )


def seen_from(vectors: np.ndarray, yaws: np.ndarray) -> np.ndarray:
    """Vectors `(T, 2)` along the axes of somebody who is turned by `yaws` `(T,)`."""
    c, s = np.cos(yaws), np.sin(yaws)
    return np.stack([c * vectors[:, 0] + s * vectors[:, 1], c * vectors[:, 1] - s * vectors[:, 0]], axis=-1)


def features(path: np.ndarray, yaws: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """Raw features `(T, 27)` of a piece."""
    now = slice(0, len(pose))
    places: list[np.ndarray] = []
    facing: list[np.ndarray] = []
    for horizon in HORIZONS_S:
        later = np.arange(len(pose)) + round(horizon * FPS)
        turn = yaws[later] - yaws[now]
        places.append(seen_from(path[later] - path[now], yaws[now]))
        facing.append(np.stack([-np.sin(turn), np.cos(turn)], axis=-1))
    return np.concatenate([*places, *facing, pose], axis=-1)


def search(trajectory: Trajectory, database: MotionDatabase, **options: float) -> Schedule:
    wanted = np.zeros(len(trajectory), np.intp)
    return run(find_path(trajectory, wanted, [database], replace(SETTINGS, **options)))


def drifting(like: MotionDatabase, speed: float, apart: float) -> MotionDatabase:
    """Two clips of somebody who looks north and drifts east, or west, in poses whose features differ by `apart`
    deviations."""
    frames = np.arange(900 + AHEAD)
    pieces: list[Piece] = []
    for sign in (1.0, -1.0):
        path = np.stack([sign * speed / FPS * frames, np.zeros(len(frames))], axis=-1)
        pose = 0.5 * sign * apart + np.sqrt(2.0) * np.sin(0.1 * frames[:900, None] + np.arange(15))
        pieces.append((path, np.zeros(len(frames)), pose))
    return spliced(like, pieces)


def test_drift_that_alpha_will_hold_is_not_paid_for_by_changes(make_database) -> None:
    """A user stands; all that the database has drifts by 10 cm/s, of which an alpha of 2 cm shows 2 cm at most."""
    database = drifting(make_database(), 0.1, 1.0)
    standing = make_trajectory(np.zeros((600, 2)), np.zeros(600), FPS, SETTINGS)
    held = search(standing, database, alpha=0.02)
    free = search(standing, database, alpha=2.0)
    assert np.ptp(clips_of(held, database, 600)) == 0
    assert 2 <= np.abs(np.diff(clips_of(free, database, 600))).sum() <= 20
    # where nothing holds the root the changes are what keeps it near
    playback = run(match(standing, np.ones(600), [database], replace(SETTINGS, alpha=2.0)))
    assert np.linalg.norm(playback.root_positions, axis=-1).max() < 0.45


def test_alpha_holds_each_history_by_its_own_way(make_database) -> None:
    """East or west by 2 m/s, along a user who goes east, stands, goes west: what is held on one side is free on the
    other, so the path changes with the user however small alpha is."""
    database = drifting(make_database(), 1.0, 0.2)
    speed = np.where(np.arange(540) // 180 == 0, 1.0, np.where(np.arange(540) // 180 == 1, 0.0, -1.0))
    path = np.stack([np.cumsum(speed) / FPS, np.zeros(540)], axis=-1)
    user = make_trajectory(path, np.zeros(540), FPS, SETTINGS)
    found = search(user, database, alpha=0.05)
    playing = clips_of(found, database, 540)
    assert (playing[20:160] == 0).mean() > 0.95 and (playing[380:520] == 1).mean() > 0.95


def clips_of(found: Schedule, database: MotionDatabase, count: int) -> np.ndarray:
    """The clip `(T,)` that plays at each frame."""
    starts = np.array([clip.start for clip in database.clips])
    out = np.empty(count, np.intp)
    for t, frame in zip(found.times, found.frames, strict=True):
        out[t:] = np.searchsorted(starts, frame, side="right") - 1
    return out


def changes(playback: Playback, database: MotionDatabase) -> list[tuple[int, int, int, bool]]:
    """Of each transition: the frame that would have followed, the one that plays, those left of its clip, and whether
    both are of one clip."""
    ends = np.array([clip.stop for clip in database.clips])
    out = []
    for at in playback.transitions.tolist():
        would, plays = int(playback.frame[at - 1]) + 1, int(playback.frame[at])
        old, new = (int(np.searchsorted(ends, frame, side="right")) for frame in (would - 1, plays))
        out.append((would, plays, int(ends[old]) - would, old == new))
    return out


@pytest.mark.parametrize("seed", range(4))
def test_no_change_goes_to_a_neighbour_of_what_plays(make_database, seed: int) -> None:
    """A user who is half as fast again as the database would be followed by little jumps ahead, again and again."""
    database = make_database(seed=seed, lengths=(500, 400))
    poses, clip = database.poses, slice(0, 450)
    stretch = np.linspace(0.0, 449.0, 301)
    columns = [
        np.interp(stretch, np.arange(450), column[clip])
        for column in (*poses.root_positions.T, poses.root_yaws)
    ]
    user = make_trajectory(np.column_stack(columns[:2]), columns[2], FPS, SETTINGS)
    playback = run(match(user, np.ones(301), [database], SETTINGS))
    made = changes(playback, database)
    assert made
    for would, plays, left, same in made:
        assert not same or abs(plays - would) > NEAR or left <= 11


def test_a_neighbour_in_another_clip_is_no_neighbour(make_database) -> None:
    """A clip goes astray in its last quarter of a second; the next one goes on as the user does, 15 frames away."""
    rng = np.random.default_rng(3)
    frames = np.arange(400 + AHEAD)
    # no two places of the path are alike
    yaws = 0.00006 * frames**2 + 0.3 * np.sin(0.05 * frames)
    speed = 1.0 + 0.5 * np.sin(0.031 * frames)
    path = np.cumsum(speed[:, None] / FPS * np.stack([-np.sin(yaws), np.cos(yaws)], axis=-1), axis=0)
    phase = rng.uniform(0.0, 6.0, 15)
    pose = 0.5 * np.sin((0.05 + 0.0002 * frames[:400, None]) * frames[:400, None] + phase)
    away = np.clip(frames - 80, 0, 15)[:, None] * np.array([0.1, 0.04]) * (frames < 95)[:, None]
    first = (path + away)[: 95 + AHEAD], yaws[: 95 + AHEAD], pose[:95]
    database = spliced(make_database(), [first, (path[80:], yaws[80:], pose[80:])])
    user = make_trajectory(path[:300], yaws[:300], FPS, SETTINGS)
    found = search(user, database)
    plan = dict(zip(found.times.tolist(), found.frames.tolist(), strict=True))
    assert abs(plan[70] - 70) <= 2
    assert abs(plan[80] - 95) <= 2
    assert found.changes[found.times == 80].all()


class Reckoner:
    """What a history costs, as docs/matching.md and the module's constants say it, for one database."""

    def __init__(self, database: MotionDatabase, user: Trajectory, alpha: float) -> None:
        self.poses, self.values = database.poses, np.asarray(database.features.values, np.float64)
        self.mean, self.deviation = database.features.mean[:12], database.features.deviation[:12]
        self.user, self.alpha = user, alpha
        self.ends = np.concatenate(
            [np.full(clip.stop - clip.start, clip.stop - 1) for clip in database.clips]
        )
        self.candidates = np.flatnonzero(database.features.trajectory_valid)

    def allowed(self, playing: np.ndarray, frames: np.ndarray, length: int) -> np.ndarray:
        """Whether those who would play on at `playing` may change to `frames`."""
        far = (np.abs(frames - playing) > NEAR) | (self.ends[frames] != self.ends[playing])
        return far | (self.ends[playing] - playing < length)

    def step(
        self, roots: np.ndarray, playing: np.ndarray | None, frames: np.ndarray, t: int, stop: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """Costs `(N,)` of playing `frames` from `t` to `stop`, and the roots `(N, 3)` then."""
        wanted = np.empty((len(frames), 12))
        for k in range(3):
            away = self.user.future_positions[t, k] - roots[:, :2]
            turn = self.user.future_yaws[t, k] - roots[:, 2]
            wanted[:, 2 * k : 2 * k + 2] = seen_from(away, roots[:, 2])
            wanted[:, 6 + 2 * k], wanted[:, 7 + 2 * k] = -np.sin(turn), np.cos(turn)
        wanted = (wanted - self.mean) / self.deviation
        costs = 0.05 * np.sum((self.values[frames, :12] - wanted) ** 2, axis=-1)
        if playing is not None:
            jump = np.sum((self.values[frames, 12:] - self.values[playing, 12:]) ** 2, axis=-1)
            costs += np.where(frames == playing, 0.0, 1.0 + 0.35 * jump)
        for now in ((t + stop) // 2, stop):
            after = frames + now - t
            way = self.poses.root_positions[after] - self.poses.root_positions[frames]
            turn = self.poses.root_yaws[after] - self.poses.root_yaws[frames]
            place = roots[:, :2] + seen_from(way, self.poses.root_yaws[frames] - roots[:, 2])
            away = place - self.user.targets[now]
            wrong = (roots[:, 2] + turn - self.user.yaws[now] + np.pi) % (2.0 * np.pi) - np.pi
            costs += 0.5 * (np.sum(away**2, axis=-1) / 0.1**2 + (wrong / 0.2) ** 2)
        distance = np.linalg.norm(away, axis=-1)
        share = np.where(distance > self.alpha, self.alpha / np.maximum(distance, 1e-12), 1.0)
        held = self.user.targets[stop] + away * share[:, None]
        return costs, np.column_stack([held, roots[:, 2] + turn])

    def cost(self, found: Schedule) -> float:
        """Of one schedule."""
        total, roots = 0.0, np.array([[*self.user.targets[0], self.user.yaws[0]]])
        playing: np.ndarray | None = None
        stops = [*found.times[1:].tolist(), len(self.user) - 1]
        for t, stop, frame in zip(found.times.tolist(), stops, found.frames.tolist(), strict=True):
            frames = np.array([frame])
            if playing is not None and frame != playing[0]:
                assert self.allowed(playing, frames, stop - t).all()
            costs, roots = self.step(roots, playing, frames, t, stop)
            total, playing = total + float(costs[0]), frames + stop - t
        return total

    def least(self, times: list[int]) -> float:
        """Of the best schedule that a search finds which tries every frame and keeps one history for each."""
        roots = np.array([[*self.user.targets[0], self.user.yaws[0]]])
        costs, playing = np.zeros(1), None
        for t, stop in zip(times, [*times[1:], len(self.user) - 1], strict=True):
            count = len(self.candidates)
            parents = np.repeat(np.arange(len(roots)), count)
            frames = np.tile(self.candidates, len(roots))
            if playing is not None:
                may = self.allowed(playing[parents], frames, stop - t)
                going = np.flatnonzero(self.ends[playing] - playing >= stop - t)
                parents = np.concatenate([parents[may], going])
                frames = np.concatenate([frames[may], playing[going]])
            now = None if playing is None else playing[parents]
            more, moved = self.step(roots[parents], now, frames, t, stop)
            total = costs[parents] + more
            order = np.argsort(total, kind="stable")
            best = order[np.unique(frames[order], return_index=True)[1]]
            costs, roots, playing = total[best], moved[best], frames[best] + stop - t
        return float(costs.min())


@pytest.mark.parametrize("alpha", [0.04, 0.15, 2.0])
def test_a_search_that_tries_every_frame_finds_the_best_there_is(
    make_database, alpha: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On users whom the database cannot follow, so that what alpha holds counts at each step."""
    for name, value in (("BEAMS", 1000), ("OPTIONS", 1000), ("_BLOCK", 1), ("_SAME", 1)):
        monkeypatch.setattr(path_search, name, value)
    for seed in range(8):
        made = make_database(seed=seed, lengths=(115, 105, 110))
        rows = [np.arange(clip.start, clip.stop) for clip in made.clips]
        database = spliced(
            made,
            [
                (
                    made.poses.root_positions[row],
                    made.poses.root_yaws[row],
                    made.features.values[row[:-AHEAD], 12:].astype(np.float64),
                )
                for row in rows
            ],
            ends=STEP,
        )
        other = make_database(seed=seed + 50, lengths=(200,)).poses
        user = make_trajectory(1.4 * other.root_positions[20:91], other.root_yaws[20:91], FPS, SETTINGS)
        reckoner = Reckoner(database, user, alpha)
        found = search(user, database, alpha=alpha)
        least = reckoner.least(found.times.tolist())
        assert reckoner.cost(found) == pytest.approx(least, rel=1e-4)

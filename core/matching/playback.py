"""Motion matching over a whole recording: which frame of which database plays when, and where its root is.

Paper, sections 5.3 to 5.5. Between two searches the frames of a clip follow each other, carry the root along,
and let it be drawn to its target; that part is a recurrence over frames and is kept to plain numbers. A
search then asks for the frame that goes on best.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..database.motion_database import FEATURE_COUNT, POSE, TRAJECTORY, MotionDatabase
from ..errors import InputError
from ..jobs import Job
from ..settings import BakeSettings
from .path_search import Schedule, find_path
from .search import PlainSearch, Search, feature_weights, make_search, trajectory_only
from .selection import check_databases, choose_databases
from .trajectory import Trajectory

Array = NDArray[np.floating[Any]]

ADJUSTMENT_HALFLIFE_S = 0.1
"""The root would reach half way to its target in this time, were it not for the limit by speed."""
NEAR_S = 1.0 / 3.0
"""A find within this time of the present frame in its clip is left alone: the clip gets there by itself."""
QUICK_CHANGE = 0.2**2 * 60.0
"""Rise of the target's squared speed, (m/s)^2 per second, from which a search does not wait: 0.2^2 a frame
at 60 fps."""


@dataclass(frozen=True, slots=True, eq=False)
class Playback:
    """What plays at each frame of a recording, and where."""

    database: NDArray[np.intp]
    """`(T,)` index of the database."""
    frame: NDArray[np.intp]
    """`(T,)` frame in it; never the last of a clip, so that `frame + 1` is what would have followed."""
    root_positions: Array
    """`(T, 2)` virtual root in the world, metres."""
    root_yaws: Array
    """`(T,)` radians, without jumps."""
    transitions: NDArray[np.intp]
    """`(K,)` frames at which something else plays than what would have followed."""
    clamped: NDArray[np.bool_]
    """`(T,)` whether the root was held at alpha from its target."""
    target_positions: Array
    """`(T, 2)` metres."""
    target_yaws: Array
    """`(T,)` radians."""
    searches: int
    """How often was searched."""

    def __len__(self) -> int:
        return len(self.frame)


def match(
    trajectory: Trajectory,
    height_ratios: Array,
    databases: Sequence[MotionDatabase],
    settings: BakeSettings,
) -> Job[Playback]:
    """Play databases along a trajectory.

    Args:
        trajectory: targets and futures, at the rate of the databases.
        height_ratios: `(T,)` height of the headset over its calibrated height.
        databases: at least one; all of one skeleton and rate. The height decides which plays.
        settings: alpha, adjustment, search interval, weights, height margin.

    Raises:
        InputError: the databases do not go together, or the trajectory has another rate.
    """
    check_databases(databases)
    if abs(trajectory.fps - databases[0].fps) > 1e-6 * trajectory.fps:
        raise InputError(
            f"recording: {trajectory.fps:g} frames per second, "
            f"but the databases have {databases[0].fps:g}; resample it"
        )
    ranges = [database.height_range for database in databases]
    wanted = choose_databases(height_ratios, ranges, settings.height_margin)
    if settings.search == "greedy":
        return (yield from _Player(trajectory, wanted, databases, settings).play())
    schedule = yield from find_path(trajectory, wanted, databases, settings)
    return _Player(trajectory, wanted, databases, settings).follow(schedule)


def quick_changes(velocities: Array, fps: float) -> NDArray[np.bool_]:
    """Frames `(T,)` at which the speed of the target, `(T, 2)` m/s, has risen so fast that a search must not
    wait."""
    squared = np.einsum("ij,ij->i", velocities, velocities)
    return np.diff(squared, prepend=squared[:1]) * fps > QUICK_CHANGE


class _Reel:
    """One database made ready to be played: its root motion as plain numbers, its search."""

    def __init__(self, database: MotionDatabase, settings: BakeSettings) -> None:
        poses, dt = database.poses, 1.0 / database.fps
        self.features = database.features
        self.mean, self.deviation = (
            column[TRAJECTORY] for column in (database.features.mean, database.features.deviation)
        )
        """Of the trajectory's features `(12,)`."""
        self.search: Search = make_search(database.features, feature_weights(settings))
        caps = settings.adjustment * np.linalg.norm(poses.root_velocities, axis=-1)
        turn_caps = settings.adjustment * np.abs(poses.root_yaw_velocities)
        steps = np.column_stack([poses.root_velocities, poses.root_yaw_velocities, caps, turn_caps]) * dt
        self.steps: list[tuple[float, ...]] = list(zip(*(column.tolist() for column in steps.T), strict=True))
        """A frame's own x, y, yaw and the most that x, y and yaw may be adjusted, for the step to the next
        frame."""
        self.last: NDArray[np.intp] = np.empty(len(database), dtype=np.intp)
        for clip in database.clips:
            self.last[clip.start : clip.stop] = clip.stop - 1


class _Player:
    """The state of a playback: the root, the frame, and what was played so far."""

    def __init__(
        self,
        trajectory: Trajectory,
        wanted: NDArray[np.intp],
        databases: Sequence[MotionDatabase],
        settings: BakeSettings,
    ) -> None:
        self._trajectory, self._wanted, self._settings = trajectory, wanted, settings
        used = set(wanted.tolist())
        self._reels = {i: _Reel(database, settings) for i, database in enumerate(databases) if i in used}
        self._targets = list(
            zip(*(column.tolist() for column in (*trajectory.targets.T, trajectory.yaws)), strict=True)
        )
        self._futures = np.concatenate(
            [trajectory.future_positions.reshape(-1, 6), trajectory.future_yaws], axis=-1
        )
        count = len(trajectory)
        self._database = np.empty(count, dtype=np.intp)
        self._frame = np.empty(count, dtype=np.intp)
        self._transitions: list[int] = []
        self._searches = 0
        self._root = self._targets[0]
        self._path = [self._root]
        self._clamped = [False]

    def play(self) -> Job[Playback]:
        """All frames, from the first pose on."""
        every = max(1, round(self._settings.search_every * self._trajectory.fps))
        urgent = quick_changes(self._trajectory.velocities, self._trajectory.fps)
        urgent[1:] |= np.diff(self._wanted) != 0
        end = len(urgent) - 1
        alarms = [end, *reversed(np.flatnonzero(urgent[:end]).tolist())]
        database, frame, t = int(self._wanted[0]), self._first_frame(), 0
        while t < end:
            reel = self._reels[database]
            while alarms[-1] <= t:
                alarms.pop()
            stop = min(t + every, alarms[-1], t + int(reel.last[frame]) - frame)
            self._advance(reel, frame, t, stop)
            self._database[t : stop + 1] = database
            self._frame[t : stop + 1] = np.arange(frame, frame + stop - t + 1)
            frame, t = frame + stop - t, stop
            if t < end or frame == reel.last[frame]:
                database, frame = self._search(t, database, frame)
            yield t / end, "Matching"
        self._database[t], self._frame[t] = database, frame
        return self._result()

    def follow(self, schedule: Schedule) -> Playback:
        """All frames as scheduled, with the same adjustment and bound."""
        end = len(self._targets) - 1
        stops = [*schedule.times[1:].tolist(), end]
        for t, stop, frame in zip(schedule.times.tolist(), stops, schedule.frames.tolist(), strict=True):
            database = int(self._wanted[t])
            self._advance(self._reels[database], frame, t, stop)
            self._database[t : stop + 1] = database
            self._frame[t : stop + 1] = np.arange(frame, frame + stop - t + 1)
        self._transitions = schedule.times[schedule.changes].tolist()
        self._searches = len(schedule.times)
        return self._result()

    def _advance(self, reel: _Reel, frame: int, start: int, stop: int) -> None:
        """Carry the root from `start` to `stop` while `frame` and what follows plays."""
        x, y, yaw = self._root
        path, held = self._path, self._clamped
        alpha = self._settings.alpha
        share = 1.0 - 2.0 ** (-1.0 / (self._trajectory.fps * ADJUSTMENT_HALFLIFE_S))
        steps, goals = reel.steps[frame : frame + stop - start], self._targets[start + 1 : stop + 1]
        cos, sin, hypot, remainder = math.cos, math.sin, math.hypot, math.remainder
        for (forth, side, turn, cap, turn_cap), (goal_x, goal_y, goal_yaw) in zip(steps, goals, strict=True):
            cosine, sine = cos(yaw), sin(yaw)
            x += cosine * forth - sine * side
            y += sine * forth + cosine * side
            yaw += turn
            away_x, away_y = x - goal_x, y - goal_y
            away = hypot(away_x, away_y)
            step = share * away
            left = away - (cap if step > cap else step)
            clamped = left > alpha
            if away > 0.0:
                scale = (alpha if clamped else left) / away
                x, y = goal_x + scale * away_x, goal_y + scale * away_y
            turn = share * remainder(goal_yaw - yaw, math.tau)
            # min(max()) spelt out: calls are most of this loop's time
            yaw += turn_cap if turn > turn_cap else -turn_cap if turn < -turn_cap else turn
            path.append((x, y, yaw))
            held.append(clamped)
        self._root = (x, y, yaw)

    def _first_frame(self) -> int:
        """The frame whose future fits best, whatever its pose: nothing came before it."""
        reel = self._reels[int(self._wanted[0])]
        weights = trajectory_only(feature_weights(self._settings))
        self._searches += 1
        query = self._query(0, reel, np.zeros(FEATURE_COUNT)[POSE])
        return PlainSearch(reel.features, weights).nearest(query)[0]

    def _search(self, t: int, database: int, frame: int) -> tuple[int, int]:
        """What plays at `t`, where `frame` would play on: that one, unless another fits strictly better."""
        wanted = int(self._wanted[t])
        now, then = self._reels[database], self._reels[wanted]
        pose = now.features.values[frame, POSE]
        if now is not then:
            pose = pose * now.features.deviation[POSE] + now.features.mean[POSE]
            pose = (pose - then.features.mean[POSE]) / then.features.deviation[POSE]
        query = self._query(t, then, pose)
        may_stay = wanted == database and frame < now.last[frame]
        found, _ = then.search.nearest(query, then.search.cost(query, frame) if may_stay else math.inf)
        self._searches += 1
        near = abs(found - frame) <= NEAR_S * self._trajectory.fps and now.last[found] == now.last[frame]
        if found < 0 or (may_stay and near):
            return database, frame
        self._transitions.append(t)
        return wanted, found

    def _query(self, t: int, reel: _Reel, pose: Array) -> Array:
        """The query `(27,)` at `t`: the wanted future seen from the root, normalised, and the normalised
        `pose` `(15,)`."""
        x, y, yaw = self._root
        cosine, sine = math.cos(yaw), math.sin(yaw)
        x0, y0, x1, y1, x2, y2, yaw0, yaw1, yaw2 = self._futures[t].tolist()
        ahead: list[float] = []
        for away_x, away_y in ((x0 - x, y0 - y), (x1 - x, y1 - y), (x2 - x, y2 - y)):
            ahead += (cosine * away_x + sine * away_y, cosine * away_y - sine * away_x)
        for turn in (yaw0 - yaw, yaw1 - yaw, yaw2 - yaw):
            ahead += (-math.sin(turn), math.cos(turn))
        query = np.empty(FEATURE_COUNT)
        np.subtract(ahead, reel.mean, out=query[TRAJECTORY])
        query[TRAJECTORY] /= reel.deviation
        query[POSE] = pose
        return query

    def _result(self) -> Playback:
        path = np.array(self._path)
        return Playback(
            database=self._database,
            frame=self._frame,
            root_positions=path[:, :2],
            root_yaws=path[:, 2],
            transitions=np.array(self._transitions, dtype=np.intp),
            clamped=np.array(self._clamped),
            target_positions=self._trajectory.targets,
            target_yaws=self._trajectory.yaws,
            searches=self._searches,
        )

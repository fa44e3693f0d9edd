"""Greedy search, as in the paper: every ten frames the frame that goes on best from where the root is now.

A search does not wait where the target's speed rises quickly or the database changes (paper, sections 5.3 to 5.5).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..database.motion_database import FEATURE_COUNT, FEATURE_GROUPS, POSE, TRAJECTORY, MotionDatabase
from ..jobs import Job
from ..maths import angles
from ..settings import BakeSettings
from .evidence import FEET_M
from .root_motion import RootMotion, goals_of, last_frames
from .schedule import Frames, Schedule
from .search import PlainSearch, Search, feature_weights, make_search, trajectory_only
from .trajectory import Trajectory

Array = NDArray[np.floating[Any]]

NEAR_S = 1.0 / 3.0
"""A find within this time of the present frame in its clip is left alone: the clip gets there by itself."""
FOLLOWED = 4.0
"""What the user's feet, where they are surely known, weigh beside those that play."""
_FEET = tuple(FEATURE_GROUPS[f"{side}_foot_position"].start for side in ("left", "right"))
"""First columns of the places of left and right foot: x and y."""
QUICK_CHANGE = 0.2**2 * 60.0
"""Rise of the target's squared speed, (m/s)^2 per second, from which a search does not wait: 0.2^2 a frame
at 60 fps."""


def find_greedily(
    trajectory: Trajectory, wanted: Frames, databases: Sequence[MotionDatabase], settings: BakeSettings
) -> Job[Schedule]:
    """The schedule that takes the best frame at each search.

    Args:
        trajectory: targets and futures of `T` frames at the databases' rate.
        wanted: `(T,)` index of the database that plays.
        databases: all of one skeleton and rate.
        settings: alpha, adjustment, search interval, weights.
    """
    return (yield from _Greedy(trajectory, wanted, databases, settings).find())


def quick_changes(velocities: Array, fps: float) -> NDArray[np.bool_]:
    """Frames `(T,)` at which the speed of the target, `(T, 2)` m/s, has risen so fast that a search must not
    wait."""
    squared = np.einsum("ij,ij->i", velocities, velocities)
    return np.diff(squared, prepend=squared[:1]) * fps > QUICK_CHANGE


class _SearchedDatabase:
    """One database made ready for one query at a time."""

    def __init__(self, database: MotionDatabase, settings: BakeSettings) -> None:
        self.features = database.features
        self.mean, self.deviation = (
            column[TRAJECTORY] for column in (database.features.mean, database.features.deviation)
        )
        """Of the trajectory's features `(12,)`."""
        self.search: Search = make_search(database.features, feature_weights(settings))
        self.motion = RootMotion(database, settings)
        self.last = last_frames(database)


class _Greedy:
    """The state of a search: the root, and what was chosen so far."""

    def __init__(
        self,
        trajectory: Trajectory,
        wanted: Frames,
        databases: Sequence[MotionDatabase],
        settings: BakeSettings,
    ) -> None:
        self._trajectory, self._wanted, self._settings = trajectory, wanted, settings
        self._databases = {int(i): _SearchedDatabase(databases[int(i)], settings) for i in np.unique(wanted)}
        self._goals = goals_of(trajectory)
        self._futures = np.concatenate(
            [trajectory.future_positions.reshape(-1, 6), trajectory.future_yaws], axis=-1
        )
        self._root = self._goals[0]

    def find(self) -> Job[Schedule]:
        """All searches, from the first frame on."""
        every = max(1, round(self._settings.search_every * self._trajectory.fps))
        urgent = quick_changes(self._trajectory.velocities, self._trajectory.fps)
        urgent[1:] |= np.diff(self._wanted) != 0
        end = len(urgent) - 1
        alarms = [end, *reversed(np.flatnonzero(urgent[:end]).tolist())]
        frame, t = self._first_frame(), 0
        found = [(0, frame, False)]
        while t < end:
            played = self._databases[int(self._wanted[t])]
            while alarms[-1] <= t:
                alarms.pop()
            stop = min(t + every, alarms[-1], t + int(played.last[frame]) - frame)
            path, _ = played.motion.advance(self._root, frame, self._goals[t + 1 : stop + 1])
            self._root = path[-1]
            before, frame = t, frame + stop - t
            t = stop
            if t < end or frame == played.last[frame]:
                frame, change = self._search(t, int(self._wanted[before]), frame)
                found.append((t, frame, change))
            yield t / end, "Matching"
        times, frames, changes = zip(*found, strict=True)
        return Schedule(np.array(times, np.intp), np.array(frames, np.intp), np.array(changes, np.bool_))

    def _first_frame(self) -> int:
        """The frame whose future fits best, whatever its pose: nothing came before it."""
        first = self._databases[int(self._wanted[0])]
        weights = trajectory_only(feature_weights(self._settings))
        query = self._query(0, first, np.zeros(FEATURE_COUNT)[POSE])
        return PlainSearch(first.features, weights).nearest(query)[0]

    def _search(self, t: int, database: int, frame: int) -> tuple[int, bool]:
        """The frame that plays at `t`, and whether it is another than `frame`, which would follow.

        That one stays, unless another fits strictly better.
        """
        wanted = int(self._wanted[t])
        now, then = self._databases[database], self._databases[wanted]
        pose = now.features.values[frame, POSE]
        if now is not then:
            pose = pose * now.features.deviation[POSE] + now.features.mean[POSE]
            pose = (pose - then.features.mean[POSE]) / then.features.deviation[POSE]
        query = self._query(t, then, self._stepping(t, then, pose))
        may_stay = wanted == database and frame < now.last[frame]
        found, _ = then.search.nearest(query, then.search.cost(query, frame) if may_stay else math.inf)
        near = abs(found - frame) <= NEAR_S * self._trajectory.fps and now.last[found] == now.last[frame]
        if found < 0 or (may_stay and near):
            return frame, False
        return found, True

    def _stepping(self, t: int, database: _SearchedDatabase, pose: Array) -> Array:
        """Normalised pose features `(15,)` whose feet are drawn to where the user's are, if that is known."""
        evidence = self._trajectory.feet
        if evidence is None:
            return pose
        ankles = angles.turn(evidence.ankles[t, :, :2], np.full(2, -self._root[2]))
        out = np.array(pose)
        for foot, first in enumerate(_FEET):
            columns = slice(first, first + 2)
            wanted = (ankles[foot] - database.features.mean[columns]) / database.features.deviation[columns]
            weight = FEET_M**2 * evidence.weights[t, foot]
            share = FOLLOWED * weight / (1.0 + FOLLOWED * weight)
            place = slice(first - POSE.start, first - POSE.start + 2)
            out[place] += share * (wanted - out[place])
        return out

    def _query(self, t: int, database: _SearchedDatabase, pose: Array) -> Array:
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
        np.subtract(ahead, database.mean, out=query[TRAJECTORY])
        query[TRAJECTORY] /= database.deviation
        query[POSE] = pose
        return query

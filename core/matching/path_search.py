"""Path search: what plays over a whole recording is chosen at once, by beam search with the root's drift in the state.

A greedy search takes the best frame now and pays for it later. Here the likeliest few dozen histories are kept, each
with the root where its own motion has brought it; at every step each of them plays on or changes to one of the frames
nearest to its query, or to one of those that fit the user's feet best where these are known. It is charged for where
that leaves the root, for facing wrong, for feet that are elsewhere than the user's, and for each change by how far the
poses differ. The cheapest history at the end is played. It sees the recording's future whatever the trajectory.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..database.features import horizon_frames
from ..database.motion_database import POSE, TRAJECTORY, MotionDatabase
from ..jobs import Job
from ..maths import angles
from ..settings import BakeSettings
from .evidence import FeetTable, likely_frames
from .root_motion import last_frames
from .schedule import Frames, Schedule
from .search import feature_weights
from .trajectory import FeetEvidence, Trajectory

Array = NDArray[np.floating[Any]]

BEAMS = 32
"""Histories kept."""
OPTIONS = 8
"""Frames that each history may change to at a step, no two of them of the same block."""
POSITION_M, YAW_RAD = 0.10, 0.20
"""Distance and turn from the target that cost 1 at a step."""
CHANGE_COST = 1.0
"""What a change costs however alike the poses are: 1.7 instead of 2.1 of them a second for 0.2 degrees of yaw."""
FEET_CHANGE_COST = 2.0
"""The same where the feet are known: their evidence pays for more changes than motion needs."""
JUMP_WEIGHT = 0.35
"""Weight on the squared distance of pose features at a change."""
FUTURE_WEIGHT = 0.05
"""Weight on the squared distance of trajectory features: what lies beyond the step."""
CANDIDATES = 1 << 16
"""Frames that may be changed to: of larger databases every second, third ... is one."""
NEAR_S = 1.0 / 3.0
"""Changes to frames of the same clip this near are no changes worth their cost."""
_BLOCK = 16
_SAME = 4
"""Histories that play frames this near to each other are one."""


@dataclass(slots=True)
class _Beam:
    """The histories at one time."""

    roots: Array
    """`(B, 3)` x, y, yaw of the virtual root."""
    frames: Frames
    """`(B,)` frame that would play on; -1 before the first."""
    costs: Array
    """`(B,)`."""


@dataclass(frozen=True, slots=True, eq=False)
class _Options:
    """What the histories may do next."""

    parents: Frames
    frames: Frames
    changes: NDArray[np.bool_]


def find_path(
    trajectory: Trajectory, wanted: Frames, databases: Sequence[MotionDatabase], settings: BakeSettings
) -> Job[Schedule]:
    """The cheapest schedule that the beam search finds.

    Args:
        trajectory: targets and futures of `T` frames at the databases' rate.
        wanted: `(T,)` index of the database that plays.
        databases: all of one skeleton and rate.
        settings: search interval, weights, alpha.
    """
    indexed = {int(i): _IndexedDatabase(databases[int(i)], settings) for i in np.unique(wanted)}
    every = min(round(settings.search_every * trajectory.fps), int(horizon_frames(trajectory.fps)[-1]))
    end = len(trajectory) - 1
    grid = set(range(0, max(end, 1), max(every, 1)))
    times = sorted(grid | set((np.flatnonzero(np.diff(wanted)) + 1).tolist()))
    goals = np.column_stack([trajectory.targets, trajectory.yaws])
    beam = _Beam(goals[:1].copy(), np.array([-1]), np.zeros(1))
    kept: list[_Options] = []
    before = indexed[int(wanted[0])]
    if trajectory.feet is not None:
        for index in indexed.values():
            index.learn_feet(trajectory.feet, trajectory, np.array(times, dtype=np.intp))
    for k, t in enumerate(times):
        index, stop = indexed[int(wanted[t])], times[k + 1] if k + 1 < len(times) else max(end, t)
        poses = before.raw_poses(beam.frames) if k else None
        likely = None if index.likely is None else index.likely[k]
        options = index.options(
            beam, trajectory, t, stop - t, poses, likely, may_stay=k > 0 and index is before
        )
        costs, roots = _charge(index, beam, options, goals, (t, stop), poses, settings.alpha, trajectory.feet)
        costs += FUTURE_WEIGHT * index.misfit(beam, options, trajectory, t)
        best = _prune(costs, options.frames)
        kept.append(_Options(options.parents[best], options.frames[best], options.changes[best]))
        beam = _Beam(roots[best], options.frames[best] + stop - t, costs[best])
        before = index
        yield t / max(end, 1), "Matching"
    return _trace(kept, int(np.argmin(beam.costs)), np.array(times, dtype=np.intp))


def _charge(
    index: _IndexedDatabase,
    beam: _Beam,
    options: _Options,
    goals: Array,
    span: tuple[int, int],
    poses: Array | None,
    alpha: float,
    feet: FeetEvidence | None,
) -> tuple[Array, Array]:
    """Costs `(N,)` of the histories with each option taken, and their roots `(N, 3)` at the end of the span."""
    start, stop = span
    costs = beam.costs[options.parents].copy()
    roots = beam.roots[options.parents]
    for t in ((start + stop) // 2, stop):
        roots = index.carry(beam.roots[options.parents], options.frames, t - start)
        away = roots - goals[t]
        squared = np.sum(away[:, :2] ** 2, axis=-1) / POSITION_M**2 + (angles.wrap(away[:, 2]) / YAW_RAD) ** 2
        costs += 0.5 * squared
        if feet is not None:
            costs += 0.5 * index.feet_costs(feet, t, options.frames + t - start, roots[:, 2])
    if poses is not None:
        jumps = index.jumps(poses[options.parents], options.frames)
        fixed = CHANGE_COST if feet is None else FEET_CHANGE_COST
        costs += np.where(options.changes, fixed + JUMP_WEIGHT * jumps, 0.0)
    away = roots[:, :2] - goals[stop, :2]
    distance = np.linalg.norm(away, axis=-1, keepdims=True)
    held = goals[stop, :2] + away * np.minimum(1.0, alpha / np.maximum(distance, 1e-9))
    return costs, np.column_stack([held, roots[:, 2]])


def _prune(costs: Array, frames: Frames) -> Frames:
    """The cheapest options, one of each stretch of neighbouring frames; ties to the first."""
    order = np.argsort(costs, kind="stable")
    _, firsts = np.unique(frames[order] // _SAME, return_index=True)
    return order[np.sort(firsts)[:BEAMS]]


def _trace(kept: Sequence[_Options], last: int, times: Frames) -> Schedule:
    """The history that ends in the option `last` of the last step."""
    frames, changes = np.empty(len(kept), dtype=np.intp), np.zeros(len(kept), dtype=np.bool_)
    for k in range(len(kept) - 1, -1, -1):
        frames[k], changes[k] = kept[k].frames[last], kept[k].changes[last] and k > 0
        last = int(kept[k].parents[last])
    return Schedule(times, frames, changes)


class _IndexedDatabase:
    """One database made ready for many queries at once."""

    def __init__(self, database: MotionDatabase, settings: BakeSettings) -> None:
        features, poses = database.features, database.poses
        self._database = database
        self._feet: FeetTable | None = None
        self.likely: Frames | None = None
        """`(K, M)` frames that fit the user's feet at each time of a search; None where these are not known."""
        self._mean, self._deviation = features.mean, features.deviation
        self._scale = np.sqrt(feature_weights(settings))
        self._values = np.asarray(features.values * self._scale, dtype=np.float32)
        self._near = round(NEAR_S * database.fps)
        self._positions, self._yaws = np.asarray(poses.root_positions), np.asarray(poses.root_yaws)
        self._last = last_frames(database)
        found = np.flatnonzero(features.trajectory_valid)
        # every so many of them: neighbours in time are nearly the same, and what is played between may start anywhere
        found = found[:: -(-len(found) // CANDIDATES)]
        # whole blocks: the last is filled up with its own last frame
        self._rows = np.pad(found, (0, -len(found) % _BLOCK), mode="edge").reshape(-1, _BLOCK)
        self._found = np.ascontiguousarray(self._values[self._rows].swapaxes(0, 1))
        self._squares = np.einsum("ijk,ijk->ij", self._found, self._found)

    def learn_feet(self, evidence: FeetEvidence, trajectory: Trajectory, times: Frames) -> None:
        """Make ready for evidence of the feet at `times` `(K,)`."""
        self._feet = FeetTable(self._database)
        found = self._rows.ravel()
        self.likely = likely_frames(self._database, self._feet, found, evidence, trajectory, times)

    def feet_costs(self, evidence: FeetEvidence, t: int, frames: Frames, yaws: Array) -> Array:
        """What `frames` `(N,)` at `t`, with roots at `yaws` `(N,)`, cost by evidence that was learned."""
        assert self._feet is not None
        return self._feet.costs(evidence, t, frames, yaws)

    def raw_poses(self, frames: Frames) -> Array:
        """Pose features `(B, 15)` of frames, in metres and m/s: what another database can be asked with."""
        scaled = self._values[frames, POSE] / np.where(self._scale[POSE] > 0.0, self._scale[POSE], 1.0)
        return scaled * self._deviation[POSE] + self._mean[POSE]

    def options(
        self,
        beam: _Beam,
        trajectory: Trajectory,
        t: int,
        length: int,
        poses: Array | None,
        likely: Frames | None,
        *,
        may_stay: bool,
    ) -> _Options:
        """For each history the frames nearest to its query, the `likely` ones `(M,)`, and playing on where its clip is
        long enough."""
        queries = np.zeros((len(beam.roots), self._values.shape[1]), dtype=np.float32)
        queries[:, TRAJECTORY] = self._wanted(beam, trajectory, t)
        if poses is not None:
            queries[:, POSE] = self._normalized(poses)
        found = self._nearest(queries, pose=poses is not None)
        if likely is not None:
            found = np.concatenate([found, np.broadcast_to(likely, (len(found), len(likely)))], axis=-1)
        parents = np.repeat(np.arange(len(found)), found.shape[1])
        frames = found.ravel()
        changes = np.ones(len(frames), dtype=np.bool_)
        if may_stay:
            going = np.flatnonzero(self._last[beam.frames] - beam.frames >= length)
            here = beam.frames[parents]
            far = (np.abs(frames - here) > self._near) | (self._last[frames] != self._last[here])
            # a history at its clip's end has to change, be it to a near frame
            far |= ~np.isin(parents, going)
            parents = np.concatenate([parents[far], going])
            frames = np.concatenate([frames[far], beam.frames[going]])
            changes = np.concatenate([changes[far], np.zeros(len(going), dtype=np.bool_)])
        return _Options(parents, frames, changes)

    def carry(self, roots: Array, frames: Frames, length: int) -> Array:
        """Roots `(N, 3)` after `length` frames are played from `frames`."""
        ends = frames + length
        way = angles.turn(self._positions[ends] - self._positions[frames], roots[:, 2] - self._yaws[frames])
        return np.column_stack([roots[:, :2] + way, roots[:, 2] + self._yaws[ends] - self._yaws[frames]])

    def jumps(self, poses: Array, frames: Frames) -> Array:
        """Squared distance `(N,)` of pose features between raw `poses` `(N, 15)` and frames."""
        return np.sum((self._values[frames, POSE] - self._normalized(poses)) ** 2, axis=-1)

    def misfit(self, beam: _Beam, options: _Options, trajectory: Trajectory, t: int) -> Array:
        """Squared distance `(N,)` of the options' trajectory features from what their histories want."""
        wanted = self._wanted(beam, trajectory, t)[options.parents]
        return np.sum((self._values[options.frames, TRAJECTORY] - wanted) ** 2, axis=-1)

    def _normalized(self, poses: Array) -> Array:
        return (poses - self._mean[POSE]) / self._deviation[POSE] * self._scale[POSE]

    def _wanted(self, beam: _Beam, trajectory: Trajectory, t: int) -> Array:
        """Trajectory part `(B, 12)` of the queries, seen from each history's root."""
        x_y, yaws = beam.roots[:, None, :2], beam.roots[:, 2:]
        ahead = angles.turn(trajectory.future_positions[t] - x_y, -yaws)
        facing = angles.direction(trajectory.future_yaws[t] - yaws)
        raw = np.concatenate([ahead.reshape(len(yaws), -1), facing.reshape(len(yaws), -1)], axis=-1)
        return (raw - self._mean[TRAJECTORY]) / self._deviation[TRAJECTORY] * self._scale[TRAJECTORY]

    def _nearest(self, queries: NDArray[np.float32], *, pose: bool) -> Frames:
        """For each query `(B, 27)` the nearest frame of each of the `OPTIONS` nearest blocks `(B, M)`."""
        columns = slice(None) if pose else TRAJECTORY
        asked = queries[:, columns]
        minima = np.full((len(asked), self._found.shape[1]), np.inf, dtype=np.float32)
        # one frame of every block at a time: their least is then taken over whole rows
        for found, squares in zip(self._found[..., columns], self._squares, strict=True):
            scores = (-2.0 * asked) @ found.T
            scores += squares if pose else np.einsum("ij,ij->i", found, found)
            np.minimum(minima, scores, out=minima)
        count = min(OPTIONS, minima.shape[1])
        blocks = np.argpartition(minima, count - 1, axis=-1)[:, :count]
        rows = self._rows[blocks]
        away = self._values[rows, columns] - asked[:, None, None]
        best = np.argmin(np.sum(away * away, axis=-1), axis=-1)
        return np.take_along_axis(rows, best[..., None], axis=-1)[..., 0]

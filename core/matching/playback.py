"""Motion matching over a whole recording: which frame of which database plays when, and where its root is.

A search says what plays from when on (paper, sections 5.3 to 5.5). Between two searches the frames of a clip follow
each other, carry the root along, and let it be drawn to its target.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..database.motion_database import MotionDatabase
from ..database.soles import sole_pitches_at
from ..errors import InputError
from ..jobs import Job
from ..maths import filters
from ..methods import SEARCHES
from ..settings import BakeSettings
from .root_motion import RootMotion, goals_of
from .schedule import Frames, Schedule
from .selection import check_databases, choose_databases
from .trajectory import Trajectory

Array = NDArray[np.floating[Any]]


_SOLES_S = 0.15
"""Standard deviation in seconds of the smoothing of feet from one clip's to the next one's."""

SearchMethod = Callable[[Trajectory, Frames, Sequence[MotionDatabase], BakeSettings], Job[Schedule]]
"""A search: targets and futures of `T` frames, the database that plays `(T,)`, all databases, and every control."""


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
    search: SearchMethod = SEARCHES.function(settings.search)
    schedule = yield from search(trajectory, wanted, databases, settings)
    return play(schedule, trajectory, wanted, databases, settings)


def play(
    schedule: Schedule,
    trajectory: Trajectory,
    wanted: Frames,
    databases: Sequence[MotionDatabase],
    settings: BakeSettings,
) -> Playback:
    """What a schedule gives: the frames that follow each other, and the root carried along, adjusted and held at alpha.

    Args:
        schedule: from a search.
        trajectory: the targets.
        wanted: `(T,)` index of the database that plays.
        databases: as for the search.
        settings: alpha and adjustment.
    """
    motions = {int(i): RootMotion(databases[int(i)], settings) for i in np.unique(wanted)}
    goals, end = goals_of(trajectory), len(trajectory) - 1
    stops = [*schedule.times[1:].tolist(), end]
    path, held = [goals[0]], [False]
    database, frame = np.empty(end + 1, dtype=np.intp), np.empty(end + 1, dtype=np.intp)
    for t, stop, first in zip(schedule.times.tolist(), stops, schedule.frames.tolist(), strict=True):
        roots, clamped = motions[int(wanted[t])].advance(path[-1], first, goals[t + 1 : stop + 1])
        path += roots
        held += clamped
        database[t : stop + 1] = wanted[t]
        frame[t : stop + 1] = np.arange(first, first + stop - t + 1)
    roots_over_time = np.array(path)
    return Playback(
        database=database,
        frame=frame,
        root_positions=roots_over_time[:, :2],
        root_yaws=roots_over_time[:, 2],
        transitions=schedule.times[schedule.changes],
        clamped=np.array(held),
        target_positions=trajectory.targets,
        target_yaws=trajectory.yaws,
        searches=len(schedule.times),
    )


def soles_of(playback: Playback, databases: Sequence[MotionDatabase]) -> Array:
    """Pitch `(T, 2)` in radians at which the left and the right foot of what plays stand flat."""
    pitches = np.zeros((len(playback), 2))
    for i in np.unique(playback.database):
        rows = playback.database == i
        pitches[rows] = sole_pitches_at(databases[int(i)], playback.frame[rows])
    return filters.gaussian(pitches, _SOLES_S * databases[0].fps)

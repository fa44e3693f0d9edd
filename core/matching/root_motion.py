"""The virtual root while frames of a database play: its own steps, the adjustment to its target, and alpha.

A recurrence over frames, kept to plain numbers (paper, section 5.5).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..database.motion_database import MotionDatabase
from ..settings import BakeSettings
from .trajectory import Trajectory

Root = tuple[float, float, float]
"""x, y in metres and yaw in radians of the virtual root in the world."""
Step = tuple[float, float, float, float, float]

ADJUSTMENT_HALFLIFE_S = 0.1
"""The root would reach half way to its target in this time, were it not for the limit by speed."""


def last_frames(database: MotionDatabase) -> NDArray[np.intp]:
    """For each frame `(N,)` the last one of its clip."""
    last = np.empty(len(database), dtype=np.intp)
    for clip in database.clips:
        last[clip.start : clip.stop] = clip.stop - 1
    return last


def goals_of(trajectory: Trajectory) -> list[Root]:
    """The root's targets as plain numbers."""
    columns: tuple[Any, ...] = (*trajectory.targets.T, trajectory.yaws)
    return list(zip(*(column.tolist() for column in columns), strict=True))


class RootMotion:
    """One database's root motion as plain numbers."""

    def __init__(self, database: MotionDatabase, settings: BakeSettings) -> None:
        poses, dt = database.poses, 1.0 / database.fps
        caps = settings.adjustment * np.linalg.norm(poses.root_velocities, axis=-1)
        turn_caps = settings.adjustment * np.abs(poses.root_yaw_velocities)
        steps = np.column_stack([poses.root_velocities, poses.root_yaw_velocities, caps, turn_caps]) * dt
        self._steps: list[Step] = list(zip(*(column.tolist() for column in steps.T), strict=True))
        """A frame's own x, y, yaw and the most that place and yaw may be adjusted, for the step to the next frame."""
        self._alpha = settings.alpha
        self._share = 1.0 - 2.0 ** (-1.0 / (database.fps * ADJUSTMENT_HALFLIFE_S))

    def advance(self, root: Root, frame: int, goals: Sequence[Root]) -> tuple[list[Root], list[bool]]:
        """Where the root goes while `frame` and what follows plays, and whether it was held at alpha.

        Args:
            root: where it is at `frame`.
            frame: of the database.
            goals: its targets in the frames after that.
        """
        x, y, yaw = root
        path: list[Root] = []
        held: list[bool] = []
        alpha, share = self._alpha, self._share
        steps = self._steps[frame : frame + len(goals)]
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
        return path, held

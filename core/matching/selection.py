"""Which database is meant for the height of the headset (paper, section 5.5), and whether databases go
together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..database.motion_database import FEATURE_COUNT, MotionDatabase
from ..errors import InputError

Array = NDArray[np.floating[Any]]

SAME_SKELETON_M = 0.001
"""Joint offsets that differ by less than this, in metres, are the same."""


def choose_databases(
    height_ratios: Array, ranges: Sequence[tuple[float, float]], margin: float
) -> NDArray[np.intp]:
    """The database `(T,)` for each frame.

    A frame belongs to the first range that holds its ratio, or, in a gap, to the nearest one (the first of
    equals). The choice of the frame before stays until the ratio has left its range for a better one by
    `margin`.

    Args:
        height_ratios: `(T,)` height of the headset over its calibrated height.
        ranges: [low, high) of each database.
        margin: hysteresis, as a ratio.
    """
    low, high = np.array(ranges, dtype=np.float64).T[:, :, None]
    holds = (height_ratios >= low) & (height_ratios < high)
    away = np.maximum(np.maximum(low - height_ratios, height_ratios - high), 0.0)
    gap = ~holds.any(axis=0)
    best: NDArray[np.intp] = np.argmax(holds, axis=0)
    best[gap] = np.argmin(away[:, gap], axis=0)
    stays = holds | (away < np.min(away, axis=0) + margin)
    chosen = best.copy()
    changes = np.flatnonzero(np.diff(best)) + 1
    if len(changes) == 0:
        return chosen
    keeps, wanted = stays.tolist(), best.tolist()
    now = wanted[changes[0] - 1]
    for t in range(int(changes[0]), len(wanted)):
        if not keeps[now][t]:
            now = wanted[t]
        chosen[t] = now
    return chosen


def check_databases(databases: Sequence[MotionDatabase]) -> None:
    """Whether these can be played one after the other.

    Raises:
        InputError: none is given, or one cannot be searched, or differs from the first in rate, joints or
        body size.
    """
    if not databases:
        raise InputError("database: none is given; build or load at least one")
    first = databases[0]
    for database in databases:
        where = f"database {database.name!r}"
        if database.features.values.shape != (len(database), FEATURE_COUNT):
            raise InputError(f"{where}: features do not fit its {len(database)} poses; build it again")
        if not database.features.trajectory_valid.any():
            raise InputError(f"{where}: no clip is longer than one second; build it from longer takes")
        if database.fps != first.fps:
            raise InputError(
                f"{where}: {database.fps:g} frames per second, but {first.name!r} has {first.fps:g}; "
                "build them at one rate"
            )
        same = database.skeleton.roles == first.skeleton.roles and np.array_equal(
            database.skeleton.parents, first.skeleton.parents
        )
        if not same:
            raise InputError(
                f"{where}: other joints than {first.name!r}; "
                "build it on the skeleton of that one (Skeleton Of, --skeleton)"
            )
        gap = float(np.max(np.linalg.norm(database.skeleton.offsets - first.skeleton.offsets, axis=-1)))
        if gap > SAME_SKELETON_M:
            raise InputError(
                f"{where}: its body differs from {first.name!r} by {100.0 * gap:.1f} cm; "
                "build it on the skeleton of that one (Skeleton Of, --skeleton)"
            )

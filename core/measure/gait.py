"""Whether legs step as the user's do, as functions of arrays in metres, seconds and radians."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from ..maths import angles

Array = NDArray[np.floating[Any]]
Flags = NDArray[np.bool_]

PHASE_WINDOW_S = 0.8
"""About a step and a half of a walk: longer than one swing, too short for two people to fall out of step in it."""
PHASE_HOP_S = 0.1
PHASE_SPEED_M_S = 0.3
"""A root slower than this (of a body with legs of `subject.LEG_M`) does not walk."""
PHASE_AGREES = 0.5


def ahead(ankles: Array, yaws: Array) -> Array:
    """How far `(T,)` the left ankle is before the right one, along the heading.

    Args:
        ankles: `(T, 2, 3)` left, right, metres.
        yaws: `(T,)` radians, the heading.
    """
    return np.sum((ankles[:, 0, :2] - ankles[:, 1, :2]) * angles.direction(yaws), axis=-1)


def phase_correlations(
    ankles: Array, true_ankles: Array, true_roots: Array, true_yaws: Array, fps: float, size: float = 1.0
) -> Array:
    """How well the swing of the legs fits the user's: a correlation in [-1, 1] for each window of 0.8 s.

    What is correlated is how far the left ankle is before the right one, of both bodies along the *true* heading. Legs
    that do not swing at all agree with nothing: 0.

    Args:
        ankles: `(T, 2, 3)` left, right, of the body that is judged, metres.
        true_ankles: `(T, 2, 3)` of the user.
        true_roots: `(T, 2)` the true root on the ground, metres.
        true_yaws: `(T,)` its heading, radians.
        fps: frames per second.
        size: of the user as a share of a usual body; speeds scale with it.

    Returns:
        `(W,)` for windows that start every 0.1 s; NaN where the true root moves at 0.3 m/s or less on average.
    """
    frames, hop = max(round(PHASE_WINDOW_S * fps), 2), max(round(PHASE_HOP_S * fps), 1)
    if len(ankles) < frames:
        return np.empty(0)

    def windows(values: Array) -> Array:
        return sliding_window_view(values, frames)[::hop]

    speeds = np.linalg.norm(np.diff(true_roots, axis=0, append=true_roots[-1:]), axis=-1) * fps
    moving = windows(speeds)[:, :-1].mean(axis=-1) > PHASE_SPEED_M_S * size
    mine, theirs = windows(ahead(ankles, true_yaws)), windows(ahead(true_ankles, true_yaws))
    mine, theirs = (rows - rows.mean(axis=-1, keepdims=True) for rows in (mine, theirs))
    spread = np.linalg.norm(mine, axis=-1) * np.linalg.norm(theirs, axis=-1)
    found = np.sum(mine * theirs, axis=-1) / np.maximum(spread, 1e-9)
    return np.where(moving, found, np.nan)


def agreeing(correlations: Array) -> Array:
    """1 for each window in step with the user, 0 for others, NaN where the user does not walk."""
    return np.where(np.isnan(correlations), np.nan, correlations > PHASE_AGREES)


def phase_agreement(
    ankles: Array, true_ankles: Array, true_roots: Array, true_yaws: Array, fps: float, size: float = 1.0
) -> float:
    """Share of the windows in which the user walks whose correlation is above 0.5; NaN where there are none.

    Arguments as for `phase_correlations`. Legs without any relation to the user's reach about a third.
    """
    values = agreeing(phase_correlations(ankles, true_ankles, true_roots, true_yaws, fps, size))
    known = values[~np.isnan(values)]
    return float(known.mean()) if len(known) else float("nan")


PLANT_M = 0.06
"""A toe that was farther than this from where it stood has made a step; less is shuffling, or a heel that turns."""
PLANT_TOLERANCE_S = 0.25
"""Two plants of the same foot no farther apart than this are the same step."""
REST_WINDOW_S = 1.0
REST_SPEED_M_S = 0.15
"""A head that gets on by less than this over a second rests; it may nod, lean back and forth, and box."""


def plants(toes: Array, standing: Flags, least: float = PLANT_M) -> Flags:
    """Frames `(T, 2)` at which a foot stands again after it was away from where it stood before.

    Args:
        toes: `(T, 2, 3)` metres.
        standing: `(T, 2)`.
        least: metres that the toe was away at some time in between, height included.
    """
    out = np.zeros(standing.shape, dtype=np.bool_)
    for foot in range(2):
        edges = np.diff(np.concatenate([[False], standing[:, foot], [False]]).astype(np.int8))
        starts, stops = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
        for left, landed in zip(stops[:-1].tolist(), starts[1:].tolist(), strict=True):
            way = toes[left : landed + 1, foot] - toes[left - 1, foot]
            out[landed, foot] = np.linalg.norm(way, axis=-1).max() > least
    return out


def unmatched(events: Flags, others: Flags, tolerance: int) -> Flags:
    """The `events` `(T, N)` that have no partner among the `others` of their column within `tolerance` frames.

    Every one of the others is the partner of one event at most; as many as can be are matched.
    """
    out = events.copy()
    for column in range(events.shape[1]):
        mine, theirs = np.flatnonzero(events[:, column]), np.flatnonzero(others[:, column])
        i = j = 0
        while i < len(mine) and j < len(theirs):
            if abs(int(mine[i]) - int(theirs[j])) <= tolerance:
                out[mine[i], column] = False
                i, j = i + 1, j + 1
            elif mine[i] < theirs[j]:
                i += 1
            else:
                j += 1
    return out


def resting(heads: Array, fps: float, size: float = 1.0) -> Flags:
    """Frames `(T,)` in which the head gets on by less than 0.15 m/s over the second around.

    Args:
        heads: `(T, 2)` on the ground, metres.
        fps: frames per second.
        size: of the body as a share of a usual one.
    """
    half = max(round(0.5 * REST_WINDOW_S * fps), 1)
    frames = np.arange(len(heads))
    first, last = np.maximum(frames - half, 0), np.minimum(frames + half, len(heads) - 1)
    way = np.linalg.norm(heads[last] - heads[first], axis=-1)
    return way * fps < REST_SPEED_M_S * size * np.maximum(last - first, 1)

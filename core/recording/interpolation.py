"""Poses between samples: lines for positions, great arcs for rotations."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..maths import quat
from .recording import Array


def neighbours(times: Array, at: Array) -> tuple[NDArray[np.intp], Array]:
    """The sample before each time of `at` `(N,)`, and how far to the next it lies, in [0, 1].

    Args:
        times: `(T,)` increasing seconds, T >= 2. Times outside are held at the first or last sample.
        at: `(N,)` seconds.
    """
    before = np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 2)
    share = (at - times[before]) / (times[before + 1] - times[before])
    return before, np.clip(share, 0.0, 1.0)


def blend_positions(positions: Array, before: NDArray[np.intp], share: Array) -> Array:
    """Positions `(N, ..., 3)` at the places that `neighbours` found in `(T, ..., 3)`."""
    start = positions[before]
    return start + (positions[before + 1] - start) * share.reshape(-1, *[1] * (positions.ndim - 1))


def blend_rotations(rotations: Array, before: NDArray[np.intp], share: Array) -> Array:
    """Rotations `(N, ..., 4)` at the places that `neighbours` found in `(T, ..., 4)`."""
    start = rotations[before]
    weight = np.broadcast_to(share.reshape(-1, *[1] * (rotations.ndim - 2)), start.shape[:-1])
    return quat.slerp(start, rotations[before + 1], weight)

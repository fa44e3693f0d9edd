"""What a lost tracker leaves: weights that fade into the gap, and values carried through it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..maths import quat
from ..maths.easing import smoothstep

Array = NDArray[np.floating[Any]]

BLEND_S = 0.2
"""Seconds after a tracker is lost, and before it is back, over which it loses and gains its say."""


def weights(valid: NDArray[np.bool_], fps: float, seconds: float = BLEND_S) -> Array:
    """1 where tracked, falling smoothly to 0 within some seconds into each gap: `(T,)` of flags `(T,)`."""
    if not valid.any():
        return np.zeros(len(valid))
    known = np.flatnonzero(valid)
    frames = np.arange(len(valid))
    after = np.searchsorted(known, frames)
    right = np.abs(known[np.minimum(after, len(known) - 1)] - frames)
    left = np.abs(frames - known[np.maximum(after - 1, 0)])
    t = np.clip(1.0 - np.minimum(left, right) / (seconds * fps + 1.0), 0.0, 1.0)
    return smoothstep(t)


def carry(values: Array, valid: NDArray[np.bool_]) -> Array:
    """`values` `(T, D)` with straight lines through the gaps, held past the first and last valid frame."""
    if valid.all() or not valid.any():
        return values
    known, frames = np.flatnonzero(valid), np.arange(len(values))
    out = np.empty(values.shape)
    for i in range(values.shape[1]):
        out[:, i] = np.interp(frames, known, values[known, i])
    return out


def carry_rotations(rotations: Array, valid: NDArray[np.bool_]) -> Array:
    """Unit quaternions `(T, 4)` likewise."""
    if valid.all() or not valid.any():
        return rotations
    out = rotations.copy()
    out[valid] = quat.continuous(rotations[valid])
    return quat.normalize(carry(out, valid))

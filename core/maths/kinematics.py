"""Time derivatives of positions and rotations, vectorised over frames."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import quat

Array = NDArray[np.floating[Any]]


def velocity(values: Array, fps: float) -> Array:
    """Central differences of `values` `(T, ...)` per second; one-sided at both ends; zeros for one frame."""
    if len(values) < 2:
        return np.zeros_like(values)
    return np.gradient(values, axis=0) * fps


def angular_velocity(rotations: Array, fps: float) -> Array:
    """World angular velocity `(T, ..., 3)` in rad/s of rotations `(T, ..., 4)` by central differences."""
    if len(rotations) < 2:
        return np.zeros((*rotations.shape[:-1], 3))
    step = quat.to_rotation_vector(quat.multiply(rotations[1:], quat.conjugate(rotations[:-1]))) * fps
    return np.concatenate([step[:1], 0.5 * (step[1:] + step[:-1]), step[-1:]], axis=0)

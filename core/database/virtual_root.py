"""The virtual root: the character's place and heading on the ground (paper, section 5.1)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body.motion import Motion
from ..maths import angles, filters, quat

Array = NDArray[np.floating[Any]]


def virtual_root(motion: Motion, smoothing_s: float = 0.0) -> tuple[Array, Array]:
    """The hips projected on the ground, and the heading of their projected forward axis.

    Where forward is nearly vertical the hips' up axis tells the heading (`quat.heading`).

    Args:
        motion: `T` frames on any skeleton.
        smoothing_s: window in seconds of a cubic Savitzky-Golay filter over positions and directions; 0 for
            none, as in the paper.

    Returns:
        Positions `(T, 2)` in metres and yaws `(T,)` in radians without jumps of a full turn.
    """
    positions = np.array(motion.positions[:, :2], dtype=np.float64)
    yaws = np.unwrap(quat.heading(motion.rotations[:, 0]))
    window = filters.odd_window(smoothing_s, motion.fps)
    if window > 1:
        positions = filters.savitzky_golay(positions, window)
        smooth = angles.yaw_of(filters.savitzky_golay(angles.direction(yaws), window))
        # the full turns made so far are in the yaws, not in the directions
        yaws = yaws + angles.wrap(smooth - yaws)
    return positions, yaws


def to_root_space(vectors: Array, root_yaws: Array) -> Array:
    """World vectors `(T, ..., 2 or 3)` in the axes of roots with yaws `(T,)`: X right, Y forward, Z up."""
    yaws = root_yaws.reshape(-1, *[1] * (vectors.ndim - 2))
    return np.concatenate([angles.turn(vectors[..., :2], -yaws), vectors[..., 2:]], axis=-1)

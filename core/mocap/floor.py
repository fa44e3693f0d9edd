"""The floor of a take: the height that its feet stand at."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body.motion import Motion
from ..body.pose import role_poses
from ..body.skeleton import SIDES, Skeleton
from ..maths import kinematics, quat

Array = NDArray[np.floating[Any]]

_SLOW = 0.25
"""m/s: a foot slower than this stands."""
_LAYER = 0.04
"""Metres: standing heights within this of the lowest ones are the floor, others are steps and boxes."""
SOLE = 0.01
"""Metres that the lowest joint of a standing foot is above a floor that had to be moved."""
_BELOW, _ABOVE = -0.025, 0.05
"""Metres: joints of a standing foot are not under the floor, nor farther above it than a sole is thick."""


def floor_height(motion: Motion) -> float:
    """Height in metres of the lowest level that the feet stand at."""
    skeleton = motion.skeleton
    ends = [f"{'toe' if f'toe.{side}' in skeleton.roles else 'foot'}.{side}" for side in SIDES]
    positions, rotations = role_poses(motion, [*(f"foot.{side}" for side in SIDES), *ends])
    tips = skeleton.tips[[skeleton.joint(end) for end in ends]]
    bottoms = _bottoms(positions, rotations, tips)
    speed = np.linalg.norm(kinematics.velocity(positions[:, 2:], motion.fps), axis=-1)
    # a take in which no foot ever rests still has its slowest moments near the floor
    standing = bottoms[speed <= max(_SLOW, float(np.quantile(speed, 0.05)))]
    low = np.quantile(standing, 0.05)
    return float(np.median(standing[standing < low + _LAYER]))


def standing_height(skeleton: Skeleton) -> float:
    """Height in metres of the lowest known point of the feet in T-pose."""
    still = Motion(skeleton, 1.0, skeleton.offsets[:1], np.tile(quat.IDENTITY, (1, len(skeleton), 1)))
    return floor_height(still)


def is_floor(height: float) -> bool:
    """Whether feet that stand this high, metres, stand on Z = 0 with their soles."""
    return _BELOW <= height <= _ABOVE


def _bottoms(positions: Array, rotations: Array, tips: Array) -> Array:
    """Height `(T, 2)` of each foot's lowest point of ankle, toe and its tip.

    Args:
        positions: `(T, 4, 3)` left and right ankle, left and right toe.
        rotations: `(T, 4, 4)` of the same, since T-pose.
        tips: `(2, 3)` from left and right toe to its tip, in T-pose.
    """
    ends = positions[:, 2:] + quat.rotate(rotations[:, 2:], tips)
    return np.minimum(positions[..., 2].reshape(-1, 2, 2).min(axis=1), ends[..., 2])

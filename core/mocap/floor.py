"""The floor of a take: the height that its feet stand at."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..maths import kinematics, quat
from .skeleton import SIDES, Motion, Skeleton

Array = NDArray[np.floating[Any]]

_SLOW = 0.25
"""m/s: a foot slower than this stands."""
_LAYER = 0.04
"""Metres: standing heights within this of the lowest ones are the floor, others are steps and boxes."""
_BELOW, _ABOVE = -0.025, 0.05
"""Metres: joints of a standing foot are not under the floor, nor farther above it than a sole is thick."""


def foot_bottoms(skeleton: Skeleton, positions: Array, rotations: Array) -> Array:
    """Height `(T, 2)` in metres of the lowest known point of the left and right foot: ankle, toe or its tip.

    Args:
        skeleton: whose feet.
        positions: `(T, J, 3)` joints in the world.
        rotations: `(T, J, 4)` global rotations since T-pose.
    """
    sides: list[Array] = []
    for side in SIDES:
        joints = [j for j in (skeleton.find(f"foot.{side}"), skeleton.find(f"toe.{side}")) if j >= 0]
        last = joints[-1]
        tip = positions[:, last] + quat.rotate(rotations[:, last], skeleton.tips[last])
        sides.append(np.minimum(positions[:, joints, 2].min(axis=1), tip[:, 2]))
    return np.stack(sides, axis=-1)


def floor_height(motion: Motion) -> float:
    """Height in metres of the lowest level that the feet stand at."""
    positions, rotations = motion.forward()
    bottoms = foot_bottoms(motion.skeleton, positions, rotations)
    ends = [motion.skeleton.find(f"toe.{side}") for side in SIDES]
    ends = [motion.skeleton.joint(f"foot.{s}") if j < 0 else j for s, j in zip(SIDES, ends, strict=True)]
    speed = np.linalg.norm(kinematics.velocity(positions[:, ends], motion.fps), axis=-1)
    # a take in which no foot ever rests still has its slowest moments near the floor
    standing = bottoms[speed <= max(_SLOW, float(np.quantile(speed, 0.05)))]
    low = np.quantile(standing, 0.05)
    return float(np.median(standing[standing < low + _LAYER]))


def is_floor(height: float) -> bool:
    """Whether feet that stand this high, metres, stand on Z = 0 with their soles."""
    return _BELOW <= height <= _ABOVE

"""What stands for the toes of a body, and where they are."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..maths import quat
from .motion import Motion
from .skeleton import SIDES, Skeleton

Array = NDArray[np.floating[Any]]

_TOE_OF_LEG = np.array([0.0, 0.21, -0.095])
"""From ankle to toe joint as shares of the leg's length: mean of ten people's T-poses."""


def toe_places(skeleton: Skeleton) -> tuple[NDArray[np.intp], Array]:
    """What stands for the left and the right toe on this skeleton.

    The toe joint; without one the tip of the foot, or, where that is unknown too, the place where a toe joint
    usually is.

    Returns:
        Joints `(2,)` and offsets from them `(2, 3)` in T-pose axes, metres.
    """
    joints = np.empty(2, dtype=np.intp)
    offsets = np.zeros((2, 3))
    for i, side in enumerate(SIDES):
        joints[i] = skeleton.find(f"toe.{side}")
        if joints[i] < 0:
            joints[i] = skeleton.joint(f"foot.{side}")
            tip = skeleton.tips[joints[i]]
            offsets[i] = tip if np.linalg.norm(tip) > 0.01 else _TOE_OF_LEG * skeleton.leg_length()
    return joints, offsets


def toe_positions(motion: Motion) -> Array:
    """World positions `(T, 2, 3)` of the left and the right toe, metres (see `toe_places`)."""
    return place_toes(motion.skeleton, *motion.forward())


def place_toes(skeleton: Skeleton, positions: Array, rotations: Array) -> Array:
    """The same from global joint positions `(T, J, 3)` and rotations `(T, J, 4)`."""
    joints, offsets = toe_places(skeleton)
    return positions[:, joints] + quat.rotate(rotations[:, joints], offsets)

"""The two legs of a skeleton: joints and measures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import heel
from .skeleton import SIDES, Skeleton
from .toes import toe_places

Array = NDArray[np.floating[Any]]

_TIP = 0.5
"""Length of a toe whose end is unknown, as a share of the way over the ground from ankle to toe joint."""
_NO_TIP_M = 5e-3
"""A toe whose end is nearer to its joint has an unknown end."""


@dataclass(frozen=True, slots=True, eq=False)
class Leg:
    """Joints and measures of a leg in T-pose, metres and radians."""

    thigh: int
    shin: int
    foot: int
    end: int
    """The toe joint, or the foot where there is none."""
    shift: Array
    """`(3,)` from the end joint to what stands for the toe."""
    bones: Array
    """`(2,)` lengths from thigh joint to knee and from knee to ankle."""
    to_toe: Array
    """`(3,)` from the ankle to the toe."""
    height: float
    """Of the toe over the floor."""
    tip: Array
    """`(3,)` from the toe joint to the end of the toe."""

    @property
    def length(self) -> float:
        """From thigh joint to ankle when straight."""
        return float(self.bones.sum())

    @property
    def to_tip(self) -> Array:
        """`(3,)` from the toe to the end of the foot, as far as joints tell."""
        return self.tip if self.end != self.foot else np.zeros(3)

    @property
    def heel(self) -> Array:
        """`(3,)` from the toe to where the heel is on the floor."""
        return np.array([0.0, -heel.heel_behind(self.to_toe), -self.height])

    @property
    def radius(self) -> float:
        """From the toe to the ankle in the upright plane along the foot."""
        return float(np.hypot(self.to_toe[1], self.to_toe[2]))

    @property
    def flat(self) -> float:
        """Angle over the ground from toe back to ankle while the foot stands."""
        return float(np.arctan2(-self.to_toe[2], self.to_toe[1]))


def legs_of(skeleton: Skeleton) -> list[Leg]:
    """The left and the right leg."""
    standing = skeleton.tpose_positions()
    joints, shifts = toe_places(skeleton)
    out: list[Leg] = []
    for side, name in enumerate(SIDES):
        thigh, shin, foot = (skeleton.joint(f"{part}.{name}") for part in ("thigh", "shin", "foot"))
        end, shift = int(joints[side]), shifts[side]
        toe = standing[end] + shift
        to_toe, tip = toe - standing[foot], skeleton.tips[end]
        if np.linalg.norm(tip) <= _NO_TIP_M:
            tip = np.array([0.0, _TIP * to_toe[1], 0.0])
        bones = np.linalg.norm(np.diff(standing[[thigh, shin, foot]], axis=0), axis=-1)
        out.append(Leg(thigh, shin, foot, end, shift, bones, to_toe, max(float(toe[2]), 0.0), tip))
    return out

"""How high the head is when a body stands at ease, which is what an eye-height calibration measures.

Nobody stands as tall as the T-pose of their skeleton: over five mocap sets the head joint of standing people is at 0.96
to 1.00 of its T-pose height. Scaling by T-pose heights would put avatars on tip-toe.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..maths import kinematics
from . import forward_kinematics as fk
from .motion import Motion

Array = NDArray[np.floating[Any]]

_SLOW_M_S = 0.3
_BAND_M = 0.06
_SHARE = 0.15
_OF_TPOSE = (0.95, 1.0)
_RATE = 10.0


def standing_height(heights: Array, speeds: Array) -> float:
    """The height where something stays for a while and is never higher for as long.

    That is the median of the highest 6 cm that hold 15 % of the slow frames: people stand more than they go on
    tip-toe, and may crouch for most of a recording.

    Args:
        heights: `(T,)` metres.
        speeds: `(T,)` m/s; frames below 0.3 m/s count, or all where few are.
    """
    slow = speeds < _SLOW_M_S
    ordered = np.sort(heights[slow] if slow.sum() >= 0.1 * len(heights) else heights)
    start = np.searchsorted(ordered, ordered - _BAND_M)
    held = np.flatnonzero(np.arange(1, len(ordered) + 1) - start >= _SHARE * len(ordered))
    if len(held) == 0:
        return float(np.percentile(ordered, 95))
    top = held[-1]
    return float(np.median(ordered[start[top] : top + 1]))


def standing_head_height(*motions: Motion) -> float:
    """Height in metres of the head joint of a body at ease, as measured in one or more motions of it.

    Kept within what standing people show relative to T-pose, so that motions in which nobody stands do no harm.
    """
    skeleton = motions[0].skeleton
    head = skeleton.joint("head")
    heights: list[Array] = []
    speeds: list[Array] = []
    for motion in motions:
        step = max(1, round(motion.fps / _RATE))
        places, _ = fk.forward(
            motion.positions[::step], motion.rotations[::step], skeleton.offsets, skeleton.parents
        )
        heights.append(places[:, head, 2])
        speeds.append(np.linalg.norm(kinematics.velocity(places[:, head], motion.fps / step), axis=-1))
    low, high = (share * skeleton.tpose_positions()[head, 2] for share in _OF_TPOSE)
    measured = standing_height(np.concatenate(heights), np.concatenate(speeds))
    return float(np.clip(measured, low, high))

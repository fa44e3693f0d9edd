"""The body under the head: where on the ground the hips are, which the virtual root aims at.

The motion databases' own bodies tell by how much a head is ahead of its hips (`hips_model`). Where the body estimate
knows the hips too, both answers are weighed by how far off they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..database.motion_database import MotionDatabase
from ..maths import angles
from ..recording.body_estimate import BodyEstimate
from .hips_model import hips_from_head, pooled, sums_of

Array = NDArray[np.floating[Any]]

_OWN_M = 0.05
"""Metres in each direction that the databases' lean is off."""
_SUIT_M = 0.04
"""Metres in each direction that an estimate is off beside its spread, for suits and people that it has not seen."""


def body_targets(
    positions: Array,
    rotations: Array,
    valid: NDArray[np.bool_],
    head_height: float,
    fps: float,
    databases: Sequence[MotionDatabase],
) -> Array:
    """Where on the ground the hips are, `(T, 2)` in metres.

    Args:
        positions: `(T, 3, 3)` joints of head, left and right hand in the world, metres, scaled to the databases' body.
        rotations: `(T, 3, 4)` of these joints since T-pose.
        valid: `(T, 3)` whether each was tracked.
        head_height: of the head joint of the databases' body when it stands upright, metres.
        fps: frames per second.
        databases: whose poses show how this body leans; all of one skeleton.
    """
    sums = pooled([sums_of(database) for database in databases])
    return positions[:, 0, :2] + hips_from_head(sums, positions, rotations, valid, head_height, fps)


def with_estimate(targets: Array, heads: Array, estimate: BodyEstimate, head_height: float) -> Array:
    """Targets `(T, 2)` drawn to where an estimate has the hips; the same where it knows none.

    Args:
        targets: `(T, 2)` from `body_targets`, metres.
        heads: `(T, 2)` head joint over the ground, metres.
        estimate: of the same frames.
        head_height: of the head joint of the databases' body when it stands upright, metres.
    """
    if estimate.hips is None:
        return targets
    hips = heads + angles.turn(estimate.hips.mean[:, :2] * head_height, estimate.yaws)
    off = _SUIT_M**2 + (estimate.hips.spread * head_height) ** 2
    share = _OWN_M**2 / (_OWN_M**2 + off)
    return targets + share[:, None] * (hips - targets)

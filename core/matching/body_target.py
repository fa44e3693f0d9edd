"""The body under the head: the hips over the ground, which the virtual root aims at, and the chest's turn.

The motion databases' own bodies tell how a body holds itself under such a head (`posture_model`). Where the body
estimate knows that too, both answers are weighed by how far off they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..database.motion_database import MotionDatabase
from ..maths import angles, quat
from ..maths.vectors import unit
from ..recording.body_estimate import BodyEstimate
from .posture_model import Posture, pooled, posture_of, sums_of

Array = NDArray[np.floating[Any]]

_OWN_M = 0.05
"""Metres in each direction that the databases' lean is off."""
_SUIT_M = 0.04
"""Metres in each direction that an estimate is off beside its spread, for suits and people that it has not seen."""
_CHEST_SHARE = 0.4
"""Share of the estimate's chest beside the databases': the one knows more people, the other the suit's own T-pose."""


def body_posture(
    positions: Array,
    rotations: Array,
    valid: NDArray[np.bool_],
    head_height: float,
    fps: float,
    databases: Sequence[MotionDatabase],
) -> Posture:
    """Hips and chest under the head, as the databases' bodies hold them.

    Args:
        positions: `(T, 3, 3)` joints of head, left and right hand in the world, metres, scaled to the databases' body.
        rotations: `(T, 3, 4)` of these joints since T-pose.
        valid: `(T, 3)` whether each was tracked.
        head_height: of the head joint of the databases' body when it stands upright, metres.
        fps: frames per second.
        databases: whose poses show how this body leans; all of one skeleton.
    """
    sums = pooled([sums_of(database) for database in databases])
    return posture_of(sums, positions, rotations, valid, head_height, fps)


def with_estimate(posture: Posture, estimate: BodyEstimate, head_height: float) -> Posture:
    """A posture drawn to what an estimate knows of it; the same where it knows nothing.

    Args:
        posture: from `body_posture`.
        estimate: of the same frames.
        head_height: of the head joint of the databases' body when it stands upright, metres.
    """
    hips, chest = posture.hips, posture.chest
    if estimate.hips is not None:
        told = angles.turn(estimate.hips.mean[:, :2] * head_height, estimate.yaws)
        off = _SUIT_M**2 + (estimate.hips.spread * head_height) ** 2
        hips = hips + (_OWN_M**2 / (_OWN_M**2 + off))[:, None] * (told - hips)
    if estimate.chest is not None:
        turned = quat.from_rotation_vector(estimate.chest.mean)
        told = quat.multiply(quat.from_yaw(estimate.yaws), turned)
        chest = quat.slerp(chest, told, np.full(len(chest), _CHEST_SHARE))
    return Posture(hips, chest)


def elbows_of(estimate: BodyEstimate) -> Array | None:
    """Which way the elbows are from the hands `(T, 2, 3)` in the world, unit vectors; None where it does not know."""
    if estimate.elbows is None:
        return None
    return quat.rotate(quat.from_yaw(estimate.yaws)[:, None], unit(estimate.elbows.mean))

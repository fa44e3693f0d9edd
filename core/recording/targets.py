"""From devices to the body: where head and wrists are, and people of other sizes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..maths import quat
from .recording import Array, Mounts, Recording


def joint_targets(recording: Recording) -> tuple[Array, Array]:
    """World poses of the joints that carry the trackers: head, left hand, right hand.

    The inverse of the mounts: with a device at p, turned by R, the joint's rotation is D = R turn^-1 and its
    position p - D offset.

    Returns:
        Positions `(T, 3, 3)` in metres and rotations since T-pose `(T, 3, 4)`.
    """
    mounts = recording.mounts
    rotations = quat.multiply(recording.rotations, quat.conjugate(mounts.turns))
    return recording.positions - quat.rotate(rotations, mounts.offsets), rotations


def scale(recording: Recording, factor: float) -> Recording:
    """The recording of a body `factor` times as large, scaled about the world's origin on the floor."""
    mounts = Mounts(offsets=recording.mounts.offsets * factor, turns=recording.mounts.turns)
    return replace(
        recording,
        positions=recording.positions * factor,
        eye_height=recording.eye_height * factor,
        mounts=mounts,
    )


def raised(recording: Recording, lift: Array) -> Recording:
    """The recording of a body that is `lift` `(T,)` metres higher."""
    up = np.multiply.outer(lift, np.array([0.0, 0.0, 1.0]))
    return replace(recording, positions=recording.positions + up[:, None])

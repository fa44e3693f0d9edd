"""Where trackers sit on head and hands, and how a hand's axes relate to a controller's.

A skeleton in T-pose faces +Y with palms down and thumbs forward, so its fingers point along -X (left) and +X
(right). A controller has no T-pose: its axes are those of the hand that shakes another's, X right, Y along
the fingers, Z along the thumb. The two handshake rotations below lead from one to the other.
"""

from __future__ import annotations

import math

import numpy as np

from ..maths import quat
from .recording import Array, Mounts

# columns: where the T-pose's X, Y and Z go when the hand points forward with the thumb up
_HANDSHAKE_LEFT = quat.from_matrix(np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))
_HANDSHAKE_RIGHT = quat.from_matrix(np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))


def grip_mounts(head: tuple[float, float, float], reach: float, pitch: float) -> Mounts:
    """Mounts of a headset and two controllers held in the usual way.

    Args:
        head: metres from the head joint to the headset, in T-pose axes (X right, Y forward, Z up).
        reach: metres from the wrist to the controllers' origin along the fingers.
        pitch: radians by which a controller's forward axis points above the line of the fingers.
    """
    tilt = quat.from_axis("X", pitch)
    turns: list[Array] = [
        quat.multiply(quat.conjugate(hand), tilt) for hand in (_HANDSHAKE_LEFT, _HANDSHAKE_RIGHT)
    ]
    offsets = np.array([head, (-reach, 0.0, 0.0), (reach, 0.0, 0.0)])
    return Mounts(offsets=offsets, turns=np.stack([quat.IDENTITY, *turns]))


SIMULATED_MOUNTS = grip_mounts(head=(0.0, 0.10, 0.0), reach=0.08, pitch=0.0)
"""Virtual trackers: a headset 0.10 m ahead of the head joint, controllers at the grip."""

DEVICE_MOUNTS = grip_mounts(head=(0.0, 0.08, 0.09), reach=0.10, pitch=math.radians(15.0))
"""Real devices, typical values: a headset before the eyes, a wand or ring controller in the fist.

Measured on real recordings. Headset: somebody who looks down, up, left and right on the spot, wearing a Quest
2, turns the head about a point 0.07 m behind and 0.09 m below the headset. Controllers: with the wrist taken
as stiff, the elbow is the point in a controller's frame that keeps its distance from the shoulder; with Vive
wands it lies 0.33 m (left) and 0.39 m (right) behind the controller and 0.09 m above its axis. A forearm of
0.26 m leaves about 0.10 m from wrist to controller, which points 13 to 17 degrees above the forearm.
"""

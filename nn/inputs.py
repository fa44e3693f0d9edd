"""The 42 numbers that the paper's network sees (section 4.1), computed one way for training and for use.

For head, left hand and right hand: rotation (6), velocity (3) and angular velocity (3), then the previous
body orientation (6), all in the frame of the headset's forward projected on the ground. Poses are those of
the tracked joints, which the mounts give for any headset and grip, so that one network serves them all.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..core.maths import quat

Array = NDArray[np.floating[Any]]

RATE = 60.0
"""Frames per second of the recurrent network, as the paper's training data."""
TRACKED = 36
INPUTS = 42
_PARTS = ((0, 6), (6, 9), (9, 12))
GROUPS = (
    *(slice(12 * tracker + a, 12 * tracker + b) for tracker in range(3) for a, b in _PARTS),
    slice(TRACKED, INPUTS),
)
"""Inputs that share one deviation: rotation, velocity and angular velocity of each tracker, and the
orientation."""


@dataclass(frozen=True, slots=True, eq=False)
class Scaler:
    """What makes inputs comparable: `(x - mean) / deviation`."""

    mean: Array
    """`(D,)`."""
    deviation: Array
    """`(D,)`, above zero."""

    def apply(self, x: Array) -> Array:
        """Normalised inputs of the same shape."""
        return (x - self.mean) / self.deviation


def group_scaler(x: Array, groups: tuple[slice, ...]) -> Scaler:
    """The scaler of rows `(N, D)`: a mean per column, and per group the mean of its columns' deviations.

    A group that never changes keeps a deviation of 1 so that nothing is divided by zero.
    """
    deviation = np.ones(x.shape[1])
    spreads: Array = np.std(x, axis=0)
    for group in groups:
        spread = float(np.mean(spreads[group]))
        deviation[group] = spread if spread > 1e-6 else 1.0
    mean: Array = np.mean(x, axis=0)
    return Scaler(mean, deviation)


def headings(rotations: Array) -> Array:
    """World yaw `(T,)` in radians of the headset's projected forward, of pose rotations `(T, 3, 4)`."""
    return quat.heading(rotations[:, 0])


def tracker_inputs(positions: Array, rotations: Array, fps: float) -> Array:
    """The tracked part of the inputs `(T, 36)`.

    Velocities are backward differences, which a live system has too; the first frame repeats the second's.

    Args:
        positions: `(T, 3, 3)` world positions of head, left and right hand, metres.
        rotations: `(T, 3, 4)` their world rotations since T-pose.
        fps: frames per second.
    """
    to_frame = quat.from_yaw(-headings(rotations))[:, None]
    velocity = _backward(np.diff(positions, axis=0) * fps)
    step = quat.multiply(rotations[1:], quat.conjugate(rotations[:-1]))
    spin = _backward(quat.to_rotation_vector(step) * fps)
    parts = (
        quat.to_sixd(quat.multiply(to_frame, rotations)),
        quat.rotate(to_frame, velocity),
        quat.rotate(to_frame, spin),
    )
    return np.concatenate(parts, axis=-1).reshape(len(positions), TRACKED)


def _backward(steps: Array) -> Array:
    if len(steps) == 0:
        return np.zeros((1, *steps.shape[1:]))
    return np.concatenate([steps[:1], steps])


def yaw_to_sixd(yaw: ArrayLike) -> Array:
    """The six numbers `(..., 6)` of a rotation about the vertical by `yaw` radians `(...)`."""
    return quat.to_sixd(quat.from_yaw(yaw))


def sixd_to_yaw(sixd: Array) -> Array:
    """The yaw in radians `(...)` of any six numbers `(..., 6)`, made a rotation by Gram-Schmidt first."""
    return quat.heading(quat.from_sixd(sixd))


def turn_sixd(sixd: Array, yaw: ArrayLike) -> Array:
    """Six numbers `(..., 6)` re-expressed in axes turned by `-yaw` radians `(...)`; linear, so raw
    outputs may be turned."""
    c, s = np.cos(yaw), np.sin(yaw)
    out = np.array(sixd)
    for x in (0, 3):
        out[..., x] = c * sixd[..., x] - s * sixd[..., x + 1]
        out[..., x + 1] = s * sixd[..., x] + c * sixd[..., x + 1]
    return out

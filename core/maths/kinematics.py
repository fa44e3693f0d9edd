"""Forward kinematics and time derivatives of joint hierarchies, vectorised over frames."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import quat

Array = NDArray[np.floating[Any]]


def forward(
    positions: Array, rotations: Array, offsets: Array, parents: NDArray[np.intp]
) -> tuple[Array, Array]:
    """Global joint positions `(T, J, 3)` and rotations `(T, J, 4)`.

    Args:
        positions: `(T, 3)` world position of joint 0, metres.
        rotations: `(T, J, 4)` local rotations; joint 0's is global.
        offsets: `(J, 3)` offsets from the parent joint, metres; `offsets[0]` is not used.
        parents: `(J,)` index of each joint's parent, smaller than its own; -1 for joint 0.
    """
    # time fastest in memory, as the results of `quat`
    out_p = np.empty((*rotations.shape[:-1], 3), order="F")
    out_r = np.empty(rotations.shape, order="F")
    out_p[:, 0], out_r[:, 0] = positions, rotations[:, 0]
    for j in range(1, len(parents)):
        p = parents[j]
        out_r[:, j] = quat.multiply(out_r[:, p], rotations[:, j])
        out_p[:, j] = out_p[:, p] + quat.rotate(out_r[:, p], offsets[j])
    return out_p, out_r


def local_rotations(global_rotations: Array, parents: NDArray[np.intp]) -> Array:
    """Local rotations `(T, J, 4)` of global ones; joint 0 keeps its global rotation."""
    out = np.array(global_rotations)
    out[:, 1:] = quat.multiply(quat.conjugate(global_rotations[:, parents[1:]]), global_rotations[:, 1:])
    return quat.continuous(out)


def velocity(values: Array, fps: float) -> Array:
    """Central differences of `values` `(T, ...)` per second; one-sided at both ends; zeros for one frame."""
    if len(values) < 2:
        return np.zeros_like(values)
    return np.gradient(values, axis=0) * fps


def angular_velocity(rotations: Array, fps: float) -> Array:
    """World angular velocity `(T, ..., 3)` in rad/s of rotations `(T, ..., 4)` by central differences."""
    if len(rotations) < 2:
        return np.zeros((*rotations.shape[:-1], 3))
    step = quat.to_rotation_vector(quat.multiply(rotations[1:], quat.conjugate(rotations[:-1]))) * fps
    return np.concatenate([step[:1], 0.5 * (step[1:] + step[:-1]), step[-1:]], axis=0)

"""Forward kinematics of joint hierarchies, vectorised over frames: the one place that walks down a skeleton."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..maths import quat

Array = NDArray[np.floating[Any]]


def forward(
    positions: Array, rotations: Array, offsets: Array, parents: NDArray[np.intp]
) -> tuple[Array, Array]:
    """Global joint positions `(T, J, 3)` and rotations `(T, J, 4)`.

    Args:
        positions: `(T, 3)` world position of joint 0, metres.
        rotations: `(T, J, 4)` local rotations; joint 0's is global.
        offsets: `(J, 3)`, or `(T, J, 3)` where they change, from the parent joint, metres; joint 0's is not used.
        parents: `(J,)` index of each joint's parent, smaller than its own; -1 for joint 0.
    """
    turned = global_rotations(rotations, parents)
    return joint_positions(positions, turned, offsets, parents), turned


def global_rotations(rotations: Array, parents: NDArray[np.intp]) -> Array:
    """Global rotations `(T, J, 4)` of local ones; joint 0 keeps its rotation."""
    # time fastest in memory, as the results of `quat`
    out = np.empty(rotations.shape, order="F")
    out[:, 0] = rotations[:, 0]
    for j in range(1, len(parents)):
        out[:, j] = quat.multiply(out[:, parents[j]], rotations[:, j])
    return out


def joint_positions(root: Array, rotations: Array, offsets: Array, parents: NDArray[np.intp]) -> Array:
    """Global positions `(T, J, 3)` of global rotations `(T, J, 4)`; `root` `(T, 3)` and `offsets` as for `forward`."""
    out = np.empty((*rotations.shape[:-1], 3), order="F")
    out[:, 0] = root
    for j in range(1, len(parents)):
        p = parents[j]
        out[:, j] = out[:, p] + quat.rotate(rotations[:, p], offsets[..., j, :])
    return out


def local_rotations(global_rotations: Array, parents: NDArray[np.intp]) -> Array:
    """Local rotations `(T, J, 4)` of global ones; joint 0 keeps its rotation."""
    out = np.array(global_rotations)
    out[:, 1:] = quat.multiply(quat.conjugate(global_rotations[:, parents[1:]]), global_rotations[:, 1:])
    return quat.continuous(out)

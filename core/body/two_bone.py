"""Two bones reach a point: the law of cosines, for any number of limbs and frames at once."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..maths import quat
from ..maths.vectors import across, norm, plane, unit

Array = NDArray[np.floating[Any]]


def reach(
    joints: Array, rotations: Array, targets: Array, bend: Array, aim: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """Turn a limb's two bones so that its end comes to a target.

    The limb is turned as a whole so that its line runs to the target and its `bend` direction lies towards
    `aim`; then both bones turn in that plane to the angles of the law of cosines. A target out of reach
    leaves the limb straight, or folded, in the target's direction.

    Args:
        joints: `(..., 3, 3)` root, mid and end of the limb, metres.
        rotations: `(..., 2, 4)` world rotations of the root and the mid joint.
        targets: `(..., 3)` where the end shall be, metres.
        bend: `(..., 3)` where the mid joint lies, or would lie if the limb were not straight, seen from the
            line between root and end: any vector not along that line (see `bend_direction`).
        aim: `(..., 3)` where the mid joint shall lie, seen from the line between root and target.

    Returns:
        New world rotations `(..., 2, 4)`, and `(...)` whether the end reaches the target.
    """
    upper, lower = joints[..., 1, :] - joints[..., 0, :], joints[..., 2, :] - joints[..., 1, :]
    line, wanted = joints[..., 2, :] - joints[..., 0, :], targets - joints[..., 0, :]
    mid, end, reached = triangle(norm(upper), norm(lower), wanted, aim)
    whole = quat.multiply(
        quat.from_matrix(plane(wanted, aim)), quat.conjugate(quat.from_matrix(plane(line, bend)))
    )
    out = np.empty(rotations.shape)
    for i, (old, new) in enumerate(((upper, mid), (lower, end - mid))):
        turn = quat.multiply(quat.between(quat.rotate(whole, old), new), whole)
        out[..., i, :] = quat.multiply(turn, rotations[..., i, :])
    return out, reached


def triangle(upper: Array, lower: Array, wanted: Array, aim: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Where the mid joint and the end of a limb lie, seen from its root, metres.

    Args:
        upper: `(...)` length of the first bone.
        lower: `(...)` length of the second.
        wanted: `(..., 3)` from the root to the target.
        aim: `(..., 3)` where the mid joint shall lie, seen from the line to the target.

    Returns:
        Mid joint `(..., 3)`, end `(..., 3)`, and `(...)` whether the end is at the target.
    """
    distance = norm(wanted)
    span = np.clip(distance, np.abs(upper - lower), upper + lower)
    cosine = (upper**2 + span**2 - lower**2) / np.maximum(2.0 * upper * span, 1e-12)
    cosine = np.clip(cosine, -1.0, 1.0)
    frame = plane(wanted, aim)
    along, side = (upper * cosine)[..., None], (upper * np.sqrt(1.0 - cosine**2))[..., None]
    mid = along * frame[..., 0] + side * frame[..., 1]
    return mid, span[..., None] * frame[..., 0], np.abs(span - distance) < 1e-6


def bend_direction(joints: Array, hint: Array, softness: float) -> Array:
    """Where a limb's mid joint lies, seen from the line between root and end, `(..., 3)`.

    The limb's own bend where it has one; a limb that is straight within about `softness` metres takes more
    and more of the `hint`, so that noise around the straight limb does not turn its plane.

    Args:
        joints: `(..., 3, 3)` root, mid and end, metres.
        hint: `(..., 3)` unit vectors, e.g. the way the knee cap looks.
        softness: metres.
    """
    along = unit(joints[..., 2, :] - joints[..., 0, :])
    return across(joints[..., 1, :] - joints[..., 0, :], along) + softness * across(hint, along)

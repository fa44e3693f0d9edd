"""Takes whose files have poses of joints in the world, as if they were BVH: places and turns on each joint's parent."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body import forward_kinematics as fk
from ..maths import quat
from .bvh import CHANNELS, BvhFile

Array = NDArray[np.floating[Any]]

_ORDER = "XYZ"


def bvh_of_poses(
    names: Sequence[str],
    parents: NDArray[np.intp],
    rest: Array,
    positions: Array,
    rotations: Array,
    *,
    fps: float,
    file: str,
    sha256: str,
    rest_is_a_frame: bool = False,
    doubts: Sequence[str] = (),
) -> BvhFile:
    """A take as BVH says it, with all six channels on every joint.

    Args:
        names: `(J,)`.
        parents: `(J,)`, -1 for joint 0 alone, parents before children.
        rest: `(J, 3)` joint positions in the pose in which all rotations are none.
        positions: `(T, J, 3)` joint positions, in the unit and axes of `rest`.
        rotations: `(T, J, 4)` global rotations since the rest pose.
        fps: frames per second.
        file: name of the file, for messages.
        sha256: of its content.
        rest_is_a_frame: whether the rest pose is but one of the motion's own.
        doubts: what is odd about it.
    """
    above = np.maximum(parents, 0)
    ways = positions - positions[:, above]
    ways[:, 1:] = quat.rotate(quat.conjugate(rotations[:, above[1:]]), ways[:, 1:])
    ways[:, 0] = positions[:, 0]
    angles = np.degrees(quat.to_euler(fk.local_rotations(rotations, parents), _ORDER))
    offsets = rest - rest[above]
    offsets[0] = rest[0]
    return BvhFile(
        names=tuple(names),
        parents=parents,
        offsets=offsets,
        channels=(CHANNELS,) * len(names),
        end_sites=np.zeros((0, 3)),
        end_parents=np.zeros(0, dtype=np.intp),
        frame_time=1.0 / fps,
        values=np.concatenate([ways, angles], axis=-1).reshape(len(positions), -1),
        file=file,
        sha256=sha256,
        zero_is_a_frame=rest_is_a_frame,
        doubts=tuple(doubts),
    )

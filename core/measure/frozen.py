"""What legs have to be better than: one pose, the mean of the databases, carried along by the bake's own root."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..body.motion import Motion
from ..body.retarget import retarget
from ..body.skeleton import Skeleton
from ..database.motion_database import MotionDatabase
from ..maths import angles
from .measures import Array

_BLOCK = 16384


def frozen_body(databases: Sequence[MotionDatabase], skeleton: Skeleton, roots: Array, yaws: Array) -> Array:
    """Joint positions `(T, J, 3)` of a body in the databases' mean pose, metres.

    Args:
        databases: on one skeleton.
        skeleton: the body that stands so.
        roots: `(T, 2)` where it is put, metres.
        yaws: `(T,)` how it is turned, radians.
    """
    pose = mean_pose(databases)
    positions = retarget(pose, skeleton).forward()[0][0]
    placed = np.repeat(positions[None], len(roots), axis=0)
    placed[..., :2] = angles.turn(placed[..., :2], yaws[:, None]) + roots[:, None]
    return placed


def mean_pose(databases: Sequence[MotionDatabase]) -> Motion:
    """One frame over the origin: mean height of the hips, mean local rotations of all frames of all databases.

    A mean rotation maximises the squared cosines to all (Markley et al., "Averaging quaternions", 2007).
    """
    first = databases[0]
    heights, products = 0.0, np.zeros((len(first.skeleton), 4, 4))
    for database in databases:
        heights += float(database.poses.hips_positions[:, 2].sum(dtype=np.float64))
        for start in range(0, len(database), _BLOCK):
            rotations = database.poses.rotations[start : start + _BLOCK].astype(np.float64)
            rotations = np.ascontiguousarray(np.swapaxes(rotations, 0, 1))
            products += np.swapaxes(rotations, 1, 2) @ rotations
    place = np.array([[0.0, 0.0, heights / sum(len(database) for database in databases)]])
    means = np.linalg.eigh(products)[1][..., -1]
    return Motion(first.skeleton, first.fps, place, np.where(means[:, :1] < 0.0, -means, means)[None])

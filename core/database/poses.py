"""Poses y of one clip: the virtual root in the world, the joints below it (paper, section 5.1)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body.motion import Motion
from ..maths import kinematics, quat
from .motion_database import PoseDatabase
from .virtual_root import to_root_space

Array = NDArray[np.floating[Any]]


def clip_poses(
    motion: Motion, root_positions: Array, root_yaws: Array, contacts: NDArray[np.bool_]
) -> PoseDatabase:
    """The poses of a clip.

    The root's velocities are steps to the next frame, so that adding them up plays the clip; those of the
    hips and of the joints are central differences.

    Args:
        motion: the clip, `T` frames.
        root_positions: `(T, 2)` metres.
        root_yaws: `(T,)` radians, continuous.
        contacts: `(T, 2)` left, right.
    """
    fps = motion.fps
    hips = motion.positions.astype(np.float64)
    hips[:, :2] -= root_positions
    hips = to_root_space(hips, root_yaws)
    rotations = motion.rotations.astype(np.float64)
    rotations[:, 0] = quat.multiply(quat.from_yaw(-root_yaws), rotations[:, 0])
    rotations = quat.continuous(rotations)
    return PoseDatabase(
        root_positions=root_positions,
        root_yaws=root_yaws,
        hips_positions=hips,
        rotations=rotations,
        root_velocities=to_root_space(steps(root_positions, fps), root_yaws),
        root_yaw_velocities=steps(root_yaws, fps),
        hips_velocities=kinematics.velocity(hips, fps),
        angular_velocities=kinematics.angular_velocity(rotations, fps),
        contacts=contacts,
    )


def steps(values: Array, fps: float) -> Array:
    """Differences to the next frame per second `(T, ...)`; the last one is repeated, zero for one frame."""
    if len(values) < 2:
        return np.zeros_like(values)
    difference = np.diff(values, axis=0) * fps
    return np.concatenate([difference, difference[-1:]])


def join_poses(clips: Sequence[PoseDatabase]) -> PoseDatabase:
    """The poses of several clips, one after the other.

    Numbers are rounded to what the side-car file keeps, so that a database gives the same results before it
    is saved and after it is loaded.
    """
    columns: dict[str, Any] = {}
    for item in fields(PoseDatabase):
        column = np.concatenate([getattr(clip, item.name) for clip in clips])
        if column.dtype != np.bool_:
            # a pose in one run of memory: matching gathers them by rows
            column = column.astype(np.float32, order="C").astype(np.float64)
        columns[item.name] = column
    return PoseDatabase(**columns)

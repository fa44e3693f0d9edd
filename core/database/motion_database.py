"""The motion database: poses y and features z of one or more clips (paper, sections 5.1 and 5.2)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body.skeleton import Skeleton

Array = NDArray[np.floating[Any]]

HORIZONS_S = (1.0 / 3.0, 2.0 / 3.0, 1.0)
"""Trajectory horizons in seconds (paper, section 5.2): 20, 40 and 60 frames at 60 fps."""

FEATURE_GROUPS: dict[str, slice] = {
    "trajectory_positions": slice(0, 6),
    "trajectory_directions": slice(6, 12),
    "left_foot_position": slice(12, 15),
    "left_foot_velocity": slice(15, 18),
    "right_foot_position": slice(18, 21),
    "right_foot_velocity": slice(21, 24),
    "hips_velocity": slice(24, 27),
}
"""Columns of the 27-D feature vector, in root space; the trajectory is x, y at each horizon in turn."""
TRAJECTORY = slice(0, 12)
POSE = slice(12, 27)
FEATURE_COUNT = 27


@dataclass(frozen=True, slots=True)
class Clip:
    """A run of consecutive frames that came from one take."""

    name: str
    start: int
    stop: int
    file: str
    sha256: str
    mirrored: bool


@dataclass(frozen=True, slots=True, eq=False)
class PoseDatabase:
    """Poses y of N frames: the virtual root in the world and the joints below it.

    Local joint positions other than the hips' are the skeleton's offsets, so only the hips' are stored.
    """

    root_positions: Array
    """`(N, 2)` virtual root on the ground of its clip, metres."""
    root_yaws: Array
    """`(N,)` radians, continuous within a clip."""
    hips_positions: Array
    """`(N, 3)` hips in root space, metres."""
    rotations: Array
    """`(N, J, 4)` local rotations since T-pose; joint 0, the hips, relative to the virtual root."""
    root_velocities: Array
    """`(N, 2)` m/s in root space: the step from frame n to n + 1, repeated at a clip's last frame."""
    root_yaw_velocities: Array
    """`(N,)` rad/s, likewise."""
    hips_velocities: Array
    """`(N, 3)` m/s in root space, of `hips_positions`, by central differences."""
    angular_velocities: Array
    """`(N, J, 3)` rad/s, in the parent's axes, of `rotations`, by central differences."""
    contacts: NDArray[np.bool_]
    """`(N, 2)` left, right toe on the ground."""

    def __len__(self) -> int:
        return len(self.root_yaws)


@dataclass(frozen=True, slots=True, eq=False)
class FeatureDatabase:
    """Features z of the same N frames, normalised."""

    values: Array
    """`(N, 27)` float32, (feature - mean) / deviation; horizons past a clip's end read its end."""
    mean: Array
    """`(27,)`."""
    deviation: Array
    """`(27,)` one value for each feature group."""
    trajectory_valid: NDArray[np.bool_]
    """`(N,)` False for frames whose last horizon lies past their clip's end: played, never found."""


@dataclass(frozen=True, slots=True, eq=False, weakref_slot=True)
class MotionDatabase:
    """Everything of one side-car file."""

    name: str
    skeleton: Skeleton
    fps: float
    clips: tuple[Clip, ...]
    poses: PoseDatabase
    features: FeatureDatabase
    head_height: float
    """Height of the head joint while this body stands at ease, metres."""
    height_range: tuple[float, float]
    """Headset height over calibrated eye height for which this database is meant: [low, high)."""
    tags: tuple[str, ...] = ()
    provenance: dict[str, str] = field(default_factory=dict[str, str])
    sha256: str = ""
    """Of the file that it was read from; "" for one that was just built."""

    def __len__(self) -> int:
        return len(self.poses)

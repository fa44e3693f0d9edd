"""Where a bake is put: a recording that starts at the origin, and from there to a place in the scene."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body.motion import Motion
from ..maths import quat
from ..recording.recording import Recording
from ..recording.targets import joint_targets
from .ground import Ground

Array = NDArray[np.floating[Any]]

START = 0.5
"""Seconds over which the headset says which way a recording starts."""


@dataclass(frozen=True, slots=True)
class Place:
    """A place on the ground and the way that a body faces there."""

    position: tuple[float, float, float]
    """Metres in the scene's world; the floor there."""
    yaw: float
    """Radians from +Y, left positive."""

    def to_scene(self, positions: Array, rotations: Array) -> tuple[Array, Array]:
        """Positions `(..., 3)` and rotations `(..., 4)` about the origin, as they are at the place."""
        turn = quat.from_yaw(self.yaw)
        return quat.rotate(turn, positions) + np.array(self.position), quat.multiply(turn, rotations)

    def from_scene(self, positions: Array, rotations: Array) -> tuple[Array, Array]:
        """The way back."""
        turn = quat.from_yaw(-self.yaw)
        return quat.rotate(turn, positions - np.array(self.position)), quat.multiply(turn, rotations)


def from_start(recording: Recording) -> Recording:
    """The recording moved over the ground so that the head starts above the origin and faces +Y."""
    targets, rotations = joint_targets(recording)
    early = quat.heading(rotations[recording.times <= recording.times[0] + START, 0])
    yaw = np.arctan2(np.sin(early).mean(), np.cos(early).mean())
    turn = quat.from_yaw(-yaw)
    start = targets[0, 0] * np.array([1.0, 1.0, 0.0])
    return replace(
        recording,
        positions=quat.rotate(turn, recording.positions - start),
        rotations=quat.continuous(quat.multiply(turn, recording.rotations)),
    )


def put(motion: Motion, place: Place) -> Motion:
    """A motion about the origin, at a place."""
    positions, turned = place.to_scene(motion.positions, motion.rotations[:, 0])
    rotations = motion.rotations.copy()
    rotations[:, 0] = turned
    return replace(motion, positions=positions, rotations=quat.continuous(rotations))


def ground_from(ground: Ground, place: Place) -> Ground:
    """The scene's ground as it lies about the origin of who is to be put at a place."""

    turn, back = quat.from_yaw(place.yaw), quat.from_yaw(-place.yaw)

    def around(points: Array) -> tuple[Array, Array]:
        there = quat.rotate(turn, np.pad(points, ((0, 0), (0, 1)))) + np.array(place.position)
        heights, normals = ground(there[:, :2])
        return heights - place.position[2], quat.rotate(back, normals)

    return around

"""What a reader finds in a file: each tracker's own samples, already in Footwork's axes, not yet repaired."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .mounts import DEVICE_MOUNTS
from .recording import Array, Mounts

_DIRECTIONS = {
    "R": (1.0, 0.0, 0.0),
    "L": (-1.0, 0.0, 0.0),
    "F": (0.0, 1.0, 0.0),
    "B": (0.0, -1.0, 0.0),
    "U": (0.0, 0.0, 1.0),
    "D": (0.0, 0.0, -1.0),
}


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """One tracker's samples as recorded, in Blender's axes and metres."""

    times: Array
    """`(N,)` seconds from any origin common to all tracks; may repeat or run backwards."""
    positions: Array
    """`(N, 3)`; NaN where the file has none."""
    rotations: Array
    """`(N, 4)` of any length; zero or NaN where the file has none."""
    valid: NDArray[np.bool_]
    """`(N,)` what the file itself says of tracking."""


@dataclass(frozen=True, slots=True, eq=False)
class RawRecording:
    """A file's content before repair."""

    tracks: tuple[Track, Track, Track]
    """Head, left, right; a tracker that is not in the file has no samples."""
    found: dict[str, str]
    name: str = ""
    """The name that the file states, "" for none."""
    mounts: Mounts = DEVICE_MOUNTS
    eye_height: float | None = None
    """Calibrated eye height in metres where the file states it."""
    states_validity: bool = False
    """Whether the file tells itself when a tracker was lost; otherwise that is guessed."""
    on_floor: bool = True
    """Whether heights are above the floor; otherwise they are relative to an unknown place."""


def change_axes(positions: Array, rotations: Array, axes: str) -> tuple[Array, Array]:
    """World poses and device axes of a file brought into Blender's world and Footwork's device axes.

    Args:
        positions: `(..., 3)` in the file's axes.
        rotations: `(..., 4)` likewise.
        axes: where the file's x, y and z point, for world and devices alike: three of R(ight) L(eft) U(p)
            D(own) F(orward) B(ack). WebXR and OpenVR are "RUB", Unity (left-handed) is "RUF".
    """
    change = np.array([_DIRECTIONS[letter] for letter in axes]).T
    # the axis of a rotation is a pseudovector: a change of handedness turns it round as well
    axis = np.linalg.det(change) * rotations[..., 1:] @ change.T
    return positions @ change.T, np.concatenate([rotations[..., :1], axis], axis=-1)

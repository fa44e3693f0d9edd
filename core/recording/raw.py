"""What a reader finds in a file: each tracker's own samples, already in Footwork's axes, not yet repaired."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .mounts import DEVICE_MOUNTS
from .recording import Array, Mounts

DIRECTIONS = {
    "R": (1.0, 0.0, 0.0),
    "L": (-1.0, 0.0, 0.0),
    "F": (0.0, 1.0, 0.0),
    "B": (0.0, -1.0, 0.0),
    "U": (0.0, 0.0, 1.0),
    "D": (0.0, 0.0, -1.0),
}


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """One tracker's samples as recorded, in Blender's axes and metres unless a reading says otherwise."""

    times: Array
    """`(N,)` seconds from any origin common to all tracks; may repeat or run backwards."""
    positions: Array
    """`(N, 3)`; NaN where the file has none."""
    rotations: Array
    """`(N, 4)` of any length; zero or NaN where the file has none. `(N, k)` where a reading says so."""
    valid: NDArray[np.bool_]
    """`(N,)` what the file itself says of tracking."""


@dataclass(frozen=True, slots=True)
class Reading:
    """How a file's numbers are to be understood."""

    axes: str = "RFU"
    """Where the world's x, y and z point, as in `change_axes`."""
    metres: float = 1.0
    """Of the unit of length."""
    rotation: str = "wxyz"
    """How rotations are written, one of `rotations.KINDS`."""
    devices: str = ""
    """Where a device's own x, y and z point while it has no rotation; "" as the world's."""
    hands: str = "world"
    """Controllers' positions are in the "world", an "offset" from the headset, or "local" to the turned headset."""
    swapped: bool = False
    """Whether left is called right."""


STATED = frozenset(("axes", "unit", "rotation", "sides", "origin"))
"""What a format can say of itself."""


@dataclass(frozen=True, slots=True, eq=False)
class Extra:
    """Another tracker: on the waist, a foot, a knee."""

    name: str
    """As the file calls it."""
    track: Track
    rotation: str = ""
    """How its rotations are written, where that is another way than the reading's."""


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
    reading: Reading = Reading()
    """How the tracks' numbers are to be understood, as far as the file or its format tells."""
    stated: frozenset[str] = STATED
    """Of `STATED`, what it tells; the rest of the reading is a guess."""
    extra: tuple[Extra, ...] = ()
    """Trackers besides the three, with the same reading but for their rotations."""
    doubts: tuple[str, ...] = ()
    """What the reader met with, a line each."""
    counted: bool = False
    """Whether `times` of the tracks are numbers of samples, whose rate somebody has to tell."""


def change_axes(positions: Array, rotations: Array, axes: str) -> tuple[Array, Array]:
    """World poses and device axes of a file brought into Blender's world and Footwork's device axes.

    Args:
        positions: `(..., 3)` in the file's axes.
        rotations: `(..., 4)` likewise.
        axes: where the file's x, y and z point, for world and devices alike: three of R(ight) L(eft) U(p)
            D(own) F(orward) B(ack). WebXR and OpenVR are "RUB", Unity (left-handed) is "RUF".
    """
    change = np.array([DIRECTIONS[letter] for letter in axes]).T
    # the axis of a rotation is a pseudovector: a change of handedness turns it round as well
    axis = np.linalg.det(change) * rotations[..., 1:] @ change.T
    return positions @ change.T, np.concatenate([rotations[..., :1], axis], axis=-1)

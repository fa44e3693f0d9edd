"""Three-tracker recordings: a headset and two hand controllers over time.

Trackers are numbered 0 head, 1 left, 2 right. A device's axes are X right, Y forward (where it points), Z up;
positions are metres in Blender's world, the floor at Z = 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]

TRACKERS = ("head", "left", "right")
TRACKER_ROLES = ("head", "hand.L", "hand.R")
"""The joint that each tracker is fixed to."""


@dataclass(frozen=True, slots=True, eq=False)
class Mounts:
    """How the three trackers sit on head and hands.

    With a joint's world rotation since T-pose D and position p: device position = p + D offset, device
    rotation = D turn.
    """

    offsets: Array
    """`(3, 3)` metres from the joint to the device, in T-pose axes."""
    turns: Array
    """`(3, 4)` rotation of the device in T-pose."""


@dataclass(frozen=True, slots=True, eq=False)
class Happening:
    """Something that one tracker did, at known times."""

    kind: str
    """"lost", "jump", "still" or "laid down"."""
    tracker: int
    starts: Array
    """`(K,)` seconds of the recording, rising."""
    stops: Array
    """`(K,)` seconds; a jump takes no time."""
    height: float = 0.0
    """Metres at which a headset was laid down."""


@dataclass(frozen=True, slots=True, eq=False)
class ExtraTracker:
    """A tracker besides the three, on the waist, a foot, a knee."""

    name: str
    """As the file calls it."""
    positions: Array
    """`(T, 3)` metres, at the recording's times."""
    rotations: Array
    """`(T, 4)` unit."""
    valid: NDArray[np.bool_]
    """`(T,)`."""


@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """Positions and rotations of the three trackers over time."""

    name: str
    times: Array
    """`(T,)` seconds, strictly increasing, from 0; evenly spaced once resampled."""
    positions: Array
    """`(T, 3, 3)` frame, tracker, xyz in metres."""
    rotations: Array
    """`(T, 3, 4)` device rotations, unit, sign-continuous."""
    valid: NDArray[np.bool_]
    """`(T, 3)` whether the tracker was tracked; values are finite also where it was not."""
    mounts: Mounts
    eye_height: float
    """Calibrated height of the headset when its wearer stands at ease, metres."""
    file: str
    sha256: str
    found: dict[str, str]
    """What the reader decided, for people: format, rate, axes, eye height ... in order of printing."""
    doubts: tuple[str, ...]
    """What a person should look at, a line each; those about `happenings` among them."""
    happenings: tuple[Happening, ...] = ()
    """What the doubts at known times are about."""
    extra: tuple[ExtraTracker, ...] = ()
    """Other trackers, which nothing needs."""

    def __len__(self) -> int:
        return len(self.times)

    @property
    def fps(self) -> float:
        """Mean rate in frames per second."""
        return (len(self.times) - 1) / float(self.times[-1] - self.times[0])

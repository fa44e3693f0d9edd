"""Where trackers sit on head and hands, and how a hand's axes relate to a controller's.

A skeleton in T-pose faces +Y with palms down and thumbs forward, so its fingers point along -X (left) and +X
(right). A controller has no T-pose: its axes are those of the hand that shakes another's, X right, Y along
the fingers, Z along the thumb. The two handshake rotations below lead from one to the other.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..maths import quat
from .recording import Array, Mounts

# columns: where the T-pose's X, Y and Z go when the hand points forward with the thumb up
_HANDSHAKE_LEFT = quat.from_matrix(np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))
_HANDSHAKE_RIGHT = quat.from_matrix(np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))


def grip_mounts(head: tuple[float, float, float], reach: float, pitch: float) -> Mounts:
    """Mounts of a headset and two controllers held in the usual way.

    Args:
        head: metres from the head joint to the headset, in T-pose axes (X right, Y forward, Z up).
        reach: metres from the wrist to the controllers' origin along the fingers.
        pitch: radians by which a controller's forward axis points above the line of the fingers.
    """
    tilt = quat.from_axis("X", pitch)
    turns: list[Array] = [
        quat.multiply(quat.conjugate(hand), tilt) for hand in (_HANDSHAKE_LEFT, _HANDSHAKE_RIGHT)
    ]
    offsets = np.array([head, (-reach, 0.0, 0.0), (reach, 0.0, 0.0)])
    return Mounts(offsets=offsets, turns=np.stack([quat.IDENTITY, *turns]))


SIMULATED_MOUNTS = grip_mounts(head=(0.0, 0.10, 0.0), reach=0.08, pitch=0.0)
"""Virtual trackers: a headset 0.10 m ahead of the head joint, controllers at the grip."""

DEVICE_MOUNTS = grip_mounts(head=(0.0, 0.08, 0.09), reach=0.10, pitch=math.radians(15.0))
"""Real devices, typical values: a headset before the eyes, a wand or ring controller in the fist.

Measured on real recordings. Headset: somebody who looks down, up, left and right on the spot, wearing a Quest
2, turns the head about a point 0.07 m behind and 0.09 m below the headset. Controllers: with the wrist taken
as stiff, the elbow is the point in a controller's frame that keeps its distance from the shoulder; with Vive
wands it lies 0.33 m (left) and 0.39 m (right) behind the controller and 0.09 m above its axis. A forearm of
0.26 m leaves about 0.10 m from wrist to controller, which points 13 to 17 degrees above the forearm.
"""


@dataclass(frozen=True, slots=True)
class MountShape:
    """How a headset and its controllers sit, in four numbers."""

    title: str
    """For people."""
    ahead: float
    """Metres from the head joint forward to the headset."""
    above: float
    """Metres from the head joint up to the headset."""
    reach: float
    """Metres from the wrist along the fingers to the controllers."""
    pitch: float
    """Degrees by which controllers point above the fingers."""
    words: tuple[str, ...] = ()
    """Parts of what files call these devices, lower case, without separators."""

    @property
    def mounts(self) -> Mounts:
        """As `grip_mounts` makes them."""
        return grip_mounts((0.0, self.ahead, self.above), self.reach, math.radians(self.pitch))

    @property
    def numbers(self) -> str:
        """The four for people."""
        return (
            f"headset {self.ahead:.2f} m ahead and {self.above:.2f} m above, "
            f"controllers {self.reach:.2f} m from the wrist, {self.pitch:.0f} degrees up"
        )


SHAPES = {
    "vive-wands": MountShape(
        "Vive wands", 0.08, 0.09, 0.10, 15.0, ("vivecontroller", "htcvive", "wand", "vivemv")
    ),
    "quest-touch": MountShape(
        "Quest Touch", 0.08, 0.09, 0.08, 15.0, ("touch", "quest", "oculus", "rift", "metaquest")
    ),
    "index": MountShape(
        "Index controllers", 0.09, 0.09, 0.07, 15.0, ("knuckles", "valveindex", "indexcontroller")
    ),
    "wmr": MountShape(
        "Windows Mixed Reality",
        0.08,
        0.09,
        0.09,
        20.0,
        ("windowsmixed", "microsoftmixed", "holographic", "wmr", "reverb"),
    ),
    "pico": MountShape("Pico", 0.08, 0.09, 0.08, 15.0, ("pico", "bytedance")),
    "hands": MountShape(
        "tracked hands", 0.08, 0.09, 0.0, 0.0, ("generichand", "handtracking", "trackedhand", "xrhand")
    ),
}
"""Common devices by the names that options use, those told apart most surely first. Headset and wands are measured (see
`DEVICE_MOUNTS`); the rest is estimated from where these devices' origin lies in the fist, to about 3 cm, 10 degrees."""
FITTED = "fitted"
"""What options call mounts that follow from the movement."""
_SPANS = ((-0.1, 0.3), (-0.1, 0.3), (-0.1, 0.3), (-90.0, 90.0))


def shape_in(text: str) -> str:
    """The name in `SHAPES` of the devices that a file's text names; "" for none."""
    squeezed = "".join(letter for letter in text.lower() if letter.isalnum())
    hits = (
        (squeezed.find(word), name)
        for name in ("index", "wmr", "pico", "hands", "vive-wands", "quest-touch")
        for word in SHAPES[name].words
    )
    return next((name for place, name in hits if place >= 0), "")


def shape_of(text: str) -> MountShape:
    """The mounts that a person names, or gives as four numbers: metres ahead, above, reach, degrees.

    Raises:
        ValueError: neither.
    """
    if text in SHAPES:
        return SHAPES[text]
    try:
        ahead, above, reach, pitch = (float(word) for word in text.split(","))
    except ValueError:
        raise ValueError(
            f"give one of {', '.join(SHAPES)}, {FITTED}, or four numbers: "
            "metres ahead, above, from the wrist, degrees up"
        ) from None
    for value, (low, high) in zip((ahead, above, reach, pitch), _SPANS, strict=True):
        if not low <= value <= high:
            raise ValueError(f"{value:g} is not from {low:g} to {high:g}")
    return MountShape("given", ahead, above, reach, pitch)

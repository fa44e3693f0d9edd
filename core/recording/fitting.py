"""Where devices sit, by how they move: a head turns about its neck's end, a controller about the elbow."""

from __future__ import annotations

import numpy as np

from .mounts import SHAPES, MountShape
from .raw import RawRecording
from .reading.plausibility import measure, take_moments
from .recording import Array

_FIT = 0.9
"""Share of the movement that turns must explain: who walks or swings whole arms tells nothing of mounts. Of people with
known mounts, fits below this are off by up to 50 degrees."""
_FOREARM_M = 0.26
_BOUND_M = 0.2


def fitted(raw: RawRecording) -> tuple[MountShape, str]:
    """The mounts that a recording's movement tells, in Blender's axes and metres, and what of them it tells.

    What it does not tell is as of Vive wands. "" where it tells nothing.
    """
    usual = SHAPES["vive-wands"]
    moments = take_moments(raw)
    if moments is None:
        return usual, ""
    figures = measure(moments, raw.reading.rotation, raw.reading.hands)
    told: list[str] = []
    ahead, above, reach, pitch = usual.ahead, usual.above, usual.reach, usual.pitch
    head = figures.lever[0]
    if figures.fit[0] > _FIT and 0.0 < head[1] < _BOUND_M and 0.0 < head[2] < _BOUND_M:
        ahead, above = float(head[1]), float(head[2])
        told.append("headset")
    hands = figures.lever[1:][(figures.fit[1:] > _FIT) & (figures.lever[1:, 1] > _FOREARM_M)]
    if len(hands):
        elbow: Array = hands.mean(axis=0)
        pitch = float(np.degrees(np.arctan2(-elbow[2], elbow[1])))
        reach = float(np.clip(np.hypot(elbow[1], elbow[2]) - _FOREARM_M, 0.0, _BOUND_M))
        told.append("controllers")
    return MountShape("fitted", ahead, above, reach, pitch), " and ".join(told)

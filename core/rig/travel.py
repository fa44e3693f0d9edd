"""The way of a body over the ground, as engines want it: carried by a root, or taken out."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body.motion import Motion
from ..maths import angles, filters, quat

Array = NDArray[np.floating[Any]]

SMOOTHING = 0.4
"""Seconds of the window over the way: a root does not sway with each step."""


def way(motion: Motion) -> tuple[Array, Array]:
    """Where the body is on the ground `(T, 2)`, metres, and the yaw that it faces `(T,)`, without jumps."""
    yaws = np.unwrap(quat.heading(motion.rotations[:, 0]))
    window = filters.odd_window(SMOOTHING, motion.fps)
    places = np.asarray(motion.positions[:, :2], dtype=np.float64)
    if window == 1 or len(motion) < 2:
        return places, yaws
    directions = filters.savitzky_golay(angles.direction(yaws), window)
    return filters.savitzky_golay(places, window), yaws + angles.wrap(angles.yaw_of(directions) - yaws)


def in_place(motion: Motion) -> tuple[Motion, Array]:
    """The motion without its way, and the way that it lost `(T, 3)`."""
    places, _ = way(motion)
    lost = np.pad(places - places[:1], ((0, 0), (0, 1)))
    return replace(motion, positions=motion.positions - lost), lost

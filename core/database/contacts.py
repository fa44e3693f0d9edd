"""Foot contacts: when a toe stands on the ground (paper, section 5.1)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body.motion import Motion
from ..body.toes import toe_positions
from ..maths import filters, kinematics
from ..settings import DatabaseSettings

Array = NDArray[np.floating[Any]]


def detect_contacts(motion: Motion, settings: DatabaseSettings) -> NDArray[np.bool_]:
    """Contacts `(T, 2)` of the left and the right foot, as a database with these settings gets them."""
    return find_contacts(toe_positions(motion), motion.fps, settings.contact_speed, settings.contact_window)


def find_contacts(
    toes: Array, fps: float, speed: float = 0.15, window_s: float = 13 / 60
) -> NDArray[np.bool_]:
    """Contacts `(T, 2)`: toes slower than `speed`, then the median over a window.

    Args:
        toes: `(T, 2, 3)` world positions, metres.
        fps: frames per second.
        speed: m/s, in all three dimensions, by central differences.
        window_s: length of the median filter in seconds; 13 frames at 60 frames per second.
    """
    slow = np.linalg.norm(kinematics.velocity(toes, fps), axis=-1) < speed
    return filters.median(slow, filters.odd_window(window_s, fps))


def resample_contacts(contacts: NDArray[np.bool_], fps: float, to_fps: float) -> NDArray[np.bool_]:
    """Contacts `(T, 2)` at another rate: each frame as the nearest one of `contacts`; the first frame stays."""
    if len(contacts) == 0:
        return contacts.copy()
    frames = np.arange(int((len(contacts) - 1) / fps * to_fps + 1e-6) + 1) * (fps / to_fps)
    return contacts[np.minimum((frames + 0.5).astype(np.intp), len(contacts) - 1)]

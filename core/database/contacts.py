"""Foot contacts: when a toe stands on the ground (paper, section 5.1)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..maths import filters, kinematics, quat
from ..mocap.skeleton import SIDES, Motion, Skeleton
from ..settings import DatabaseSettings

Array = NDArray[np.floating[Any]]

_TOE_OF_LEG = np.array([0.0, 0.21, -0.095])
"""From ankle to toe joint as shares of the leg's length: mean of ten people's T-poses."""


def toe_places(skeleton: Skeleton) -> tuple[NDArray[np.intp], Array]:
    """What stands for the left and the right toe on this skeleton.

    The toe joint; without one the tip of the foot, or, where that is unknown too, the place where a toe joint
    usually is.

    Returns:
        Joints `(2,)` and offsets from them `(2, 3)` in T-pose axes, metres.
    """
    joints = np.empty(2, dtype=np.intp)
    offsets = np.zeros((2, 3))
    for i, side in enumerate(SIDES):
        joints[i] = skeleton.find(f"toe.{side}")
        if joints[i] < 0:
            joints[i] = skeleton.joint(f"foot.{side}")
            tip = skeleton.tips[joints[i]]
            offsets[i] = tip if np.linalg.norm(tip) > 0.01 else _TOE_OF_LEG * skeleton.leg_length()
    return joints, offsets


def toe_positions(motion: Motion) -> Array:
    """World positions `(T, 2, 3)` of the left and the right toe, metres (see `toe_places`)."""
    return place_toes(motion.skeleton, *motion.forward())


def place_toes(skeleton: Skeleton, positions: Array, rotations: Array) -> Array:
    """The same from global joint positions `(T, J, 3)` and rotations `(T, J, 4)`."""
    joints, offsets = toe_places(skeleton)
    return positions[:, joints] + quat.rotate(rotations[:, joints], offsets)


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

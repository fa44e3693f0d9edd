"""What the motion model is told of each moment: the way of the body, and when its feet stand."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.body.motion import Motion
from ...core.maths import angles, filters, quat

Array = NDArray[np.floating[Any]]

SMOOTH_S = 0.3
"""Deviation of the bell over hips and heading: smooth enough that a script can write such a path."""
CONTACT_S = 0.05
"""Deviation of the bell over contacts."""
PATH_S = np.arange(-6, 7) / 6.0
"""Seconds around a moment at which the path is told."""
STEPS_S = np.arange(-12, 13) / 15.0
"""Seconds around a moment at which the contacts are told."""
SIZE = 5 * len(PATH_S) + 2 * len(STEPS_S)
"""Numbers per moment."""


@dataclass(frozen=True, slots=True, eq=False)
class Root:
    """The smooth way of a body; every row one frame."""

    fps: float
    places: Array
    """`(T, 2)` on the ground, metres."""
    yaws: Array
    """`(T,)` radians, without jumps."""
    heights: Array
    """`(T,)` of the hips, metres."""

    def __len__(self) -> int:
        return len(self.yaws)


def root_of(motion: Motion) -> Root:
    """The root of a motion: hips and heading under a bell of 0.3 s."""
    sigma = SMOOTH_S * motion.fps
    yaws = np.unwrap(quat.heading(motion.rotations[:, 0]))
    places = filters.gaussian(motion.positions, sigma)
    return Root(motion.fps, places[:, :2], filters.gaussian(yaws, sigma), places[:, 2])


def soft_contacts(contacts: Array | NDArray[np.bool_], fps: float) -> Array:
    """Contacts `(T, 2)`, 0 or 1, under a bell of 50 ms."""
    half = round(1.0 * fps)
    padded = np.pad(np.asarray(contacts, dtype=np.float64), ((half, half), (0, 0)), mode="edge")
    return filters.gaussian(padded, CONTACT_S * fps)[half : half + len(contacts)]


def conditions(root: Root, contacts: Array) -> Array:
    """The model's inputs `(T, SIZE)`: path in root axes, headings as sine and cosine, heights, contacts.

    Past the ends the first and the last frame go on.

    Args:
        root: T frames at a rate of which 30 is a divisor.
        contacts: `(T, 2)` from `soft_contacts`.
    """
    frames = np.arange(len(root))
    at = np.clip(frames[:, None] + np.round(PATH_S * root.fps).astype(int), 0, len(root) - 1)
    way = angles.turn(root.places[at] - root.places[:, None], -root.yaws[:, None])
    turned = root.yaws[at] - root.yaws[:, None]
    told = np.concatenate(
        [way, np.sin(turned)[..., None], np.cos(turned)[..., None], root.heights[at][..., None]], axis=-1
    )
    near = np.clip(frames[:, None] + np.round(STEPS_S * root.fps).astype(int), 0, len(root) - 1)
    return np.concatenate([told.reshape(len(root), -1), contacts[near].reshape(len(root), -1)], axis=1)


def poses_of(motion: Motion, root: Root) -> Array:
    """What the model answers of each frame, `(T, 3 + 6 J)`: hips from the root in its axes, then world rotations in
    root axes as 6-D.
    """
    _, rotations = motion.forward()
    back = quat.from_yaw(-root.yaws)
    offset = quat.rotate(back, motion.positions - np.column_stack([root.places, root.heights]))
    turned = quat.to_sixd(quat.multiply(back[:, None], rotations))
    return np.concatenate([offset, turned.reshape(len(root), -1)], axis=1)


def body_of(poses: Array, root: Root) -> tuple[Array, Array]:
    """Hips `(T, 3)` in metres and world rotations `(T, J, 4)` of what the model answers, as `poses_of` gives it."""
    ahead = quat.from_yaw(root.yaws)
    hips = np.column_stack([root.places, root.heights]) + quat.rotate(ahead, poses[:, :3])
    turned = quat.from_sixd(poses[:, 3:].reshape(len(poses), -1, 6))
    return hips, quat.continuous(quat.multiply(ahead[:, None], turned))

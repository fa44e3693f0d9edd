"""The one symmetric body of average adult proportions that the motion model moves."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.body.skeleton import SIDES, Skeleton
from ...core.body.two_bone import reach
from ...core.maths import quat

Array = NDArray[np.floating[Any]]

HEIGHT = 1.70
"""Metres; the mean of adults of both sexes in surveys of Europe and North America is 1.69 to 1.72."""
TOE_HEIGHT = 0.02
"""Metres of a standing toe joint above the floor."""

_CENTRE = (
    ("Hips", "", (0.0, 0.0, 0.94), "hips"),
    ("Chest", "Hips", (0.0, -0.005, 0.10), "spine1"),
    ("Chest2", "Chest", (0.0, 0.0, 0.10), "spine2"),
    ("Chest3", "Chest2", (0.0, 0.0, 0.095), "spine3"),
    ("Chest4", "Chest3", (0.0, 0.0, 0.095), "chest"),
    ("Neck", "Chest4", (0.0, 0.0, 0.13), "neck"),
    ("Head", "Neck", (0.0, 0.015, 0.095), "head"),
)
_LEFT = (
    ("LeftCollar", "Chest4", (-0.025, 0.0, 0.085), "clavicle.L"),
    ("LeftShoulder", "LeftCollar", (-0.145, 0.0, 0.0), "upper_arm.L"),
    ("LeftElbow", "LeftShoulder", (-0.285, 0.0, 0.0), "forearm.L"),
    ("LeftWrist", "LeftElbow", (-0.25, 0.0, 0.0), "hand.L"),
    ("LeftHip", "Hips", (-0.088, 0.0, -0.02), "thigh.L"),
    ("LeftKnee", "LeftHip", (0.0, 0.0, -0.42), "shin.L"),
    ("LeftAnkle", "LeftKnee", (0.0, 0.0, -0.41), "foot.L"),
    ("LeftToe", "LeftAnkle", (0.0, 0.135, -0.07), "toe.L"),
)
_TIPS = {"Head": (0.0, 0.0, 0.18), "LeftWrist": (-0.17, 0.0, 0.0), "LeftToe": (0.0, 0.065, -0.005)}


def starter_skeleton() -> Skeleton:
    """23 joints with Xsens names, symmetric, 1.70 m tall, metres."""
    mirror = np.array([-1.0, 1.0, 1.0])
    rows = [
        (name, above, np.array(offset), role, _tip(name)) for name, above, offset, role in (*_CENTRE, *_LEFT)
    ]
    rows += [
        (
            name.replace("Left", "Right"),
            above.replace("Left", "Right"),
            offset * mirror,
            f"{role[:-1]}R",
            tip * mirror,
        )
        for name, above, offset, role, tip in rows[len(_CENTRE) :]
    ]
    names = [row[0] for row in rows]
    return Skeleton(
        names=tuple(names),
        parents=np.array([names.index(row[1]) if row[1] else -1 for row in rows], dtype=np.intp),
        offsets=np.array([row[2] for row in rows]),
        roles=tuple(row[3] for row in rows),
        tips=np.array([row[4] for row in rows]),
    )


def _tip(name: str) -> Array:
    return np.array(_TIPS.get(name, (0.0, 0.0, 0.0)))


def ankle_of(skeleton: Skeleton, side: str, toe: Array, foot: Array) -> Array:
    """Ankles `(T, 3)` of toe joints `(T, 3)` and world rotations of the foot `(T, 4)`, metres."""
    return toe - quat.rotate(foot, skeleton.offsets[skeleton.joint(f"toe.{side}")])


def put_ankles(skeleton: Skeleton, positions: Array, rotations: Array, ankles: Array) -> Array:
    """World rotations `(T, J, 4)` with thighs and shins turned so that the ankles come to their places.

    The knees keep the direction that they look in.

    Args:
        skeleton: of the body.
        positions: `(T, J, 3)` joints, metres; only those of the thighs are used, the rest follows the rotations.
        rotations: `(T, J, 4)` world rotations since T-pose; feet keep theirs.
        ankles: `(T, 2, 3)` left, right, metres.
    """
    out = np.array(rotations)
    for side, letter in enumerate(SIDES):
        thigh, shin, foot = (skeleton.joint(f"{part}.{letter}") for part in ("thigh", "shin", "foot"))
        knee = positions[:, thigh] + quat.rotate(rotations[:, thigh], skeleton.offsets[shin])
        end = knee + quat.rotate(rotations[:, shin], skeleton.offsets[foot])
        limb = np.stack([positions[:, thigh], knee, end], axis=1)
        # the knee cap looks along +Y of thigh and shin; a straight knee is told apart by it alone
        cap = quat.rotate(rotations[:, thigh], np.array([0.0, 1.0, 0.0]))
        out[:, [thigh, shin]], _ = reach(limb, rotations[:, [thigh, shin]], ankles[:, side], cap, cap)
    return out

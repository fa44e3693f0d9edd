"""Legs that are straight, or bent the wrong way by a hair, on a body whose sides differ: each knee bends forward.

A real leg at rest is straight to within a centimetre, and which way it is bent then says nothing.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.database.contacts import toe_positions
from footwork.core.database.variants import at_body_height
from footwork.core.mocap.skeleton import SIDES, Motion, Skeleton
from footwork.core.rig.feet import place_feet, plan_feet
from scipy.spatial.transform import Rotation

FRAMES = 120
YAW, TURNED_OUT = 2.3, (0.45, -0.8)
"""Radians: heading of the body, and of each leg from there."""


def quaternions(turns: Rotation) -> np.ndarray:
    return np.roll(turns.as_quat(), 1, axis=-1)


def standing(skeleton: Skeleton, bends: tuple[float, float]) -> Motion:
    """A body that stands on legs turned out, their knees bent by so many radians, negative to the back."""
    rotations = np.tile([1.0, 0.0, 0.0, 0.0], (FRAMES, len(skeleton), 1))
    rotations[:, 0] = quaternions(Rotation.from_euler("z", YAW))
    for side, out, bend in zip(SIDES, TURNED_OUT, bends, strict=True):
        thigh = Rotation.from_euler("z", out) * Rotation.from_euler("x", 0.5 * bend)
        rotations[:, skeleton.joint(f"thigh.{side}")] = quaternions(thigh)
        rotations[:, skeleton.joint(f"shin.{side}")] = quaternions(Rotation.from_euler("x", -bend))
        rotations[:, skeleton.joint(f"foot.{side}")] = quaternions(Rotation.from_euler("x", 0.5 * bend))
    return Motion(skeleton, 60.0, np.tile([0.4, -0.7, skeleton.offsets[0, 2]], (FRAMES, 1)), rotations)


def straight(skeleton: Skeleton) -> Skeleton:
    """The body with legs along one line, as rigs have them."""
    offsets = skeleton.offsets.copy()
    for side in SIDES:
        for part in ("shin", "foot"):
            joint = skeleton.joint(f"{part}.{side}")
            offsets[joint] = [0.0, 0.0, -np.linalg.norm(offsets[joint])]
    return replace(skeleton, offsets=offsets)


def forward_bends(motion: Motion) -> np.ndarray:
    """Metres `(T, 2)` by which each knee lies before the line from hip to ankle, along its own leg's heading."""
    positions, _ = motion.forward()
    out = np.empty((len(motion), 2))
    for i, side in enumerate(SIDES):
        hip, knee, ankle = (
            positions[:, motion.skeleton.joint(f"{part}.{side}")] for part in ("thigh", "shin", "foot")
        )
        line = (ankle - hip) / np.linalg.norm(ankle - hip, axis=-1, keepdims=True)
        bend = knee - hip - np.sum((knee - hip) * line, axis=-1, keepdims=True) * line
        heading = YAW + TURNED_OUT[i]
        out[:, i] = bend @ np.array([-np.sin(heading), np.cos(heading), 0.0])
    return out


@pytest.mark.parametrize("bends", [(0.0, 0.0), (-0.03, 0.05), (0.02, -0.04), (-0.02, -0.03)])
@pytest.mark.parametrize("legs", ["straight", "unequal"])
def test_each_knee_bends_the_way_its_own_leg_looks(unequal, legs: str, bends: tuple[float, float]) -> None:
    body = standing(straight(unequal()) if legs == "straight" else unequal(), bends)
    drop = np.linspace(0.02, 0.15, FRAMES)
    lowered = replace(body, positions=body.positions - drop[:, None] * np.array([0.0, 0.0, 1.0]))
    plan = plan_feet(body, np.ones((FRAMES, 2), np.bool_), 0.2, 0.1, lowered)
    placed = place_feet(lowered, plan)
    bent = forward_bends(placed)
    assert (bent > 0.06).all()
    # what lies aside of the leg's heading is little: a knee bends over its foot
    length = np.linalg.norm(plan.toes - toe_positions(placed), axis=-1)
    assert length.max() < 1e-3


@pytest.mark.parametrize("bends", [(0.0, 0.0), (-0.03, 0.05), (0.02, -0.04)])
@pytest.mark.parametrize("share", [0.985, 0.93, 0.75])
def test_knees_of_derived_crouches_bend_forward(unequal, share: float, bends: tuple[float, float]) -> None:
    body = standing(straight(unequal()), bends)
    height = float(body.forward()[0][0, body.skeleton.joint("head"), 2])
    crouched = at_body_height(body, np.ones((FRAMES, 2), np.bool_), share, height)
    assert (forward_bends(crouched) > 0.02).all()

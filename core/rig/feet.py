"""Feet on the ground: one lock per contact, toes above the floor, legs solved to them (paper, section 6.2).

The whole motion is known, so a foot comes to its lock and leaves it while it is in the air: through a
contact the toe stands still, and the offset that this takes is carried from one contact to the next by a
curve that keeps the toe's velocity continuous.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..database.contacts import toe_places
from ..maths import quat
from ..mocap.skeleton import SIDES, Motion, Skeleton
from . import heel, locks, two_bone
from .pose import with_world_rotations

Array = NDArray[np.floating[Any]]

_SOFT_KNEE = 0.03
"""Metres: a leg bent by less takes the plane of its knee from the shin's own axes."""
_TIP = 0.5
"""Length of a toe whose end is unknown, as a share of the way over the ground from ankle to toe joint."""
_FORWARD = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True, slots=True, eq=False)
class FootPlan:
    """Where the feet go, whatever happens to the hips."""

    toes: Array
    """`(T, 2, 3)` world positions of the toes, metres (see `core.database.contacts.toe_places`)."""
    rotations: Array
    """`(T, 2, 4)` world rotations of the foot joints before heels rise."""
    contacts: NDArray[np.bool_]
    """`(T, 2)` frames in which the toe stands still."""


def plan_feet(
    motion: Motion,
    contacts: NDArray[np.bool_],
    unlock_distance: float,
    halflife: float,
    thighs: Array | None = None,
) -> FootPlan:
    """Where the feet of a motion go once they are locked to the floor.

    Each contact holds the toe at the middle of where the motion has it, at the toe joint's own height over
    the floor, and nearer to the body where the leg would not reach it. Where the motion leaves that point
    by more than `unlock_distance` the foot is let go and follows with a step.

    Args:
        motion: metres, the floor at Z = 0.
        contacts: `(T, 2)` left, right foot on the ground.
        unlock_distance: metres.
        halflife: seconds in which half of a lock's offset is gone when the foot is in the air for long.
        thighs: `(T, 2, 3)` where the thigh joints will be, metres; where the motion has them by default.
    """
    positions, rotations = motion.forward()
    skeleton = motion.skeleton
    joints, shifts = toe_places(skeleton)
    toes = positions[:, joints] + quat.rotate(rotations[:, joints], shifts)
    feet = [skeleton.joint(f"foot.{side}") for side in SIDES]
    hips = positions[:, [skeleton.joint(f"thigh.{side}") for side in SIDES]] if thighs is None else thighs
    body = _Feet(skeleton)
    held = np.zeros_like(contacts)
    blend = max(2, round(4.0 * halflife * motion.fps))
    for i in range(2):
        path, height = toes[:, i], float(body.heights[i])
        found = locks.find_locks(path, contacts[:, i], height, unlock_distance, motion.fps)
        pitch = heel.pitch_of(rotations[:, feet[i]], body.to_toe[i])
        found = [_within_reach(lock, pitch, hips[:, i], heel.longest(body.lengths[i])) for lock in found]
        for lock in found:
            held[lock.first : lock.last + 1, i] = True
        path += locks.offsets(path, found, blend)
        path[:, 2] = height + locks.clear(path[:, 2] - height, held[:, i], motion.fps)
    return FootPlan(toes, rotations[:, feet], held)


def place_feet(motion: Motion, plan: FootPlan) -> Motion:
    """`motion` with its legs solved to the feet of a plan, wherever its hips are.

    A foot keeps its orientation but for two things: its heel does not sink into the floor, and it rises
    where the leg would be too short. A toe bends where its tip would sink into the floor. A leg that is
    still too short is straight towards the toe.
    """
    positions, rotations = motion.forward()
    skeleton = motion.skeleton
    body = _Feet(skeleton)
    wanted: dict[int, Array] = {}
    for i, side in enumerate(SIDES):
        thigh, shin, foot = (skeleton.joint(f"{part}.{side}") for part in ("thigh", "shin", "foot"))
        toes, height, limb = plan.toes[:, i], float(body.heights[i]), positions[:, [thigh, shin, foot]]
        turned = heel.raise_heel(
            plan.rotations[:, i], body.to_toe[i], height, toes, limb[:, 0], body.lengths[i], motion.fps
        )
        ankles = toes - quat.rotate(turned, body.to_toe[i])
        bend = two_bone.bend_direction(limb, quat.rotate(rotations[:, shin], _FORWARD), _SOFT_KNEE)
        swing = quat.between(limb[:, 2] - limb[:, 0], ankles - limb[:, 0])
        solved, _ = two_bone.reach(limb, rotations[:, [thigh, shin]], ankles, bend, quat.rotate(swing, bend))
        wanted |= {thigh: solved[:, 0], shin: solved[:, 1], foot: turned}
        toe = skeleton.find(f"toe.{side}")
        if toe >= 0:
            # the toe keeps its bend against the foot
            bent = quat.multiply(quat.conjugate(rotations[:, foot]), rotations[:, toe])
            bent = quat.multiply(turned, bent)
            wanted[toe] = heel.raise_tip(bent, body.tips[i], toes[:, 2], height)
    return with_world_rotations(motion, wanted)


class _Feet:
    """Measures of both feet and legs in T-pose, metres."""

    def __init__(self, skeleton: Skeleton) -> None:
        joints, shifts = toe_places(skeleton)
        standing = skeleton.tpose_positions()
        toes = standing[joints] + shifts
        feet = [skeleton.joint(f"foot.{side}") for side in SIDES]
        legs = [
            standing[[skeleton.joint(f"{part}.{side}") for part in ("thigh", "shin", "foot")]]
            for side in SIDES
        ]
        self.to_toe: Array = toes - standing[feet]
        """`(2, 3)` from foot joint to toe."""
        self.heights: Array = np.maximum(toes[:, 2], 0.0)
        """`(2,)` of the toes over the floor."""
        self.lengths = [float(np.linalg.norm(np.diff(leg, axis=0), axis=-1).sum()) for leg in legs]
        """Of the two legs."""
        known = np.linalg.norm(skeleton.tips[joints], axis=-1, keepdims=True) > 5e-3
        self.tips: Array = np.where(known, skeleton.tips[joints], _TIP * self.to_toe[:, 1:2] * _FORWARD)
        """`(2, 3)` from toe joint to the end of the toe."""


def _within_reach(lock: locks.Lock, pitch: heel.Pitch, hips: Array, length: float) -> locks.Lock:
    """The lock, moved over the ground towards the body until the leg reaches it through the whole contact."""
    span = slice(lock.first, lock.last + 1)
    part = heel.Pitch(
        pitch.back[span], pitch.right[span], pitch.angle[span], pitch.radius[span], pitch.aside[span]
    )
    point = lock.point.copy()
    # each turn mends the worst frame; frames that pull opposite ways settle between
    for _ in range(8):
        way = hips[span] - point
        excess = part.nearest(hips[span], point) - length
        worst = int(np.argmax(excess))
        level = float(np.linalg.norm(way[worst, :2]))
        if excess[worst] <= 0.0 or level < 1e-3:
            break
        step = min(float(excess[worst] * np.linalg.norm(way[worst])) / level, level)
        point[:2] += way[worst, :2] * (step / level)
    return replace(lock, point=point)

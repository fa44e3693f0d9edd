"""Feet on the ground: one lock per contact, toes above the floor, legs solved to them (paper, section 6.2).

The whole motion is known, so a foot comes to its lock and leaves it while it is in the air: through a
contact the toe stands still, and the offset that this takes is carried from one contact to the next by a
curve that keeps the toe's velocity continuous.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from ..database.contacts import toe_places
from ..maths import filters, quat
from ..mocap.skeleton import SIDES, Motion, Skeleton
from . import two_bone
from .pose import with_world_rotations

Array = NDArray[np.floating[Any]]

_STEP_S = 0.25
"""Length of the step by which a foot follows a motion that left its lock behind."""
_LIFT = 0.12
"""Height of such a step over its length."""
_SHORTEST_S = 0.1
"""A contact shorter than this holds no foot."""
_STRAIGHT = 0.998
"""Share of a leg's length to which it is stretched before the heel rises."""
_STEEPEST = np.radians(75.0)
"""Greatest pitch of a foot standing on its toes."""
_HEEL = 1.35
"""Distance over the ground from toe to heel as a multiple of that from toe to ankle."""
_PEAK_S = 0.03
"""Seconds over which a heel's rise is smoothed."""
_SOFT_KNEE = 0.03
"""Metres: a leg bent by less takes the plane of its knee from the thigh's own axes."""


@dataclass(frozen=True, slots=True, eq=False)
class FootPlan:
    """Where the feet go, whatever happens to the hips."""

    toes: Array
    """`(T, 2, 3)` world positions of the toes, metres (see `core.database.contacts.toe_places`)."""
    rotations: Array
    """`(T, 2, 4)` world rotations of the foot joints before heels rise."""
    contacts: NDArray[np.bool_]
    """`(T, 2)` frames in which the toe stands still."""


def lock_feet(
    motion: Motion, contacts: NDArray[np.bool_], unlock_distance: float, halflife: float
) -> tuple[Motion, NDArray[np.bool_]]:
    """`motion` with its feet on the ground, and the contacts `(T, 2)` in which they stand still.

    See `plan_feet` and `place_feet`, which do the two halves.
    """
    plan = plan_feet(motion, contacts, unlock_distance, halflife)
    return place_feet(motion, plan), plan.contacts


def plan_feet(
    motion: Motion, contacts: NDArray[np.bool_], unlock_distance: float, halflife: float
) -> FootPlan:
    """Where the feet of a motion go once they are locked to the floor.

    Each contact holds the toe at the middle of where the motion has it, at the toe joint's own height over
    the floor. Where the motion leaves that point by more than `unlock_distance` the foot is let go and
    follows with a step.

    Args:
        motion: metres, the floor at Z = 0.
        contacts: `(T, 2)` left, right foot on the ground.
        unlock_distance: metres.
        halflife: seconds in which half of a lock's offset is gone when the foot is in the air for long.
    """
    positions, rotations = motion.forward()
    joints, offsets = toe_places(motion.skeleton)
    toes = positions[:, joints] + quat.rotate(rotations[:, joints], offsets)
    heights = _toe_heights(motion.skeleton)
    held = np.zeros_like(contacts)
    for foot in range(2):
        path = toes[:, foot]
        locks = _find_locks(path, contacts[:, foot], heights[foot], unlock_distance, motion.fps)
        for lock in locks:
            held[lock.first : lock.last + 1, foot] = True
        path += _offsets(path, locks, max(2, round(4.0 * halflife * motion.fps)))
        path[:, 2] = np.maximum(path[:, 2], heights[foot])
    feet = [motion.skeleton.joint(f"foot.{side}") for side in SIDES]
    return FootPlan(toes, rotations[:, feet], held)


def place_feet(motion: Motion, plan: FootPlan) -> Motion:
    """`motion` with its legs solved to the feet of a plan, wherever its hips are.

    A foot keeps its orientation but for two things: its heel does not sink into the floor, and it rises
    where the leg would be too short. A toe bends where its tip would sink into the floor. A leg that is
    still too short is straight towards the toe.
    """
    positions, rotations = motion.forward()
    skeleton = motion.skeleton
    wanted: dict[int, Array] = {}
    for i, side in enumerate(SIDES):
        thigh, shin, foot = (skeleton.joint(f"{part}.{side}") for part in ("thigh", "shin", "foot"))
        limb = positions[:, [thigh, shin, foot]]
        turned = _raise_heel(motion, i, limb[:, 0], plan)
        ankles = plan.toes[:, i] - quat.rotate(turned, _foot_to_toe(skeleton)[i])
        knee = quat.rotate(rotations[:, shin], np.array([0.0, 1.0, 0.0]))
        bend = two_bone.bend_direction(limb, knee, _SOFT_KNEE)
        line = limb[:, 2] - limb[:, 0], ankles - limb[:, 0]
        aim = quat.rotate(quat.between(*line), bend)
        solved, _ = two_bone.reach(limb, rotations[:, [thigh, shin]], ankles, bend, aim)
        wanted |= {thigh: solved[:, 0], shin: solved[:, 1], foot: turned}
        toe = skeleton.find(f"toe.{side}")
        if toe >= 0:
            local = quat.multiply(quat.conjugate(rotations[:, foot]), rotations[:, toe])
            bent = quat.multiply(turned, local)
            wanted[toe] = _raise_tip(
                bent, skeleton.tips[toe], plan.toes[:, i, 2], skeleton.tpose_positions()[toe, 2]
            )
    return with_world_rotations(motion, wanted)


@dataclass(frozen=True, slots=True)
class _Lock:
    """A toe held at a point from its first to its last frame, both included."""

    first: int
    last: int
    point: Array
    steps: bool
    """Whether the foot comes here by a step of its own from the lock before."""


def _find_locks(
    path: Array, contacts: NDArray[np.bool_], height: float, unlock_distance: float, fps: float
) -> list[_Lock]:
    """The locks of one foot whose toe the motion has at `path` `(T, 3)`."""
    shortest, step = max(2, round(_SHORTEST_S * fps)), max(2, round(_STEP_S * fps))
    edges = np.flatnonzero(np.diff(contacts.astype(np.int8), prepend=0, append=0))
    locks: list[_Lock] = []
    for first, stop in edges.reshape(-1, 2).tolist():
        begin, steps = first, False
        while stop - begin >= shortest:
            piece = path[begin:stop]
            low, high = np.minimum.accumulate(piece), np.maximum.accumulate(piece)
            middle = 0.5 * (low + high)
            middle[:, 2] = height
            far = np.linalg.norm(np.maximum(high - middle, middle - low), axis=-1) > unlock_distance
            count = int(np.argmax(far)) if far.any() else len(piece)
            if count >= shortest:
                locks.append(_Lock(begin, begin + count - 1, middle[count - 1], steps))
            steps = count >= shortest
            begin += max(count, 1) - 1 + step
    return locks


def _offsets(path: Array, locks: list[_Lock], blend: int) -> Array:
    """What to add to a toe's path `(T, 3)`: the way to the lock where it is held, smooth curves between."""
    out = np.zeros_like(path)
    slope = -np.gradient(path, axis=0) if len(path) > 1 else np.zeros_like(path)
    zero = np.zeros(3)
    before: _Lock | None = None
    for lock in locks:
        span = slice(lock.first, lock.last + 1)
        out[span] = lock.point - path[span]
        ends = out[lock.first], slope[lock.first]
        if before is None or lock.first - before.last > 2 * blend:
            _curve(out, lock.first - blend, lock.first, (zero, zero), ends)
            if before is not None:
                _curve(
                    out,
                    before.last,
                    before.last + blend,
                    (out[before.last], slope[before.last]),
                    (zero, zero),
                )
        else:
            _curve(out, before.last, lock.first, (out[before.last], slope[before.last]), ends)
            if lock.steps:
                place = np.linspace(0.0, 1.0, lock.first - before.last + 1)
                rise = _LIFT * np.linalg.norm(lock.point - before.point)
                out[before.last : lock.first + 1, 2] += rise * (4.0 * place * (1.0 - place)) ** 2
        before = lock
    if before is not None:
        _curve(out, before.last, before.last + blend, (out[before.last], slope[before.last]), (zero, zero))
    return out


def _curve(out: Array, first: int, last: int, start: tuple[Array, Array], end: tuple[Array, Array]) -> None:
    """Write the cubic between two values with given slopes per frame into the frames between `first` and
    `last`."""
    frames = np.arange(max(first + 1, 0), min(last, len(out)))
    t = ((frames - first) / (last - first))[:, None]
    length = float(last - first)
    out[frames] = (
        (1.0 + 2.0 * t) * (1.0 - t) ** 2 * start[0]
        + length * t * (1.0 - t) ** 2 * start[1]
        + t**2 * (3.0 - 2.0 * t) * end[0]
        + length * t**2 * (t - 1.0) * end[1]
    )


def _foot_to_toe(skeleton: Skeleton) -> Array:
    """From foot joint to toe `(2, 3)` in T-pose, metres."""
    joints, offsets = toe_places(skeleton)
    positions = skeleton.tpose_positions()
    feet = [skeleton.joint(f"foot.{side}") for side in SIDES]
    return positions[joints] + offsets - positions[feet]


def _toe_heights(skeleton: Skeleton) -> Array:
    """Height `(2,)` of the toes over the floor in T-pose, metres."""
    joints, offsets = toe_places(skeleton)
    return np.maximum(skeleton.tpose_positions()[joints, 2] + offsets[:, 2], 0.0)


def _raise_heel(motion: Motion, foot: int, hips: Array, plan: FootPlan) -> Array:
    """World rotations `(T, 4)` of a foot, pitched about its toe for heel and leg.

    In the upright plane through ankle and toe the ankle lies at angle a on a circle of radius r about the
    toe. With w from the toe to the thigh joint, the leg is no longer than L where w.(cos a, sin a) >= (w^2
    + r^2 - L^2) / 2r.
    """
    skeleton, given = motion.skeleton, plan.rotations[:, foot]
    away = -quat.rotate(given, _foot_to_toe(skeleton)[foot])
    back = away * np.array([1.0, 1.0, 0.0])
    level = np.linalg.norm(back, axis=-1)
    back = two_bone.unit(back)
    angle = np.arctan2(away[:, 2], level)
    lowest = _heel_pitch(skeleton, foot, plan.toes[:, foot, 2])

    side = SIDES[foot]
    length = sum(
        float(np.linalg.norm(skeleton.offsets[skeleton.joint(f"{part}.{side}")])) for part in ("shin", "foot")
    )
    radius = np.linalg.norm(away, axis=-1)
    w = hips - plan.toes[:, foot]
    along, up = np.sum(w * back, axis=-1), w[:, 2]
    needed = (np.sum(w * w, axis=-1) + radius**2 - (_STRAIGHT * length) ** 2) / (2.0 * radius)
    best = np.arctan2(up, along)
    short = best - np.arccos(np.clip(needed / np.maximum(np.hypot(along, up), 1e-9), -1.0, 1.0))
    wanted = np.minimum(np.maximum(lowest, short), np.maximum(angle, _STEEPEST))
    lift = _smooth_peaks(np.maximum(wanted - angle, 0.0), motion.fps)
    axis = np.stack([-back[:, 1], back[:, 0], np.zeros(len(back))], axis=-1)
    return quat.multiply(quat.from_rotation_vector(-axis * lift[:, None]), given)


def _heel_pitch(skeleton: Skeleton, foot: int, toe_heights: Array) -> Array:
    """Least angle `(T,)` of the ankle about the toe that keeps the heel, behind and below the ankle, off
    the floor."""
    _, back, up = _foot_to_toe(skeleton)[foot]
    rest = float(_toe_heights(skeleton)[foot])
    reach = _HEEL * back
    sine = np.clip(-toe_heights / np.hypot(reach, rest), -1.0, 1.0)
    return np.arctan2(-up, back) + np.arcsin(sine) + np.arctan2(rest, reach)


def _smooth_peaks(values: Array, fps: float) -> Array:
    """A smooth curve `(T,)` on or above non-negative `values`, which rises before and falls after them."""
    sigma = _PEAK_S * fps
    half = int(np.ceil(4.0 * sigma))
    if not values.any() or half == 0:
        return values
    widest = sliding_window_view(np.pad(values, half, mode="edge"), 2 * half + 1).max(axis=-1)
    return filters.gaussian(widest, sigma)


def _raise_tip(toe: Array, tip: Array, heights: Array, rest_height: float) -> Array:
    """World rotations `(T, 4)` of a toe, bent up where its tip would be lower than in T-pose.

    Args:
        toe: `(T, 4)` world rotations.
        tip: `(3,)` from the toe joint to the end of its bone in T-pose, metres; zero where unknown.
        heights: `(T,)` of the toe joint, metres.
        rest_height: of the toe joint in T-pose, metres.
    """
    if np.linalg.norm(tip) < 5e-3:
        return toe
    right = quat.rotate(toe, np.array([1.0, 0.0, 0.0])) * np.array([1.0, 1.0, 0.0])
    right = two_bone.unit(right)
    forward = np.stack([-right[:, 1], right[:, 0], np.zeros(len(right))], axis=-1)
    end = quat.rotate(toe, tip)
    along = np.sum(end * forward, axis=-1)
    lowest = max(rest_height + float(tip[2]), 0.0) - heights
    needed = np.arcsin(np.clip(lowest / np.maximum(np.hypot(along, end[:, 2]), 1e-9), -1.0, 1.0))
    lift = np.maximum(needed - np.arctan2(end[:, 2], along), 0.0)
    return quat.multiply(quat.from_rotation_vector(right * lift[:, None]), toe)

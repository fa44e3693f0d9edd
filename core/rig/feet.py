"""Feet on the ground: planted in contacts, toes above the floor, legs solved to them (paper, section 6.2).

The whole motion is known, so a foot comes to its lock and leaves it while it is in the air: through a
contact the toe stands still, and the offset that this takes is carried from one contact to the next by a
curve that keeps the toe's velocity continuous.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body import heel, two_bone
from ..body.legs import Leg, legs_of
from ..body.motion import Motion
from ..body.pose import with_world_rotations, world_poses
from ..maths import filters, quat
from ..maths.easing import smoothstep
from ..maths.vectors import across, dot, level, norm, unit
from ..settings import BakeSettings
from . import apart, footsteps, locks

Array = NDArray[np.floating[Any]]
Flags = NDArray[np.bool_]

_SOFT_KNEE = 0.03
"""Metres: a leg bent by less takes the plane of its knee from the shin's own axes."""
_SQUAT, _SEATED = 0.5, 0.2
"""Heights of the thigh joint over the floor as a share of the leg's length between which knees come to point up."""
_KNEES_UP, _ASIDE, _KNEES_S = 2.0, 0.5, 0.12
"""Where between those they are up, say of outward beside that, and standard deviation in seconds of the smoothing."""
_SOFT_PULL = 0.01
"""Metres over which a foot in the air that would be out of reach begins to be pulled in."""
_FOLLOW, _SOFT_RISE = 0.5, 0.02
"""Share by which a foot in the air follows hips that are higher than the motion's, and metres over which that
begins."""
_FREE_S = 0.2
"""Seconds after a foot leaves the floor, and before it is back, in which both begin and end."""
_AROUND_S = 0.08
"""The same for the way around the other leg, which is nearest soon before a foot comes down."""
_OUTWARD = np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
_FORWARD, _UP = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, slots=True, eq=False)
class FootPlan:
    """Where the feet go, whatever happens to the hips."""

    toes: Array
    """`(T, 2, 3)` world positions of the toes, metres (see `core.database.contacts.toe_places`)."""
    rotations: Array
    """`(T, 2, 4)` world rotations of the foot joints before heels rise to reach them."""
    contacts: Flags
    """`(T, 2)` frames in which the foot is on the ground."""
    heights: Array | None = None
    """`(T, 2)` metres by which the ground of a scene is above the floor under each foot; None for a flat floor."""
    tilts: Array | None = None
    """`(T, 2, 4)` its slope there: rotations from upright."""


def plant_feet(motion: Motion, contacts: Flags, settings: BakeSettings, body: Motion) -> FootPlan:
    """Feet locked to the floor while they touch it.

    Args:
        motion: metres, the floor at Z = 0.
        contacts: `(T, 2)` left, right foot on the ground.
        settings: `unlock_distance` and `halflife` are used.
        body: the motion whose hips the legs will hang from.
    """
    return plan_feet(motion, contacts, settings.unlock_distance, settings.halflife, body)


def follow_feet(motion: Motion, contacts: Flags, settings: BakeSettings, body: Motion) -> FootPlan:
    """Feet as the motion has them, but above the floor and within reach; arguments as for `plant_feet`."""
    free = np.zeros_like(contacts)
    plan = plan_feet(motion, free, settings.unlock_distance, settings.halflife, body)
    return replace(plan, contacts=contacts)


def plan_feet(
    motion: Motion,
    contacts: Flags,
    unlock_distance: float,
    halflife: float,
    body: Motion | None = None,
) -> FootPlan:
    """Where the feet of a motion go once they are locked to the floor.

    Each contact holds the toe near where the motion has it, at the toe joint's own height over the floor,
    and nearer to the body where the leg would not reach it. Where one place cannot be within
    `unlock_distance` of all of a contact the foot makes steps of its own.

    Args:
        motion: metres, the floor at Z = 0.
        contacts: `(T, 2)` left, right foot on the ground.
        unlock_distance: metres.
        halflife: seconds in which half of a lock's offset is gone when the foot is in the air for long.
        body: the motion whose hips the legs will hang from; `motion` by default.
    """
    skeleton = motion.skeleton
    legs = legs_of(skeleton)
    body = motion if body is None else body
    hips, _ = world_poses(body, [leg.thigh for leg in legs])
    positions, rotations = world_poses(motion, [leg.end for leg in legs])
    paths = [positions[leg.end] + quat.rotate(rotations[leg.end], leg.shift) for leg in legs]
    plants = footsteps.plan_plants(paths, contacts, _loads(hips, paths, legs), unlock_distance, motion.fps)
    pitches = [heel.pitch_of(rotations[leg.foot], leg.to_toe) for leg in legs]
    made: list[list[locks.Lock]] = []
    for side, (leg, path) in enumerate(zip(legs, paths, strict=True)):
        stands = contacts[:, side]
        found = locks.make_locks(path, plants[side], stands, leg.height, unlock_distance, motion.fps)
        found = _within_reach(found, pitches[side], hips[leg.thigh], leg)
        made.append(locks.give_time(path, found, stands, motion.fps))
    ankles = -np.stack([quat.rotate(rotations[leg.foot], leg.to_toe) for leg in legs], axis=1)
    yaws, length = quat.heading(body.rotations[:, 0]), skeleton.leg_length()
    apart_there = apart.spread_plants((made[0], made[1]), ankles, yaws, length)
    held, free = np.zeros_like(contacts), np.empty(contacts.shape)
    for side, (leg, path, found) in enumerate(zip(legs, paths, apart_there, strict=True)):
        for lock in found:
            held[lock.first : lock.last + 1, side] = True
        free[:, side] = _freedom(held[:, side], _FREE_S * motion.fps)
        path += locks.offsets(path, found, halflife, motion.fps)
        # hips that are higher than the motion's take a foot in the air along
        rise = np.maximum((hips[leg.thigh] - positions[leg.thigh])[:, 2], 0.0)
        path[:, 2] += _FOLLOW * rise**2 / (rise + _SOFT_RISE) * free[:, side]
        path += _pull(path, pitches[side], hips[leg.thigh], leg) * free[:, side, None]
    air = np.stack([_freedom(side, _AROUND_S * motion.fps) for side in held.T], axis=1)
    apart.step_around(paths, ankles, air, yaws, length, motion.fps)
    feet: list[Array] = []
    for leg, path, found, pitch in zip(legs, paths, apart_there, pitches, strict=True):
        path[:, 2] = leg.height + locks.clear(path[:, 2] - leg.height, found, motion.fps)
        heel_up = quat.from_rotation_vector(-pitch.right * locks.tilt(found, len(motion))[:, None])
        feet.append(quat.multiply(heel_up, rotations[leg.foot]))
    return FootPlan(np.stack(paths, axis=1), np.stack(feet, axis=1), held)


def level_soles(plan: FootPlan, legs: Sequence[Leg], soles: Array) -> FootPlan:
    """The plan with its feet turned about their toes so that they stand flat where they are pitched by `soles`
    `(T, 2)` radians."""
    turned = [
        heel.lowered(plan.rotations[:, side], leg.to_toe, soles[:, side]) for side, leg in enumerate(legs)
    ]
    return replace(plan, rotations=np.stack(turned, axis=1))


def place_feet(motion: Motion, plan: FootPlan) -> Motion:
    """`motion` with its legs solved to the feet of a plan, wherever its hips are.

    A foot keeps its orientation but for two things: its heel does not sink into the floor, and it rises
    where the leg would be too short. A toe bends where its tip would sink into the floor. A leg that is
    still too short is straight towards the toe. On the ground of a scene all this is done as if upright was
    across the slope, the toe as high over the slope as the plan has it over the floor.
    """
    legs = legs_of(motion.skeleton)
    positions, rotations = world_poses(motion, [leg.end for leg in legs])
    floor = _UP * (0.0 if plan.heights is None else plan.heights.mean(axis=1)[:, None])
    wanted: dict[int, Array] = {}
    for side, leg in enumerate(legs):
        toes, hips = plan.toes[:, side], positions[leg.thigh]
        over, upright = toes, hips
        if plan.heights is not None and plan.tilts is not None:
            toes = toes + plan.heights[:, side, None] * _UP
            upright = over + quat.rotate(quat.conjugate(plan.tilts[:, side]), hips - toes)
        own = norm(positions[leg.foot] - hips)
        foot = heel.raise_heel(
            plan.rotations[:, side], leg.to_toe, leg.height, over, upright, leg.length, own, motion.fps
        )
        bent = quat.multiply(quat.conjugate(rotations[leg.foot]), rotations[leg.end])
        tip = heel.raise_tip(quat.multiply(foot, bent), leg.tip, over[:, 2], leg.height)
        if plan.tilts is not None:
            foot, tip = (quat.multiply(plan.tilts[:, side], turn) for turn in (foot, tip))
        ankles = toes - quat.rotate(foot, leg.to_toe)
        limb = np.stack([hips, positions[leg.shin], positions[leg.foot]], axis=1)
        bend = two_bone.bend_direction(limb, quat.rotate(rotations[leg.shin], _FORWARD), _SOFT_KNEE)
        aim = quat.rotate(quat.between(limb[:, 2] - hips, ankles - hips), bend)
        ahead, aside = (quat.rotate(motion.rotations[:, 0], way) for way in (_FORWARD, _OUTWARD[side]))
        aim = _knees_up(aim, ahead, aside, ankles - hips, (hips - floor)[:, 2] / leg.length, motion.fps)
        bones = np.stack([rotations[leg.thigh], rotations[leg.shin]], axis=1)
        bones, _ = two_bone.reach(limb, bones, ankles, bend, aim)
        wanted |= {leg.thigh: bones[:, 0], leg.shin: bones[:, 1], leg.foot: foot}
        if leg.end != leg.foot:
            wanted[leg.end] = tip
    return with_world_rotations(motion, wanted)


def _knees_up(aim: Array, ahead: Array, aside: Array, way: Array, height: Array, fps: float) -> Array:
    """Where knees shall lie `(T, 3)`: as `aim` `(T, 3)` says, but up for thighs that are near the floor.

    Args:
        aim: seen from the line from thigh to ankle.
        ahead: `(T, 3)` where the hips look, unit vectors: knees that go up come from there.
        aside: `(T, 3)` outward, unit vectors.
        way: `(T, 3)` from thigh joint to ankle.
        height: `(T,)` of the thigh joint over the floor, leg lengths.
        fps: frames per second.
    """
    low = smoothstep(np.clip((_SQUAT - height) / (_SQUAT - _SEATED), 0.0, 1.0))[:, None]
    if not low.any():
        return aim
    line = unit(way)
    goal = filters.gaussian(level(ahead) + _UP + _ASIDE * aside, _KNEES_S * fps)
    goal = unit(across(goal, line))
    soft = np.minimum(_KNEES_UP * low, 1.0)
    return (1.0 - soft) * unit(across(aim, line)) + soft * goal


def _within_reach(found: list[locks.Lock], pitch: heel.Pitch, hips: Array, leg: Leg) -> list[locks.Lock]:
    """The locks, moved over the ground towards the body until the leg reaches them through the whole contact."""
    if not found:
        return found
    points = np.stack([lock.point for lock in found])
    best, least = points.copy(), np.full(len(found), np.inf)
    going = np.arange(len(found))
    # early and late frames may pull opposite ways: ever smaller steps settle between them
    for turn in range(12):
        counts = np.array([found[i].last - found[i].first + 1 for i in going])
        starts = np.cumsum(counts) - counts
        frames = np.concatenate([np.arange(found[i].first, found[i].last + 1) for i in going])
        excess = pitch.cut(frames).nearest(hips[frames], np.repeat(points[going], counts, axis=0))
        excess -= heel.longest(leg.length)
        most = np.maximum.reduceat(excess, starts)
        better = most < least[going]
        best[going[better]], least[going[better]] = points[going[better]], most[better]
        rows = np.flatnonzero(excess == np.repeat(most, counts))
        worst = rows[np.searchsorted(rows, starts)]
        way = hips[frames[worst]] - points[going]
        level = norm(way[:, :2])
        far = (most > 0.0) & (level >= 1e-3)
        going, way, level = going[far], way[far], level[far]
        if len(going) == 0:
            break
        step = np.minimum(most[far] * norm(way) / level, level) * 0.85**turn
        points[going, :2] += way[:, :2] * (step / level)[:, None]
    return [replace(lock, point=point) for lock, point in zip(found, best, strict=True)]


def _freedom(held: NDArray[np.bool_], blend: float) -> Array:
    """0 where a foot is held, rising smoothly to 1 within `blend` frames, or to less in a shorter gap: `(T,)`."""
    frames, known = np.arange(len(held)), np.flatnonzero(held)
    edges = np.concatenate([[-np.inf], known, [np.inf]])
    after = np.searchsorted(known, frames) + 1
    right, left = edges[after] - frames, frames - edges[after - 1]
    ramp = np.minimum(0.5 * (left + right), blend)
    t = np.clip(np.where(held, 0.0, np.minimum(left, right)) / ramp, 0.0, 1.0)
    return smoothstep(t) * (ramp / blend)


def _pull(path: Array, pitch: heel.Pitch, hips: Array, leg: Leg) -> Array:
    """What brings a toe in the air within the leg's reach `(T, 3)`, straight towards the thigh."""
    excess = pitch.nearest(hips, path) - heel.longest(leg.length)
    excess = 0.5 * (excess + np.sqrt(excess**2 + _SOFT_PULL**2))
    return unit(hips - path) * excess[:, None]


def _loads(hips: Mapping[int, Array], toes: Sequence[Array], legs: Sequence[Leg]) -> Array:
    """Share of the weight on each foot `(T, 2)`, by where the pelvis is between the toes."""
    pelvis = 0.5 * (hips[legs[0].thigh] + hips[legs[1].thigh])
    across = level(toes[1] - toes[0])
    right = dot(pelvis - toes[0], across) / np.maximum(dot(across, across), 1e-4)
    right = np.clip(right, 0.0, 1.0)
    return np.stack([1.0 - right, right], axis=-1)

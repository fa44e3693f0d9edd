"""Variants of a motion at another body height: walks become crouched walks, or walks on tip-toe."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body import forward_kinematics as fk
from ..body import hierarchy
from ..body.legs import Leg, legs_of
from ..body.motion import Motion
from ..body.pose import with_world_rotations
from ..body.skeleton import SIDES, Skeleton
from ..body.trunk import thighs_middle
from ..errors import InputError
from ..maths import angles, filters, quat
from ..maths.easing import smoothstep
from ..maths.vectors import unit
from .posture import crouching, lean_shares
from .variant_legs import FootPath, ahead_by, foot_path, highest, overstretch, place_leg, soft_max

Array = NDArray[np.floating[Any]]

_LYING = 0.4
"""Head height over standing height at which nothing changes: who is that low sits, kneels or lies."""
_LYING_SOFT = 0.05
"""The same ratio over which that begins."""
_FACING_S = 0.25
"""Seconds over which the direction of the lean is smoothed: hips swing to and fro with every step."""
_TIPTOE_STEPS = 5.0
"""Share that steps lose for each share of height gained on tip-toe: with 0.8 of the steps at 1.04 the hips of
walkers dip by a centimetre at most to reach them, with whole steps by up to 5."""
_SAG_SOFT = 0.02
"""Metres over which such a dip begins."""
_SWING_S = 0.2
"""No step takes a foot off the ground for less: such a foot goes on standing."""
_CLOCK_S = 0.4
"""Seconds in which a foot that leaves the ground catches up with the body's way: half a long swing."""


def at_body_height(motion: Motion, contacts: NDArray[np.bool_], share: float, standing: float) -> Motion:
    """The motion of the same body with its head at another height.

    Lower, the body crouches as `crouching` says; higher, its heels rise. Toes keep their height and their turns, and
    those that stand go on standing, but steps become shorter. Head, forearms and hands keep their directions. A
    body that is lower already changes less, down to nothing at 0.4 of its standing height. Time does not change.

    Args:
        motion: any skeleton, metres, the floor at Z = 0.
        contacts: `(T, 2)` left, right toe on the ground.
        share: the height of the head joint of a standing body, over what it was; 1 gives the motion as it is.
        standing: height of the head joint while this body stands at ease, metres.

    Raises:
        InputError: the feet are too short to stand so high on their toes.
    """
    if share == 1.0:
        return motion
    skeleton = motion.skeleton
    legs = legs_of(skeleton)
    _check_reach(legs, share, standing)
    positions, rotations = motion.forward()
    drop = _drop(positions[:, skeleton.joint("head"), 2], share, standing)
    steps = step_share(skeleton, share, standing)
    world, places = _upper_body(motion, positions, rotations, legs, drop, steps)
    rise = np.maximum(-drop, 0.0)
    feet: list[FootPath] = []
    for side, leg in enumerate(legs):
        way = _at_rest(motion.positions[:, :2], contacts[:, side], motion.fps)
        feet.append(foot_path(leg, positions, rotations, (steps - 1.0) * way, rise, motion.fps))
    short = soft_max(overstretch(feet[0], places), overstretch(feet[1], places), _SAG_SOFT)
    places[..., 2] -= np.minimum(soft_max(short, 0.0, _SAG_SOFT), rise)[:, None]
    wanted = {joint: world[:, joint] for joint in _above_legs(skeleton, legs)}
    for foot in feet:
        wanted |= place_leg(foot, positions, rotations, places, drop)
    return with_world_rotations(motion, wanted, places[:, 0])


def step_share(skeleton: Skeleton, share: float, standing: float) -> float:
    """Length of the steps at a body height, over what it was.

    Crouched, the square root of the hips' height over the floor as a share of standing: walks at the same Froude
    number v^2 / (g h) are alike (Alexander 1989), and the time of a step does not change here.
    """
    if share > 1.0:
        return 1.0 - _TIPTOE_STEPS * (share - 1.0)
    crouch = crouching(skeleton)
    sink = np.interp((1.0 - share) * standing, crouch.drop, crouch.sink)
    thighs = skeleton.tpose_positions()[[skeleton.joint(f"thigh.{side}") for side in SIDES], 2]
    return float(np.sqrt(1.0 - sink / thighs.mean()))


def usual_height_range(share: float) -> tuple[float, float]:
    """The headset heights over standing eye height for which a database at a body height is meant.

    From halfway to standing on: 0 to 0.85 for 0.7, 1.02 to 2 for 1.04, and all for 1.
    """
    if share == 1.0:
        return 0.0, 2.0
    middle = round(0.5 * (1.0 + share), 4)
    return (0.0, middle) if share < 1.0 else (middle, 2.0)


def _check_reach(legs: Sequence[Leg], share: float, standing: float) -> None:
    most = 1.0 + min(highest(leg) for leg in legs) / standing
    if share > most:
        raise InputError(
            f"body height {share:g}: on the toes of this skeleton's feet the head comes to {most:.3f} of its standing "
            f"height; give {np.floor(100.0 * most) / 100.0:g} or less"
        )


def _drop(heads: Array, share: float, standing: float) -> Array:
    """How far the head comes down in each frame `(T,)`, metres; below zero: up."""
    upright = (heads / standing - _LYING) / (1.0 - _LYING)
    return (1.0 - share) * standing * soft_max(upright, 0.0, _LYING_SOFT)


def _upper_body(
    motion: Motion, positions: Array, rotations: Array, legs: Sequence[Leg], drop: Array, steps: float
) -> tuple[Array, Array]:
    """World rotations `(T, J, 4)` and places `(T, J, 3)` of the leaned body, its head as high as is wanted.

    Its legs are still to be placed.
    """
    skeleton, head = motion.skeleton, motion.skeleton.joint("head")
    facing = _facing(motion)
    crouch = crouching(skeleton)
    lean, back = (np.interp(drop, crouch.drop, values) for values in (crouch.lean, crouch.back))
    # on tip-toe the legs stand over the balls of the feet, where the ankles go
    rise = np.maximum(-drop, 0.0)
    back -= np.mean([ahead_by(leg, rise) for leg in legs], axis=0)
    left = np.stack([-facing[:, 1], facing[:, 0], np.zeros(len(facing))], axis=-1)
    tilts = lean[:, None] * lean_shares(skeleton)
    world = quat.multiply(quat.from_rotation_vector(left[:, None] * tilts[..., None]), rotations)
    middle = thighs_middle(skeleton)
    hips = motion.positions + quat.rotate(rotations[:, 0], middle) - quat.rotate(world[:, 0], middle)
    hips -= back[:, None] * facing
    hips[:, :2] += (steps - 1.0) * motion.positions[:, :2]
    places = fk.joint_positions(hips, world, skeleton.offsets, skeleton.parents)
    places[..., 2] += (positions[:, head, 2] - drop - places[:, head, 2])[:, None]
    return world, places


def _above_legs(skeleton: Skeleton, legs: Sequence[Leg]) -> list[int]:
    """The joints that hang from no thigh."""
    below = hierarchy.below(skeleton.parents, [leg.thigh for leg in legs])
    return [joint for joint in range(len(skeleton)) if joint not in below]


def _facing(motion: Motion) -> Array:
    """Level unit vectors `(T, 3)` to where the body leans."""
    ahead = angles.direction(quat.heading(motion.rotations[:, 0]))
    return unit(np.pad(filters.gaussian(ahead, _FACING_S * motion.fps), ((0, 0), (0, 1))))


def _at_rest(path: Array, contacts: NDArray[np.bool_], fps: float) -> Array:
    """A path `(T, 2)` read by a clock that stands in the middle of each contact of a foot while it lasts.

    What follows it goes with the path, but stands while the foot does. Far from contacts the clock is right.
    """
    edges = np.flatnonzero(np.diff(contacts, prepend=False, append=False))
    short = np.flatnonzero(edges[2::2] - edges[1:-1:2] < _SWING_S * fps)
    stops = np.delete(edges, np.concatenate([2 * short + 1, 2 * short + 2])).reshape(-1, 2)
    reach, before = _CLOCK_S * fps, -np.inf
    knots: list[tuple[float, float, float]] = []
    for first, stop in stops.tolist():
        last, middle = stop - 1.0, 0.5 * (first + stop - 1.0)
        if first - before > 2.0 * reach:
            free = [before + reach, first - reach] if knots else [first - reach]
            knots += [(time, time, 1.0) for time in free]
        knots += [(float(first), middle, 0.0), (last, middle, 0.0)]
        before = last
    if not knots:
        return path
    knots.append((before + reach, before + reach, 1.0))
    frames: Array = np.arange(len(path), dtype=np.float64)
    clock = _through(np.array(knots), frames)
    out = np.empty_like(path)
    for i in range(2):
        out[:, i] = np.interp(clock, frames, path[:, i])
    return out


def _through(knots: Array, times: Array) -> Array:
    """Cubic Hermite curve `(T,)` through knots `(K, 3)`: time, value, slope; outside of them each time itself."""
    start, value, slope = knots.T
    k = np.clip(np.searchsorted(start, times, side="right") - 1, 0, len(knots) - 2)
    length = np.maximum(start[k + 1] - start[k], 1e-9)
    t = (times - start[k]) / length
    curve = (1.0 + 2.0 * t) * (1.0 - t) ** 2 * value[k] + t * (1.0 - t) ** 2 * length * slope[k]
    curve += smoothstep(t) * value[k + 1] - t**2 * (1.0 - t) * length * slope[k + 1]
    return np.where((times < start[0]) | (times > start[-1]), times, curve)

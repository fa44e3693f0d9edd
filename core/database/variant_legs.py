"""Legs of a body whose hips come down or whose heels rise, over toes that stay where they are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body import heel, two_bone
from ..body.legs import Leg
from ..maths import filters, quat
from ..maths.easing import smoothstep
from ..maths.vectors import level, norm, unit

Array = NDArray[np.floating[Any]]

_STRAIGHT = 0.995
"""Share of its length to which a leg is stretched at most, unless it was longer."""
_FOLDING: Array = np.radians(np.array([125.0, 160.0]))
"""Bend of the knee at which a raised heel begins to come down, and at which it would be all down; calves meet thighs at
about 150."""
_STEEPEST = np.radians(90.0)
"""Greatest angle over the ground from the ball of the foot back to the ankle."""
_ON_TOES = np.radians(80.0)
"""The same for a body that stands on tip-toe."""
_OVER_TOES = 0.2
"""Metres of crouching over which knees come to point where the toes do."""
_POINTING_S = 0.1
"""Seconds over which that direction is smoothed: feet in the air wobble."""
_SOFT_KNEE = 0.03
"""Metres: a leg bent by less takes the plane of its knee from the shin's own axes."""
_FORWARD, _DOWN = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, -1.0])


def highest(leg: Leg) -> float:
    """Metres that the ankle of a leg can rise over standing toes."""
    return leg.radius * (np.sin(_ON_TOES) - np.sin(leg.flat))


def ahead_by(leg: Leg, rise: Array) -> Array:
    """Metres that the ankle of a standing foot goes forward as it rises by `rise` `(T,)` metres."""
    return leg.radius * (np.cos(leg.flat) - np.cos(_up(leg, rise)))


def _risen(leg: Leg, angle: Array, rise: Array) -> Array:
    """The angle `(T,)` from toe to ankle where a standing foot's ankle rises by `rise` `(T,)` metres.

    Feet whose heels are up already, as at the end of a step, rise less and less.
    """
    up = _up(leg, rise)
    left = (_STEEPEST - up) / (_STEEPEST - leg.flat)
    steep = np.maximum(angle, up + (angle - leg.flat) * left)
    return np.where(angle < leg.flat, angle + up - leg.flat, steep)


def _up(leg: Leg, rise: Array) -> Array:
    """The angle `(T,)` from toe to ankle of a foot that stood flat and whose ankle rose."""
    sine = np.sin(leg.flat) + rise / max(leg.radius, 1e-6)
    return np.arcsin(np.minimum(sine, np.sin(_STEEPEST)))


@dataclass(frozen=True, slots=True, eq=False)
class FootPath:
    """Where a foot goes, wherever the hips are."""

    leg: Leg
    toes: Array
    """`(T, 3)` world positions, metres."""
    pitch: heel.Pitch
    """How the motion holds the foot."""
    angle: Array
    """`(T,)` from toe to ankle over the ground as it is wanted, radians."""
    longest: Array
    """`(T,)` metres that the ankle may be from the thigh joint."""
    ahead: Array
    """`(T, 3)` level unit vectors to where the foot points."""

    def ankles(self, angle: Array) -> Array:
        """World positions `(T, 3)` with the foot at these angles `(T,)`."""
        pitch = self.pitch
        out = (
            self.toes
            + pitch.back * (pitch.radius * np.cos(angle))[:, None]
            + pitch.right * pitch.aside[:, None]
        )
        out[:, 2] += pitch.radius * np.sin(angle)
        return out


def foot_path(
    leg: Leg, positions: Array, rotations: Array, shift: Array, rise: Array, fps: float
) -> FootPath:
    """A foot whose toe is moved over the ground.

    Args:
        leg: which.
        positions: `(T, J, 3)` world positions in the motion, metres.
        rotations: `(T, J, 4)` world rotations there.
        shift: `(T, 2)` metres over the ground.
        rise: `(T,)` metres that the ankle of a standing foot rises.
        fps: frames per second.
    """
    toes = positions[:, leg.foot] + quat.rotate(rotations[:, leg.foot], leg.to_toe)
    toes[:, :2] += shift
    pitch = heel.pitch_of(rotations[:, leg.foot], leg.to_toe)
    longest = np.maximum(norm(positions[:, leg.foot] - positions[:, leg.thigh]), _STRAIGHT * leg.bones.sum())
    ahead = unit(filters.gaussian(-pitch.back, _POINTING_S * fps))
    return FootPath(leg, toes, pitch, _risen(leg, pitch.angle, rise), longest, ahead)


def overstretch(foot: FootPath, places: Array) -> Array:
    """Metres `(T,)` that the hips are too high for a leg whose heel is up as far as it goes; below zero: to spare.

    Args:
        foot: where it goes.
        places: `(T, J, 3)` the body, metres.
    """
    way = places[:, foot.leg.thigh] - foot.ankles(np.maximum(foot.angle, _STEEPEST))
    ground = np.minimum(norm(level(way)), 0.9 * foot.longest)
    return way[:, 2] - np.sqrt(foot.longest**2 - ground**2)


def place_leg(
    foot: FootPath, positions: Array, rotations: Array, places: Array, drop: Array
) -> dict[int, Array]:
    """World rotations `(T, 4)` by joint of a leg that follows its foot's path.

    The heel comes down where the knee would bend too far, and up where the leg would be too short. The knee of
    a body that crouches goes forward over the toes; else it bends as in the motion. Toes keep their rotations.

    Args:
        foot: where it goes.
        positions: `(T, J, 3)` world positions in the motion, metres.
        rotations: `(T, J, 4)` world rotations there.
        places: `(T, J, 3)` the body with its hips in place, metres.
        drop: `(T,)` metres of crouching.
    """
    leg, pitch, hips = foot.leg, foot.pitch, places[:, foot.leg.thigh]
    angle = _lowered(foot, hips)
    far = np.minimum(pitch.reaching(hips, foot.toes, foot.longest), np.maximum(angle, _STEEPEST))
    angle = np.maximum(angle, far)
    turned = quat.from_rotation_vector(-pitch.right * (angle - pitch.angle)[:, None])
    ankles = foot.ankles(angle)
    limb = positions[:, [leg.thigh, leg.shin, leg.foot]]
    line = ankles - hips
    caps = unit(quat.rotate(rotations[:, [leg.thigh, leg.shin]], _FORWARD).sum(axis=1))
    bend = unit(two_bone.bend_direction(limb, caps, _SOFT_KNEE))
    own = quat.rotate(quat.between(limb[:, 2] - limb[:, 0], line), bend)
    over = quat.rotate(quat.between(np.broadcast_to(_DOWN, line.shape), line), foot.ahead)
    share = np.clip(drop / _OVER_TOES, 0.0, 1.0)
    share = smoothstep(share)[:, None]
    bones, _ = two_bone.reach(
        limb + (hips - limb[:, 0])[:, None],
        rotations[:, [leg.thigh, leg.shin]],
        ankles,
        bend + share * (caps - bend),
        own + share * (over - own),
    )
    out = {leg.thigh: bones[:, 0], leg.shin: bones[:, 1], leg.end: rotations[:, leg.end]}
    return out | {leg.foot: quat.multiply(turned, rotations[:, leg.foot])}


def soft_max(a: Array, b: Array | float, width: float) -> Array:
    """The greater of two, rounded off where they are nearer to each other than `width`."""
    return np.maximum(a, b) + np.maximum(width - np.abs(a - b), 0.0) ** 2 / (4.0 * width)


def _lowered(foot: FootPath, hips: Array) -> Array:
    """The foot's angle `(T,)` with its heel lower where the knee would fold too far, for thigh joints `(T, 3)`."""
    bones = foot.leg.bones
    begin, end = np.sqrt(bones @ bones + 2.0 * bones[0] * bones[1] * np.cos(_FOLDING))
    share = np.clip((begin - norm(hips - foot.ankles(foot.angle))) / (begin - end), 0.0, 1.0)
    return foot.angle - smoothstep(share) * np.maximum(foot.angle - foot.leg.flat, 0.0)

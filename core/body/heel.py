"""A foot pitched about its toe: the heel off the floor, and up where the leg is too short; the toe's tip
up."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from ..maths import angles, filters, quat
from ..maths.vectors import dot, level, norm, unit

Array = NDArray[np.floating[Any]]

_STRAIGHT = 0.999
"""Share of a leg's length to which it is stretched at most, as long as a rising heel can help."""
_RELAXED = 0.998
"""The same where the motion's own leg is not straighter: near full length a knee moves far for little, 8 cm for each
centimetre of the hips at 0.998. At 0.994 knees were bent by 3 degrees more than people's."""
_SOFT = 0.02
"""Share of a leg's length over which the rising heel takes over: a knee that locks snaps."""
_STEEPEST = np.radians(95.0)
"""Greatest angle over the ground from the toe back to the ankle."""
_EASY = np.radians(10.0)
"""Pitch past the motion's own that a step may ask of a foot before it is made shorter."""
_HEEL = 1.35
"""Distance over the ground from toe to heel as a multiple of that from toe to ankle."""
_PEAK_S = 0.03
"""Standard deviation in seconds of the smoothing of a heel's rise."""


@dataclass(frozen=True, slots=True, eq=False)
class Pitch:
    """Where an ankle is, seen from the toe, in the upright plane along the foot.

    Pitching the foot moves the ankle on a circle in that plane: at angle a it is `radius` (cos a back + sin
    a up) from the toe, and `aside` to the right.
    """

    back: Array
    """`(T, 3)` level unit vectors from toe to heel."""
    right: Array
    """`(T, 3)` level unit vectors."""
    angle: Array
    """`(T,)` radians."""
    radius: Array
    """`(T,)` metres."""
    aside: Array
    """`(T,)` metres."""

    def cut(self, span: NDArray[np.intp]) -> Pitch:
        """The same for some of the frames."""
        return Pitch(self.back[span], self.right[span], self.angle[span], self.radius[span], self.aside[span])

    def nearest(self, hips: Array, toes: Array) -> Array:
        """Distance `(T,)` in metres from a thigh joint to the ankle with a little more pitch where that
        helps.

        Args:
            hips: `(T, 3)` thigh joints.
            toes: `(T, 3)` or `(3,)`.
        """
        w = hips - toes
        along, up = dot(w, self.back), w[..., 2]
        angle = np.clip(angles.arctan2(up, along), self.angle, self.angle + _EASY)
        meeting = self.radius * (along * np.cos(angle) + up * np.sin(angle))
        meeting += dot(w, self.right) * self.aside
        square = dot(w, w) + self.radius**2 + self.aside**2 - 2.0 * meeting
        return np.sqrt(np.maximum(square, 0.0))

    def distance(self, hips: Array, toes: Array) -> Array:
        """Distance `(T,)` in metres from a thigh joint to the ankle as the foot is."""
        ankle = self.back * (self.radius * np.cos(self.angle))[:, None] + self.right * self.aside[:, None]
        ankle[:, 2] += self.radius * np.sin(self.angle)
        return norm(hips - toes - ankle)

    def reaching(self, hips: Array, toes: Array, length: Array) -> Array:
        """Least angle `(T,)` at which the ankle is no farther than `length` `(T,)` from the thigh joint.

        Where no angle is enough, the one that brings it nearest. With w from the toe to the thigh joint and
        r the radius, w.(cos a, sin a) >= (w^2 + r^2 - length^2) / 2r.
        """
        w = hips - toes
        along, up = dot(w, self.back), w[..., 2]
        across = dot(w, self.right) * self.aside
        needed = dot(w, w) + self.radius**2 + self.aside**2 - length**2 - 2.0 * across
        cosine = needed / np.maximum(2.0 * self.radius * np.hypot(along, up), 1e-9)
        return angles.arctan2(up, along) - np.arccos(np.clip(cosine, -1.0, 1.0))


def pitch_of(rotations: Array, foot_to_toe: Array) -> Pitch:
    """The pitch of a foot.

    Args:
        rotations: `(T, 4)` world rotations of the foot joint.
        foot_to_toe: `(3,)` from foot joint to toe in T-pose, metres.
    """
    away = -quat.rotate(rotations, foot_to_toe)
    right = unit(level(quat.rotate(rotations, np.array([1.0, 0.0, 0.0]))))
    back = np.stack([right[:, 1], -right[:, 0], np.zeros(len(right))], axis=-1)
    behind = dot(away, back)
    return Pitch(
        back, right, angles.arctan2(away[:, 2], behind), np.hypot(behind, away[:, 2]), dot(away, right)
    )


def lowered(rotations: Array, foot_to_toe: Array, angle: Array) -> Array:
    """World rotations `(T, 4)` of a foot whose heel comes down by angles `(T,)` in radians, the toe where it is."""
    right = pitch_of(rotations, foot_to_toe).right
    return quat.multiply(quat.from_rotation_vector(right * angle[:, None]), rotations)


def relaxed(length: float) -> float:
    """How far the ankle of a leg of a length in metres may be from the thigh joint where the motion's is nearer."""
    return _RELAXED * length


def longest(length: float) -> float:
    """How far an ankle may be from the thigh joint, of a leg's length in metres."""
    return _STRAIGHT * length


def raise_heel(
    rotations: Array,
    foot_to_toe: Array,
    rest_height: float,
    toes: Array,
    hips: Array,
    length: float,
    own: Array,
    fps: float,
) -> Array:
    """World rotations `(T, 4)` of a foot whose heel stays off the floor and rises where the leg is too short.

    Args:
        rotations: `(T, 4)` world rotations of the foot joint.
        foot_to_toe: `(3,)` from foot joint to toe in T-pose, metres.
        rest_height: of the toe over the floor in T-pose, metres.
        toes: `(T, 3)` where the toe is.
        hips: `(T, 3)` thigh joints.
        length: of the leg, metres.
        own: `(T,)` metres from thigh joint to ankle in the motion.
        fps: frames per second.
    """
    pitch = pitch_of(rotations, foot_to_toe)
    distance = pitch.distance(hips, toes)
    most = np.clip(own, _RELAXED * length, longest(length))
    # nothing changes up to the motion's own; from there on the leg grows ever less with the distance
    free = np.clip(own, (_RELAXED - 0.5 * _SOFT) * length, most)
    width = np.maximum(2.0 * (most - free), 1e-9)
    past = np.minimum(distance - free, width)
    bearable = np.minimum(distance - past**2 / (2.0 * width), most)
    reaching = np.where(past > 0.0, pitch.reaching(hips, toes, bearable), pitch.angle)
    reaching = np.minimum(reaching, np.maximum(pitch.angle, _STEEPEST))
    wanted = np.maximum(_least_pitch(foot_to_toe, rest_height, toes[:, 2]), reaching)
    lift = smooth_peaks(np.maximum(wanted - pitch.angle, 0.0), _PEAK_S * fps)
    return quat.multiply(quat.from_rotation_vector(-pitch.right * lift[:, None]), rotations)


def raise_tip(rotations: Array, tip: Array, heights: Array, rest_height: float) -> Array:
    """World rotations `(T, 4)` of a toe, bent up where its tip would be lower than in T-pose.

    Args:
        rotations: `(T, 4)` world rotations of the toe joint.
        tip: `(3,)` from the toe joint to the end of its bone in T-pose, metres.
        heights: `(T,)` of the toe joint over the floor, metres.
        rest_height: the same in T-pose.
    """
    right = unit(level(quat.rotate(rotations, np.array([1.0, 0.0, 0.0]))))
    forward = np.stack([-right[:, 1], right[:, 0], np.zeros(len(right))], axis=-1)
    end = quat.rotate(rotations, tip)
    along = dot(end, forward)
    lowest = max(rest_height + float(tip[2]), 0.0) - heights
    needed = np.arcsin(np.clip(lowest / np.maximum(np.hypot(along, end[:, 2]), 1e-9), -1.0, 1.0))
    lift = np.maximum(needed - angles.arctan2(end[:, 2], along), 0.0)
    return quat.multiply(quat.from_rotation_vector(right * lift[:, None]), rotations)


def heel_behind(foot_to_toe: Array) -> float:
    """Metres over the ground from the toe back to the heel in T-pose."""
    return _HEEL * float(foot_to_toe[1])


def _least_pitch(foot_to_toe: Array, rest_height: float, heights: Array) -> Array:
    """Least angle `(T,)` from toe to ankle at which the heel, on the floor in T-pose, is not below it."""
    _, back, up = foot_to_toe
    reach = heel_behind(foot_to_toe)
    sine = np.clip(-heights / max(float(np.hypot(reach, rest_height)), 1e-9), -1.0, 1.0)
    return angles.arctan2(-up, back) + np.arcsin(sine) + angles.arctan2(rest_height, reach)


def smooth_peaks(values: Array, sigma: float) -> Array:
    """A smooth curve `(T,)` on or above non-negative `values`, which rises before and falls after them.

    Args:
        values: `(T,)`.
        sigma: standard deviation of the smoothing in frames.
    """
    half = int(np.ceil(4.0 * sigma))
    if not values.any():
        return values
    widest = sliding_window_view(np.pad(values, half, mode="edge"), 2 * half + 1).max(axis=-1)
    return filters.gaussian(widest, sigma)

"""From a playback to a motion: poses gathered, jumps at transitions blended out by inertialization (Bollo
2017).

At a transition the new clip plays at once; what pose and velocity would have jumped by becomes an offset that
a critically damped spring takes away (paper, section 5.3). An offset still under way at the next transition
is part of the pose that jumps there.

A rotation's offset is a rotation vector x before the clip's own rotation, exp(x) q, in the parent's axes. Its
angular velocity is J(x) dx/dt with the left Jacobian J of the rotation group, so that the velocity goes on
exactly, not only for small offsets (Sola, Deray, Atchuthan, "A micro Lie theory", 2018).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body.motion import Motion
from ..database.motion_database import MotionDatabase
from ..maths import angles, quat
from ..maths.vectors import cross, dot
from ..settings import BakeSettings
from .playback import Playback
from .selection import check_databases

Array = NDArray[np.floating[Any]]
Frames = NDArray[np.intp]

_BLOCK = 1024
"""Frames blended at a time: their arrays stay in the processor's cache."""
_TINY = 1e-8
"""Squared angles below this act as this: the terms they divide are then below rounding."""


def assemble(
    playback: Playback, databases: Sequence[MotionDatabase], settings: BakeSettings
) -> tuple[Motion, NDArray[np.bool_]]:
    """The motion that a playback describes, on the first database's skeleton, and its contacts.

    Args:
        playback: what plays when.
        databases: the same as it was made from.
        settings: `halflife` of the inertialization.

    Returns:
        The motion in the world, and `(T, 2)` whether the clip's left and right toe is on the ground.

    Raises:
        InputError: the databases do not go together.
    """
    check_databases(databases)
    skeleton, fps = databases[0].skeleton, databases[0].fps
    hips, rotations = _poses(databases, playback.database, playback.frame)
    rate = 2.0 * math.log(2.0) / settings.halflife
    blend = _offsets(playback, databases, fps, rate)

    for start in range(0, len(playback), _BLOCK):
        rows = slice(start, start + _BLOCK)
        frames = np.arange(len(playback))[rows]
        segments = np.searchsorted(blend.starts, frames, side="right") - 1
        ages = (frames - blend.starts[segments]) / fps
        hips[rows] += blend.at(blend.hips, segments, ages, rate)
        offsets = quat.from_rotation_vector(blend.at(blend.rotations, segments, ages, rate))
        rotations[rows] = quat.multiply(offsets, rotations[rows])
        rotations[rows, 0] = quat.multiply(quat.from_yaw(playback.root_yaws[rows]), rotations[rows, 0])
    positions = hips
    positions[:, :2] = playback.root_positions + angles.turn(hips[:, :2], playback.root_yaws)
    contacts = np.empty((len(playback), 2), dtype=np.bool_)
    for index, source in enumerate(databases):
        mine = playback.database == index
        contacts[mine] = source.poses.contacts[playback.frame[mine]]
    return Motion(skeleton, fps, positions, quat.continuous(rotations)), contacts


@dataclass(frozen=True, slots=True, eq=False)
class _Blend:
    """The offset at the start of each of S segments, and its push: its velocity plus the spring's rate times
    itself. The first has none."""

    starts: Frames
    """`(S,)` frames."""
    hips: tuple[Array, Array]
    """`(S, 3)` metres in root space, and per second."""
    rotations: tuple[Array, Array]
    """`(S, J, 3)` rotation vectors, and per second."""

    @staticmethod
    def at(offset: tuple[Array, Array], segments: Frames, ages: Array, rate: float) -> Array:
        """The offset at frames that are `ages` `(B,)` seconds into their `segments` `(B,)`."""
        # frames last while gathered: then they are what runs fastest in memory
        values, pushes = (array.T.take(segments, axis=-1) for array in offset)
        return (np.exp(-rate * ages) * (values + pushes * ages)).T


def _poses(databases: Sequence[MotionDatabase], database: Frames, frame: Frames) -> tuple[Array, Array]:
    """Hips `(T, 3)` and local rotations `(T, J, 4)` in root space of the given frames of the given
    databases."""
    hips = np.empty((len(frame), 3), order="F")
    rotations = np.empty((len(frame), len(databases[0].skeleton), 4), order="F")
    for index, source in enumerate(databases):
        mine = np.flatnonzero(database == index)
        hips[mine] = source.poses.hips_positions[frame[mine]]
        rotations[mine] = source.poses.rotations[frame[mine]]
    return hips, rotations


@dataclass(frozen=True, slots=True, eq=False)
class _Rates:
    """Velocities of K frames."""

    root: Array
    """`(K, 3)` m/s in root space."""
    turn: Array
    """`(K,)` rad/s of the root."""
    hips: Array
    """`(K, 3)` m/s in root space."""
    joints: Array
    """`(K, J, 3)` rad/s in the parent's axes."""


def _rates(databases: Sequence[MotionDatabase], database: Frames, frame: Frames) -> _Rates:
    count, joints = len(frame), len(databases[0].skeleton)
    out = _Rates(np.zeros((count, 3)), np.empty(count), np.empty((count, 3)), np.empty((count, joints, 3)))
    for index, source in enumerate(databases):
        mine = np.flatnonzero(database == index)
        poses, rows = source.poses, frame[mine]
        out.root[mine, :2] = poses.root_velocities[rows]
        out.turn[mine] = poses.root_yaw_velocities[rows]
        out.hips[mine] = poses.hips_velocities[rows]
        out.joints[mine] = poses.angular_velocities[rows]
    return out


def _offsets(playback: Playback, databases: Sequence[MotionDatabase], fps: float, rate: float) -> _Blend:
    """Offsets at all transitions.

    The root's path has a kink at a transition; its change of velocity is made up for by the hips' offset, so
    that the body moves on smoothly in the world.
    """
    at = playback.transitions
    database, frame = playback.database, playback.frame
    old_hips, old_rotations = _poses(databases, database[at - 1], frame[at - 1] + 1)
    new_hips, new_rotations = _poses(databases, database[at], frame[at])
    old, new = (
        _rates(databases, database[at - 1], frame[at - 1] + 1),
        _rates(databases, database[at], frame[at]),
    )
    starts = np.concatenate([np.zeros(1, dtype=np.intp), at])

    ages = np.diff(starts) / fps
    hips = np.zeros((len(starts), 3)), np.zeros((len(starts), 3))
    jump, push, spin = old_hips - new_hips, old.root + old.hips - new.root - new.hips, old.turn - new.turn
    for k, age in enumerate(ages.tolist()):
        value, speed = _decay(hips[0][k], hips[1][k], age, rate)
        place = old_hips[k] + value
        hips[0][k + 1] = value + jump[k]
        hips[1][k + 1] = speed + push[k]
        hips[1][k + 1, 0] -= spin[k] * place[1]
        hips[1][k + 1, 1] += spin[k] * place[0]

    jumps = quat.multiply(old_rotations, quat.conjugate(new_rotations))
    pushes = old.joints - quat.rotate(jumps, new.joints)
    rotations = _rotation_offsets(ages, jumps, pushes, spin, rate)
    return _Blend(starts, *((value, speed + rate * value) for value, speed in (hips, rotations)))


def _decay(value: Array, speed: Array, age: Array | float, rate: float) -> tuple[Array, Array]:
    """Offset and velocity of a critically damped spring after `age` seconds; `rate` is 2 ln 2 / half-life."""
    push, shrink = speed + rate * value, np.exp(-rate * age)
    return shrink * (value + push * age), shrink * (speed - rate * age * push)


def _rotation_offsets(
    ages: Array, jumps: Array, pushes: Array, spin: Array, rate: float
) -> tuple[Array, Array]:
    """Rotation vectors and their derivatives `(K + 1, J, 3)`: a recurrence over the K transitions.

    What is left of an offset at the next transition is little, so all transitions are worked out at once, again
    and again until nothing changes: after about ten rounds, at the latest after K.

    Args:
        ages: `(K,)` seconds from the transition before, the first from frame 0.
        jumps: `(K, J, 4)` from the new rotation to the old one.
        pushes: `(K, J, 3)` rad/s, old angular velocity less the new one turned by the jump.
        spin: `(K,)` rad/s by which the root turned faster before.
        rate: of the spring, 1/s.
    """
    count, joints = jumps.shape[:2]
    values, speeds = (np.zeros((count + 1, joints, 3), order="F") for _ in range(2))
    ages = ages[:, None, None]
    for _ in range(count):
        x, dx = _decay(values[:-1], speeds[:-1], ages, rate)
        square = _square(x)
        angle = np.sqrt(square)
        ratio, half = np.sin(angle) / angle, (1.0 - np.cos(angle)) / square
        # the offset's own angular velocity J(x) dx, and the push turned by the offset
        once = cross(x, dx)
        velocity = dx + half * once + (1.0 - ratio) / square * cross(x, once)
        once = cross(x, pushes)
        velocity += pushes + ratio * once + half * cross(x, once)
        velocity[:, 0, 2] += spin
        turn = np.concatenate([np.cos(0.5 * angle), np.sin(0.5 * angle) / angle * x], axis=-1)
        x = quat.to_rotation_vector(quat.multiply(turn, jumps))
        dx = _unwind(x, velocity)
        if np.array_equal(x, values[1:]) and np.array_equal(dx, speeds[1:]):
            break
        values[1:], speeds[1:] = x, dx
    return values, speeds


def _unwind(x: Array, velocity: Array) -> Array:
    """The derivative `(..., 3)` of rotation vectors `x` that turns at an angular `velocity`: the inverse of
    J(x)."""
    square = _square(x)
    half = 0.5 * np.sqrt(square)
    once = cross(x, velocity)
    return velocity - 0.5 * once + (1.0 - half / np.tan(half)) / square * cross(x, once)


def _square(x: Array) -> Array:
    """Squared angles `(..., 1)` of rotation vectors `(..., 3)`, kept from zero."""
    return np.maximum(dot(x, x), _TINY)[..., None]

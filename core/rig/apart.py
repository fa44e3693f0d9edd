"""Feet that do not pass through each other: plants side by side, and steps around the other leg.

Only what is too near is moved, sideways as the body faces: two feet that stand by half of what is missing each, a foot
in the air by all of it. Legs that are crossed one well before the other are left so.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body import heel
from ..maths import angles
from .locks import Lock

Array = NDArray[np.floating[Any]]
Flags = NDArray[np.bool_]

_NEAR = 0.12
"""Distance over the ground between the ankles as a share of a leg's length at which shins touch, and a little more."""
_AROUND_S = 0.05
"""Standard deviation in seconds of the smoothing of a way around."""
_OUTWARD = (-1.0, 1.0)
"""Signs of the way out for the left and the right foot, to the body's right."""


def missing(between: Array, yaws: Array, leg_length: float) -> Array:
    """By how much `(N,)` the right ankle should be farther to the right of the left one, metres.

    Args:
        between: `(N, 2)` from the left to the right ankle over the ground.
        yaws: `(N,)` where the body faces, radians.
        leg_length: metres.
    """
    near = _NEAR * leg_length
    aside, ahead = angles.turn(between, -yaws).T
    needed = np.sqrt(np.maximum(near**2 - ahead**2, 0.0))
    return np.where(np.abs(ahead) < near, np.maximum(needed - aside, 0.0), 0.0)


def spread_plants(
    plants: tuple[Sequence[Lock], Sequence[Lock]], ankles: Array, yaws: Array, leg_length: float
) -> tuple[list[Lock], list[Lock]]:
    """The locks of the left and the right foot, moved apart where both stand too near.

    Args:
        plants: in order of time.
        ankles: `(T, 2, 3)` from the toe to the ankle of the left and the right foot, metres.
        yaws: `(T,)` where the body faces, radians.
        leg_length: metres.
    """
    left, right = list(plants[0]), list(plants[1])
    firsts = np.array([lock.first for lock in right])
    lasts = np.array([lock.last for lock in right])
    for i, lock in enumerate(left):
        low, high = np.searchsorted(lasts, lock.first), np.searchsorted(firsts, lock.last, side="right")
        for j in range(int(low), int(high)):
            other = right[j]
            frames = slice(max(lock.first, other.first), min(lock.last, other.last) + 1)
            way = other.point - left[i].point + ankles[frames, 1] - ankles[frames, 0]
            short = missing(way[:, :2], yaws[frames], leg_length)
            worst = int(np.argmax(short))
            if short[worst] > 0.0:
                push = _aside(0.5 * short[worst : worst + 1], yaws[frames][worst : worst + 1])[0]
                left[i] = replace(left[i], point=left[i].point - push)
                right[j] = replace(other, point=other.point + push)
    return left, right


def step_around(
    paths: Sequence[Array], ankles: Array, free: Array, yaws: Array, leg_length: float, fps: float
) -> None:
    """Lead feet in the air around the other leg: changes the toes' `paths` of `(T, 3)` in place.

    Args:
        paths: of the left and the right toe, metres.
        ankles: as for `spread_plants`.
        free: `(T, 2)` from 0 where a foot is held to 1 in the air.
        yaws: `(T,)` where the body faces, radians.
        leg_length: metres.
        fps: frames per second.
    """
    between = paths[1] - paths[0] + ankles[:, 1] - ankles[:, 0]
    short = missing(between[:, :2], yaws, leg_length)
    together = np.maximum(free.sum(axis=1), 1e-9)
    for side, path in enumerate(paths):
        share = short * free[:, side] / np.maximum(together, 1.0)
        way = heel.smooth_peaks(share, _AROUND_S * fps) * free[:, side]
        path += _OUTWARD[side] * _aside(way, yaws)


def _aside(way: Array, yaws: Array) -> Array:
    """Ways `(N, 3)` to the body's right by metres `(N,)`."""
    right = np.stack([np.cos(yaws), np.sin(yaws), np.zeros(len(yaws))], axis=-1)
    return way[:, None] * right

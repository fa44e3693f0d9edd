"""Scripts of ways: what the person of a starter take does, and the smooth way of the body that follows from it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.maths import angles, filters
from .conditions import Root

Array = NDArray[np.floating[Any]]

_HEIGHTS = ((0.0, 0.5, 1.0, 1.4, 2.0, 3.0), (0.926, 0.914, 0.908, 0.907, 0.895, 0.885))
"""Speed in m/s and height of the hips in metres: medians of the takes that the model learnt from."""


@dataclass(frozen=True, slots=True)
class Leg:
    """One part of a way."""

    seconds: float
    ahead: float = 0.0
    """m/s."""
    right: float = 0.0
    turn: float = 0.0
    """rad/s, to the left."""
    height: float = 1.0
    """Of the hips, as a share of that of who walks upright."""


def way(legs: Sequence[Leg], fps: float, rng: np.random.RandomState) -> Root:
    """The smooth way of a body that does these, one after another, as unsteadily as people are."""
    counts = [max(1, round(leg.seconds * fps)) for leg in legs]
    ahead, right, turn, height = (
        np.repeat([getattr(leg, name) for leg in legs], counts)
        for name in ("ahead", "right", "turn", "height")
    )
    speed = np.hypot(ahead, right)
    # who runs takes longer to get there
    sigma = 0.3 if speed.max() < 1.9 else 0.45
    ahead, right, turn = (filters.gaussian(a, sigma * fps) for a in (ahead, right, turn))
    height = filters.gaussian(height, 0.4 * fps)
    speed = np.hypot(ahead, right)
    count = len(ahead)
    sway = np.stack([wander(rng, count, fps, 2.5) for _ in range(3)], axis=1)
    ahead = ahead * (1.0 + 0.06 * sway[:, 0])
    yaws = np.cumsum(turn) / fps + 0.05 * wander(rng, count, fps, 3.0)
    course = yaws + 0.05 * sway[:, 1]
    places = np.cumsum(angles.turn(np.stack([right, ahead], axis=1), course), axis=0) / fps
    shift = np.stack([wander(rng, count, fps, 3.5), wander(rng, count, fps, 4.5)], axis=1)
    places = places + shift * np.where(speed < 0.3, 0.02, 0.01)[:, None].mean()
    heights = np.interp(speed, *_HEIGHTS) * height + 0.004 * sway[:, 2]
    return Root(fps, places, yaws, heights)


def wander(rng: np.random.RandomState, count: int, fps: float, period: float) -> Array:
    """Smooth noise `(count,)` of about unit deviation that changes over `period` seconds."""
    knots = rng.normal(size=int(count / fps / period) + 6)
    at = np.arange(count) / (fps * period) + 1.0
    index = at.astype(np.intp)
    t = at - index
    # cubic B-spline: smooth to the second derivative
    parts = ((1 - t) ** 3, 3 * t**3 - 6 * t**2 + 4, -3 * t**3 + 3 * t**2 + 3 * t + 1, t**3)
    return 1.45 / 6.0 * sum((knots[index - 1 + k] * part for k, part in enumerate(parts)), np.zeros(count))


def standing(rng: np.random.RandomState, seconds: float) -> list[Leg]:
    """Stands, shifts a little and turns a little."""
    return _fill(
        seconds,
        lambda: [
            Leg(rng.uniform(3.0, 6.0)),
            Leg(
                rng.uniform(0.6, 1.0),
                rng.uniform(-0.2, 0.25),
                rng.uniform(-0.25, 0.25),
                rng.uniform(-0.6, 0.6),
            ),
        ],
    )


def walking(rng: np.random.RandomState, seconds: float) -> list[Leg]:
    """Starts, walks at changing speeds with bends, stops."""

    def once() -> list[Leg]:
        speed = rng.uniform(0.3, 1.75)
        legs = [Leg(rng.uniform(0.8, 1.8))]
        for _ in range(rng.randint(2, 4)):
            legs.append(
                Leg(rng.uniform(1.5, 3.0), speed, 0.0, rng.choice([0.0, 0.0, 1.0]) * rng.uniform(-0.9, 0.9))
            )
            speed = float(np.clip(speed + rng.uniform(-0.5, 0.5), 0.3, 1.8))
        return legs

    return _fill(seconds, once)


def curves(rng: np.random.RandomState, seconds: float) -> list[Leg]:
    """Walks bends of all radii, and turns round sharply."""

    def once() -> list[Leg]:
        side = rng.choice([-1.0, 1.0])
        if rng.uniform() < 0.35:
            speed = rng.uniform(0.8, 1.4)
            return [Leg(1.5, speed), Leg(0.9, 0.4, 0.0, side * rng.uniform(2.0, 3.4)), Leg(1.5, speed)]
        return [Leg(rng.uniform(2.0, 4.0), rng.uniform(0.5, 1.5), 0.0, side * rng.uniform(0.4, 1.6))]

    return _fill(seconds, once)


def crabbing(rng: np.random.RandomState, seconds: float) -> list[Leg]:
    """Walks in all directions but straight ahead, and may turn on the way."""

    def once() -> list[Leg]:
        angle, speed = rng.choice([-1.0, 1.0]) * rng.uniform(0.3, 2.8), rng.uniform(0.35, 1.15)
        legs = [
            Leg(
                rng.uniform(1.5, 3.0),
                speed * float(np.cos(angle)),
                speed * float(np.sin(angle)),
                rng.choice([0.0, 1.0]) * rng.uniform(-0.7, 0.7),
            )
        ]
        return legs + ([Leg(rng.uniform(0.8, 1.5))] if rng.uniform() < 0.5 else [])

    return _fill(seconds, once)


def side_stepping(rng: np.random.RandomState, seconds: float) -> list[Leg]:
    """Steps to either side, once or several times."""

    def once() -> list[Leg]:
        return [
            Leg(rng.uniform(0.5, 3.0), 0.0, rng.choice([-1.0, 1.0]) * rng.uniform(0.3, 1.1)),
            Leg(rng.uniform(0.4, 1.5)),
        ]

    return _fill(seconds, once)


def backing(rng: np.random.RandomState, seconds: float) -> list[Leg]:
    """Walks backwards, and now and then a few steps ahead."""

    def once() -> list[Leg]:
        back = Leg(rng.uniform(1.5, 3.5), -rng.uniform(0.3, 1.1), 0.0, rng.uniform(-0.4, 0.4))
        rest = Leg(rng.uniform(0.5, 1.5))
        return (
            [back, rest, Leg(rng.uniform(1.0, 1.6), rng.uniform(0.5, 1.0))]
            if rng.uniform() < 0.3
            else [back, rest]
        )

    return _fill(seconds, once)


def turning(rng: np.random.RandomState, seconds: float) -> list[Leg]:
    """Turns on the spot by 30 degrees to a whole turn."""

    def once() -> list[Leg]:
        rate, angle = rng.uniform(0.6, 2.6), rng.uniform(0.5, 3.3)
        turn = rng.choice([-1.0, 1.0]) * rate
        return [Leg(angle / rate, rng.uniform(-0.1, 0.15), 0.0, turn), Leg(rng.uniform(0.5, 1.6))]

    return _fill(seconds, once)


def jogging(rng: np.random.RandomState, seconds: float) -> list[Leg]:
    """Stands, jogs with bends, aslant and through sharp turns, slows to a walk, stops."""

    def once() -> list[Leg]:
        speed = rng.uniform(1.9, 2.9)
        legs = [Leg(rng.uniform(0.6, 1.5)), Leg(rng.uniform(1.0, 2.0), speed, 0.0, rng.uniform(-0.6, 0.6))]
        for _ in range(rng.randint(3, 6)):
            speed = float(np.clip(speed + rng.uniform(-0.5, 0.5), 1.6, 2.9))
            slant = rng.choice([0.0, 1.0]) * rng.uniform(-0.45, 0.45)
            turn = rng.choice([0.0, 1.0]) * rng.uniform(-1.3, 1.3)
            legs.append(
                Leg(rng.uniform(0.8, 1.8), speed * float(np.cos(slant)), speed * float(np.sin(slant)), turn)
            )
        return [*legs, Leg(rng.uniform(0.8, 1.6), rng.uniform(1.2, 1.7))]

    return _fill(seconds, once)


def crouching(rng: np.random.RandomState, seconds: float) -> list[Leg]:
    """Crouches to 0.74 of the hips' height, stays, walks, side-steps and turns there, and comes up again."""

    def once() -> list[Leg]:
        low = rng.uniform(0.74, 0.9)
        side = rng.choice([-1.0, 1.0])
        moves = (
            Leg(3.0, rng.uniform(0.4, 1.2), 0.0, rng.uniform(-0.5, 0.5), low),
            Leg(2.0, 0.0, side * rng.uniform(0.3, 0.7), 0.0, low),
            Leg(1.5, 0.0, 0.0, side * rng.uniform(0.6, 1.6), low),
            Leg(2.0, -rng.uniform(0.3, 0.6), 0.0, 0.0, low),
        )
        picked = [moves[int(k)] for k in rng.permutation(len(moves))[:2]]
        return [Leg(1.0), Leg(1.5, height=low), *picked, Leg(1.0, height=low)]

    return _fill(seconds, once)


def roaming(rng: np.random.RandomState, seconds: float) -> list[Leg]:
    """What people do in a room with a headset: a step this way, a turn that way, a dip, a look."""

    def once() -> list[Leg]:
        angle, speed = rng.uniform(-np.pi, np.pi), rng.uniform(0.15, 0.8)
        return [
            Leg(
                rng.uniform(0.6, 1.8),
                speed * float(np.cos(angle)),
                speed * float(np.sin(angle)),
                rng.choice([0.0, 1.0]) * rng.uniform(-1.5, 1.5),
            ),
            Leg(rng.uniform(0.4, 2.5), height=rng.choice([1.0, 1.0, 1.0, rng.uniform(0.8, 0.95)])),
        ]

    return _fill(seconds, once)


def _fill(seconds: float, once: Callable[[], list[Leg]]) -> list[Leg]:
    legs = [Leg(1.5)]
    while sum(leg.seconds for leg in legs) < seconds - 1.5:
        legs += once()
    return [*legs, Leg(1.5)]

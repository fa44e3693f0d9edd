"""Where a foot is locked, and how it comes from one lock to the next."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..maths.easing import smootherstep
from .footsteps import SHORTEST_S, Flags, Spans, frames_of

Array = NDArray[np.floating[Any]]

_EVEN_S, _EVEN_OWN_S = 0.5, 4.0
"""Seconds of standing that weigh as much as a way between two locks that is the motion's; as a step that its
foot does not make being short."""
_USUAL_S = 0.25
"""Steps longer than this weigh less, by the acceleration that a way asks of them."""
_STEP_S, _STEP_S_PER_M = 0.3, 0.45
"""Least time of a step that the motion's foot does not make, and for each metre of its way."""
_QUICK_S, _QUICK_M = 0.32, 0.5
"""Least time of one that it makes, of at least so many metres; shorter ones by the cube root of their way."""
_HARDEST = 30.0
"""m/s^2 by which such a step is changed at most."""
_SLOPE_S = 0.2
"""Seconds in which the motion's velocity is taken from a toe that comes to a lock."""
_LIFT, _LIFT_PER_M = 0.03, 0.1
"""Height of a step that the motion's foot does not make, and for each metre of its way."""
_CLEARANCE, _CLEARANCE_S = 0.02, 0.25
"""Metres a toe stays above the floor, about, in the middle of a step, and time from which it has all of it."""
_TILT, _TILT_M = np.radians(18.0), 0.2
"""How far the heel goes up in a step that the motion's foot does not make, and way from which it does so."""


@dataclass(frozen=True, slots=True)
class Lock:
    """A toe held at a point from its first to its last frame, both included."""

    first: int
    last: int
    point: Array
    """`(3,)` metres."""
    stands: float = 0.0
    """Share of the way here through which the motion's own foot stands."""

    @property
    def own(self) -> bool:
        """Whether the foot comes here by a step that the motion's foot does not make."""
        return self.stands > 0.5


def make_locks(
    path: Array, plants: Spans, contacts: Flags, height: float, unlock_distance: float, fps: float
) -> list[Lock]:
    """Locks near the toe's places from which the ways to the next ones are as the motion's, or short.

    Args:
        path: `(T, 3)` the toe in the motion, metres.
        plants: first frames and ends.
        contacts: `(T,)` whether the motion's foot stands.
        height: of the toe joint over the floor when it stands, metres.
        unlock_distance: metres that a lock may be from the toe.
        fps: frames per second.
    """
    if len(plants) == 0:
        return []
    frames, starts = frames_of(plants)
    held, counts = path[frames], plants[:, 1] - plants[:, 0]
    middle = 0.5 * (np.minimum.reduceat(held, starts) + np.maximum.reduceat(held, starts))
    middle[:, 2] = height
    mean = np.add.reduceat(held, starts) / counts[:, None]
    leave, arrive = plants[:-1, 1], plants[1:, 0]
    standing = np.append(0, np.cumsum(contacts))
    own = standing[arrive] - standing[leave] > 0.5 * (arrive - leave)
    way = np.where(own[:, None], 0.0, path[arrive] - path[leave - 1])
    stiff = _EVEN_S * np.minimum(_USUAL_S * fps / (arrive - leave + 1), 1.0) ** 4
    points = _evened(mean, counts / fps, way, np.where(own, _EVEN_OWN_S, stiff))
    points[:, 2] = height
    # back towards the middle until no toe is too far away
    share = np.ones(len(plants))
    for _ in range(8):
        away = held - np.repeat(middle + share[:, None] * (points - middle), counts, axis=0)
        share -= 0.125 * (np.maximum.reduceat(np.linalg.norm(away, axis=-1), starts) > unlock_distance)
    points = middle + share[:, None] * (points - middle)
    return [
        Lock(first, stop - 1, point) for (first, stop), point in zip(plants.tolist(), points, strict=True)
    ]


def _evened(places: Array, weight: Array, way: Array, stiff: Array) -> Array:
    """The x `(N, 3)` with the least sum of w (x - place)^2 and s (next x - x - way)^2: a tridiagonal system."""
    diagonal, right = weight.copy(), weight[:, None] * places
    diagonal[1:] += stiff
    diagonal[:-1] += stiff
    right[1:] += stiff[:, None] * way
    right[:-1] -= stiff[:, None] * way
    for i, s in enumerate(stiff):
        diagonal[i + 1] -= s**2 / diagonal[i]
        right[i + 1] += s / diagonal[i] * right[i]
    out = right / diagonal[:, None]
    for i in range(len(stiff) - 1, -1, -1):
        out[i] += stiff[i] / diagonal[i] * out[i + 1]
    return out


def give_time(path: Array, locks: Sequence[Lock], contacts: Flags, fps: float) -> list[Lock]:
    """The locks made shorter where the foot needs more time between two, and by which steps it comes to them.

    Args:
        path: `(T, 3)` the toe in the motion, metres.
        locks: of one foot, in order.
        contacts: `(T,)` whether the motion's foot stands.
        fps: frames per second.
    """
    out = list(locks)
    shortest = max(2, round(SHORTEST_S * fps))
    for i, (before, lock) in enumerate(pairwise(locks)):
        # of what was given to the step before this one
        before = out[i]
        while True:
            lock = replace(lock, stands=float(contacts[before.last + 1 : lock.first].mean()))
            short = int(np.ceil(_time(path, before, lock) * fps)) - (lock.first - before.last)
            left, right = (max(x.last - x.first + 1 - shortest, 0) for x in (before, lock))
            if short <= 0 or left + right == 0:
                break
            # half from each side, more from one where the other is too short
            take = min(right, max(short - short // 2, short - left))
            give = min(left, short - take)
            before, lock = replace(before, last=before.last - give), replace(lock, first=lock.first + take)
        out[i], out[i + 1] = before, lock
    return out


def _time(path: Array, before: Lock, lock: Lock) -> float:
    """Seconds that a foot needs from one lock to the next."""
    way = _way(before, lock)
    if lock.own:
        return _STEP_S + _STEP_S_PER_M * way
    change = lock.point - path[lock.first] - before.point + path[before.last]
    # even acceleration and braking by 6 way / time^2 at most
    bent = float(np.sqrt(6.0 * np.linalg.norm(change[:2]) / _HARDEST))
    return max(bent, _QUICK_S * min(float(np.cbrt(way / _QUICK_M)), 1.0))


def offsets(path: Array, locks: Sequence[Lock], halflife: float, fps: float) -> Array:
    """What to add to a toe's path `(T, 3)`: the way to the lock where it is held, smooth curves between.

    A step of the motion's foot is carried from lock to lock; one that it does not make goes straight.

    Args:
        path: `(T, 3)` the toe in the motion, metres.
        locks: in order.
        halflife: seconds in which half of a lock's offset is gone when the foot is in the air for long.
        fps: frames per second.
    """
    blend, slopes = max(2, round(4.0 * halflife * fps)), max(2.0, _SLOPE_S * fps)
    out = np.zeros_like(path)
    for lock in locks:
        span = slice(lock.first, lock.last + 1)
        out[span] = lock.point - path[span]
    # slopes against the path's own: the toe leaves and reaches a lock at rest
    slope = -np.gradient(path, axis=0) if len(path) > 1 else np.zeros_like(path)
    nothing = np.zeros(3), np.zeros(3)
    before: Lock | None = None
    for lock in locks:
        arrive = out[lock.first].copy(), slope[lock.first]
        far = before is None or lock.first - before.last > 2 * blend
        if before is not None:
            leave = out[before.last].copy(), slope[before.last]
            if lock.own:
                straight = (before.point, nothing[1]), (lock.point, nothing[1])
                _curve(out, before.last, lock.first, *straight, slopes)
                span = slice(before.last + 1, lock.first)
                out[span] -= path[span]
            elif far:
                _curve(out, before.last, before.last + blend, leave, nothing, slopes)
            else:
                _curve(out, before.last, lock.first, leave, arrive, slopes)
        if far and not lock.own:
            _curve(out, lock.first - blend, lock.first, nothing, arrive, slopes)
        before = lock
    if before is not None:
        leave = out[before.last].copy(), slope[before.last]
        _curve(out, before.last, before.last + blend, leave, nothing, slopes)
    return out


def clear(heights: Array, locks: Sequence[Lock], fps: float) -> Array:
    """Heights `(T,)` over the floor that stay above it by a little where no lock holds the foot."""
    least = np.zeros(len(heights))
    firsts, stops = [0, *(lock.last + 1 for lock in locks)], [*(lock.first for lock in locks), len(heights)]
    for i, (first, stop) in enumerate(zip(firsts, stops, strict=True)):
        place = (np.arange(first, stop) + 1.0 - first) / (stop - first + 1.0)
        highest = _CLEARANCE * min(1.0, (stop - first) / (_CLEARANCE_S * fps))
        if 0 < i < len(locks):
            lift = _LIFT + _LIFT_PER_M * _way(locks[i - 1], locks[i])
            highest += locks[i].stands * (lift - highest)
        least[first:stop] = highest * np.sin(np.pi * place) ** 2
    # a smooth maximum whose softness goes to nothing with the clearance
    apart = heights - least
    return least + 0.5 * (apart + np.sqrt(apart**2 + least**2))


def tilt(locks: Sequence[Lock], frames: int) -> Array:
    """Angles `(T,)` in radians by which the heel goes up in steps that the motion's foot does not make."""
    out = np.zeros(frames)
    for before, lock in pairwise(locks):
        if lock.own:
            place = np.linspace(0.0, 1.0, lock.first - before.last + 1)
            # most of it early, as a foot that pushes itself off
            bump = place**2 * (1.0 - place) ** 3 / (0.4**2 * 0.6**3)
            out[before.last : lock.first + 1] = _TILT * min(1.0, _way(before, lock) / _TILT_M) * bump
    return out


def _way(before: Lock, lock: Lock) -> float:
    return float(np.linalg.norm(lock.point - before.point))


def _curve(
    out: Array, first: int, last: int, start: tuple[Array, Array], end: tuple[Array, Array], slopes: float
) -> None:
    """Write a curve between two values with given slopes per frame, and no curvature, into the frames between.

    A slope is gone within so many frames: over a long way it would lead far off.
    """
    frames = np.arange(max(first + 1, 0), min(last, len(out)))
    t = ((frames - first) / (last - first))[:, None]
    passed = smootherstep(t)
    out[frames] = (1.0 - passed) * start[0] + passed * end[0]
    length = min(float(last - first), slopes)
    for slope, away in ((start[1], frames - first), (-end[1], last - frames)):
        t = np.minimum(away / length, 1.0)[:, None]
        out[frames] += length * t * (1.0 - t) ** 3 * (1.0 + 3.0 * t) * slope

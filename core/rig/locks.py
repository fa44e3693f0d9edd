"""When a foot is locked, where, and how it comes from one lock to the next."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]

_SHORTEST_S = 0.1
"""A contact shorter than this holds no foot, a gap shorter than this lets none go."""
_STEP_S = 0.25
"""Length of a short step by which a foot follows a motion that left its lock behind."""
_STEP_S_PER_M = 0.35
"""The same for each metre of its way: 0.4 m take 0.39 s, as people's steps on the spot do."""
_WAIT_S = 0.5
"""For so long at most such a step waits for the other foot to stand."""
_LIFT = 0.12
"""Height of such a step over its length."""
_CLEARANCE = 0.02
"""Metres a toe stays above the floor, about, in the middle of a step."""


@dataclass(frozen=True, slots=True)
class Lock:
    """A toe held at a point from its first to its last frame, both included."""

    first: int
    last: int
    point: Array
    """`(3,)` metres."""
    steps: bool
    """Whether the foot comes here by a step of its own from the lock before."""


def find_locks(
    path: Array, contacts: NDArray[np.bool_], height: float, unlock_distance: float, fps: float
) -> list[Lock]:
    """The locks of one foot.

    Each contact holds the toe at the middle of the box around its path. Where the path leaves that point by
    more than `unlock_distance` the lock ends and, if the contact goes on, the next one follows after a
    step.

    Args:
        path: `(T, 3)` the toe in the motion, metres.
        contacts: `(T,)` whether it is on the ground.
        height: of the toe joint over the floor when it stands, metres.
        unlock_distance: metres.
        fps: frames per second.
    """
    shortest, step = max(2, round(_SHORTEST_S * fps)), max(2, round(_STEP_S * fps))
    edges = np.flatnonzero(np.diff(contacts, prepend=False, append=False))
    if len(edges) > 2:
        short = np.flatnonzero(edges[2::2] - edges[1:-1:2] < shortest)
        edges = np.delete(edges, np.concatenate([2 * short + 1, 2 * short + 2]))
    locks: list[Lock] = []
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
                locks.append(Lock(begin, begin + count - 1, middle[count - 1], steps))
            steps = count >= shortest
            begin += max(count, 1) - 1 + step
    return locks


def take_turns(feet: Sequence[list[Lock]], fps: float) -> list[list[Lock]]:
    """Locks of both feet whose own steps take the time that their length asks for, and one foot at a time.

    A step waits for the other foot to stand as long as its own next lock leaves room for that.
    """
    out = [list(locks) for locks in feet]
    own = sorted(
        (lock.first, side, i) for side, locks in enumerate(out) for i, lock in enumerate(locks) if lock.steps
    )
    waiting = {(side, i) for _, side, i in own}
    for _, side, i in own:
        waiting.remove((side, i))
        before, lock = out[side][i - 1], out[side][i]
        way = float(np.linalg.norm(lock.point - before.point))
        length = round((_STEP_S + _STEP_S_PER_M * way) * fps)
        latest = lock.last - max(2, round(_SHORTEST_S * fps)) - length
        start = before.last
        other = out[1 - side]
        for k, (left, back) in enumerate(pairwise(other), start=1):
            # a step that is still to be placed will wait for this one
            overlaps = left.last < start + length and start < back.first and (1 - side, k) not in waiting
            if overlaps and back.first <= min(latest, before.last + _WAIT_S * fps):
                start = back.first
        if start <= latest:
            out[side][i - 1], out[side][i] = replace(before, last=start), replace(lock, first=start + length)
    return out


def offsets(path: Array, locks: list[Lock], blend: int) -> Array:
    """What to add to a toe's path `(T, 3)`: the way to the lock where it is held, smooth curves between.

    Args:
        path: `(T, 3)` the toe in the motion, metres.
        locks: in order.
        blend: frames after which a foot in the air is back on its path.
    """
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
        if before is None or lock.first - before.last > 2 * blend:
            _curve(out, lock.first - blend, lock.first, nothing, arrive)
        if before is not None:
            leave = out[before.last].copy(), slope[before.last]
            if lock.first - before.last > 2 * blend:
                _curve(out, before.last, before.last + blend, leave, nothing)
            else:
                _curve(out, before.last, lock.first, leave, arrive)
            if lock.steps:
                out[before.last : lock.first + 1, 2] += _step(before, lock)
        before = lock
    if before is not None:
        leave = out[before.last].copy(), slope[before.last]
        _curve(out, before.last, before.last + blend, leave, nothing)
    return out


def clear(heights: Array, held: NDArray[np.bool_], fps: float) -> Array:
    """Heights `(T,)` over the floor that stay above it by a little where the foot is not `held` `(T,)`."""
    air = np.flatnonzero(np.diff(held, prepend=True, append=True)).reshape(-1, 2)
    least = np.zeros(len(held))
    for first, stop in air.tolist():
        place = (np.arange(first, stop) + 1.0 - first) / (stop - first + 1.0)
        highest = _CLEARANCE * min(1.0, (stop - first) / (_STEP_S * fps))
        least[first:stop] = highest * np.sin(np.pi * place) ** 2
    # a smooth maximum whose softness goes to nothing with the clearance
    apart = heights - least
    return least + 0.5 * (apart + np.sqrt(apart**2 + least**2))


def _step(before: Lock, lock: Lock) -> Array:
    """Extra height of a toe through a step from one lock to the next, both ends included."""
    place = np.linspace(0.0, 1.0, lock.first - before.last + 1)
    return _LIFT * float(np.linalg.norm(lock.point - before.point)) * (4.0 * place * (1.0 - place)) ** 2


def _curve(out: Array, first: int, last: int, start: tuple[Array, Array], end: tuple[Array, Array]) -> None:
    """Write the cubic between two values with given slopes per frame into the frames between two."""
    frames = np.arange(max(first + 1, 0), min(last, len(out)))
    t = ((frames - first) / (last - first))[:, None]
    length = float(last - first)
    out[frames] = (
        (1.0 + 2.0 * t) * (1.0 - t) ** 2 * start[0]
        + length * t * (1.0 - t) ** 2 * start[1]
        + t**2 * (3.0 - 2.0 * t) * end[0]
        + length * t**2 * (t - 1.0) * end[1]
    )

"""Fewer keys: those without which a pose, interpolated in straight lines, is off by more than a given distance.

Keys are added where they are missed most, between all that there are, on every bone at once, until each bone alone
keeps its share of the limit (Douglas and Peucker's way); then wherever forward kinematics still finds a point too far
away. A turn counts by what it moves at the longest lever below it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body import hierarchy
from ..maths import quat

Array = NDArray[np.floating[Any]]
Mask = NDArray[np.bool_]

SHARE = 0.6
"""Of the limit, what one bone may use up by itself: errors along a limb seldom add up."""
_TOLD = 0.5
"""Bones get a key that have this much of the greatest part in a point's error."""


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """The channels of one bone's rotation or location, keyed at the same frames."""

    bone: int
    values: Array
    """`(T, C)` as keyed, a value each frame."""
    turn: Callable[[Array], Array] | None
    """From values to unit quaternions `(T, 4)`; None for a location in the bone's own rest axes."""


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """Bones that are keyed, as they hang on each other; lengths in any unit."""

    parents: NDArray[np.intp]
    """`(B,)` index of the nearest keyed bone above, -1 for none; parents before children."""
    rest: Array
    """`(B, 4, 4)` rest in the armature's space."""
    tails: Array
    """`(B, 3)` ends of the bones, likewise."""
    loose: Mask
    """`(B,)` bones that take on the place of what they hang on, and not its rotation."""

    def points(self, rotations: Array, locations: Array) -> tuple[Array, Array]:
        """Heads and tails, each `(T, B, 3)`, of a pose.

        Args:
            rotations: `(T, B, 4)` since rest, in the bones' own rest axes.
            locations: `(T, B, 3)` likewise.
        """
        rest = quat.from_matrix(self.rest[:, :3, :3])
        turns, heads = np.empty_like(rotations), np.empty_like(locations)
        tails = np.empty_like(locations)
        for b, above in enumerate(self.parents):
            hang, place = rest[b], self.rest[b, :3, 3]
            turn = np.broadcast_to(hang, rotations[:, b].shape)
            head = place + quat.rotate(turn, locations[:, b])
            if above >= 0:
                back = quat.multiply(turns[:, above], quat.conjugate(rest[above]))
                head = heads[:, above] + quat.rotate(back, head - self.rest[above, :3, 3])
                turn = turn if self.loose[b] else quat.multiply(back, turn)
            turns[:, b] = quat.multiply(turn, rotations[:, b])
            heads[:, b] = head
            along = quat.rotate(quat.conjugate(hang), self.tails[b] - place)
            tails[:, b] = head + quat.rotate(turns[:, b], along)
        return heads, tails


@dataclass(frozen=True, slots=True, eq=False)
class Fewer:
    """Which keys are kept."""

    kept: Mask
    """`(T, N)` for each track."""
    worst: float
    """How far the farthest head or tail of a bone is from where all keys have it, in the chain's unit."""


def fewer_keys(chain: Chain, tracks: Sequence[Track], limit: float) -> Fewer:
    """Choose the keys between which straight lines keep all heads and tails within a distance, at every frame.

    Args:
        chain: the bones.
        tracks: what is keyed on them, of one length.
        limit: above 0, in the chain's unit.
    """
    frames = len(tracks[0].values)
    kept = np.zeros((frames, len(tracks)), dtype=bool)
    kept[[0, -1]] = True
    full = _Pose(chain, tracks, [track.values for track in tracks])
    levers = _levers(chain, full)
    while True:
        between = _Pose(chain, tracks, _interpolated(tracks, kept))
        own = np.stack([_moved(tracks[n], full, between, n, levers) for n in range(len(tracks))], axis=1)
        if _add_worst(kept, own, SHARE * limit):
            continue
        away = between.away_from(full)
        if not _add_where_off(chain, tracks, kept, own, away, limit):
            return Fewer(kept, float(away.max(initial=0.0)))


class _Pose:
    """A pose of the chain from the values of its tracks."""

    def __init__(self, chain: Chain, tracks: Sequence[Track], values: Sequence[Array]) -> None:
        frames, bones = len(values[0]), len(chain.parents)
        self.chain = chain
        self.rotations = np.tile(quat.IDENTITY, (frames, bones, 1))
        self.locations = np.zeros((frames, bones, 3))
        for track, value in zip(tracks, values, strict=True):
            if track.turn is None:
                self.locations[:, track.bone] = value
            else:
                self.rotations[:, track.bone] = track.turn(value)

    def points(self) -> tuple[Array, Array]:
        """Heads and tails, each `(T, B, 3)`."""
        return self.chain.points(self.rotations, self.locations)

    def away_from(self, other: _Pose) -> Array:
        """Distance `(T, B)` of heads and tails, the greater of the two."""
        pairs = zip(self.points(), other.points(), strict=True)
        heads, tails = (np.linalg.norm(a - b, axis=-1) for a, b in pairs)
        return np.maximum(heads, tails)


def _levers(chain: Chain, pose: _Pose) -> Array:
    """For each bone the distance `(T, B)` of its head to the farthest point that it moves."""
    heads, tails = pose.points()
    out = np.linalg.norm(tails - heads, axis=-1)
    for b in range(len(chain.parents)):
        for above in hierarchy.above(chain.parents, b):
            far = np.linalg.norm(tails[:, b] - heads[:, above], axis=-1)
            out[:, above] = np.maximum(out[:, above], far)
    return out


def _moved(track: Track, full: _Pose, between: _Pose, n: int, levers: Array) -> Array:
    """What a track by itself moves `(T,)` at the end of its lever."""
    b = track.bone
    if track.turn is None:
        return np.linalg.norm(between.locations[:, b] - full.locations[:, b], axis=-1)
    apart = quat.multiply(quat.conjugate(full.rotations[:, b]), between.rotations[:, b])
    return 2.0 * np.linalg.norm(apart[:, 1:], axis=-1) * levers[:, b]


def _interpolated(tracks: Sequence[Track], kept: Mask) -> list[Array]:
    """Values of all tracks at all frames, in straight lines between the kept ones."""
    frames = np.arange(len(kept))
    before = np.maximum.accumulate(np.where(kept, frames[:, None], 0), axis=0)
    last = len(kept) - 1
    after = np.minimum.accumulate(np.where(kept, frames[:, None], last)[::-1], axis=0)[::-1]
    share = (frames[:, None] - before) / np.maximum(after - before, 1)
    return [
        track.values[before[:, n]] * (1.0 - share[:, n, None]) + track.values[after[:, n]] * share[:, n, None]
        for n, track in enumerate(tracks)
    ]


def _add_worst(kept: Mask, error: Array, limit: float | Array) -> bool:
    """Keep the worst frame of every stretch between two keys that has one over the limit; whether there was any."""
    added = False
    for n in np.flatnonzero((error > limit).any(axis=0)):
        starts = np.flatnonzero(kept[:, n])[:-1]
        peaks = np.maximum.reduceat(error[:-1, n], starts)
        worst = np.repeat(peaks, np.diff(np.append(starts, len(kept) - 1)))
        found = (error[:-1, n] >= worst) & (error[:-1, n] > limit) & ~kept[:-1, n]
        # one of several that are equally bad
        at = np.flatnonzero(found)
        stretch = np.searchsorted(starts, at, side="right")
        _, first = np.unique(stretch, return_index=True)
        kept[at[first], n] = True
        added |= len(at) > 0
    return added


def _add_where_off(
    chain: Chain, tracks: Sequence[Track], kept: Mask, own: Array, away: Array, limit: float
) -> bool:
    """Keep frames of the tracks that have most part in points that are too far away; whether there were any."""
    blamed = np.zeros_like(own)
    for b in np.flatnonzero((away > limit).any(axis=0)):
        line = {b, *hierarchy.above(chain.parents, int(b))}
        parts = [n for n, track in enumerate(tracks) if track.bone in line]
        part = np.where(kept[:, parts], 0.0, own[:, parts])
        most = part.max(axis=1, keepdims=True)
        due = (away[:, b, None] > limit) & (part >= _TOLD * most) & ~kept[:, parts]
        blamed[:, parts] = np.maximum(blamed[:, parts], np.where(due, away[:, b, None], 0.0))
    return _add_worst(kept, blamed, limit)

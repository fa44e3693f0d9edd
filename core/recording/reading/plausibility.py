"""What a person can do, measured in a file's own axes, so that every way of reading it can be scored at once.

All figures are medians, shares or fits over the whole recording: who lies, crawls or looks at the sky for a moment is
still a person. For each device axis and each world axis they hold for the positive direction; the negative one has the
sign turned, and mirrored axes need no new figures.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...maths import quat
from ..raw import RawRecording, Track
from ..recording import Array
from .rotations import to_quaternions

MOST = 300
"""Moments that are looked at."""
_STEP_S = 0.05
"""Seconds between the two samples of a moment: long enough for noise, short enough for a turn."""
_LEAST_TURN = 0.25
"""rad/s: slower turns tell nothing of where a device is held."""


@dataclass(frozen=True, slots=True, eq=False)
class Moments:
    """Pairs of samples of the three trackers shortly after one another, in the file's numbers."""

    seconds: Array
    """`(N,)` between the two; NaN where the time unit is unknown."""
    positions: Array
    """`(2, N, 3, 3)` first and second sample, tracker, xyz."""
    values: tuple[Array, Array, Array]
    """Of each tracker `(2, N, k)`: rotations as written."""
    known: NDArray[np.bool_]
    """`(N, 3)` whether both samples of a tracker are there."""


@dataclass(frozen=True, slots=True, eq=False)
class Figures:
    """What one way of writing rotations makes of a recording; world axes, then device axes where there are two."""

    upright: Array
    """`(3, 3)` median component along a world axis of the headset's axis."""
    ahead: Array
    """`(3, 3, 2)` [up axis, forward axis, hand]: share of the time that the hand is on the axis' side of the head."""
    left: Array
    """`(3, 3)` [up axis, forward axis]: share of the time that the left hand is on the left of the right one, axes
    taken as right-handed; NaN without both."""
    beside: Array
    """`(3, 3, 2)` the same of each hand and the head."""
    lever: Array
    """`(3, 3)` [tracker, device axis]: units from the point about which the device turns to the device."""
    lever_spread: Array
    """`(3,)` standard error of these."""
    fit: Array
    """`(3,)` share of each tracker's movement that its turns about such a point explain: high where rotations are read
    right."""
    turned: float
    """Mean angle, radians, of the trackers' turns from the first to the second sample: angles that are put together in
    a wrong order turn further than the device did. 0 where nothing turns."""
    below: Array
    """`(3,)` share of the time that the hands are on the negative side of the head along a world axis."""
    walk: Array
    """`(3, 3)` [up axis, forward axis] cosine between the way walked and the headset's axis, -1 to 1."""
    walked: float
    """Units walked."""
    pointing: Array
    """`(2, 3, 3)` [hand, up axis, device axis]: median of how far a hand's axis points where the headset's same axis
    points."""


def take_moments(raw: RawRecording, seconds: float = 1.0) -> Moments | None:
    """Moments spread over a recording; None where the headset has fewer than three samples.

    Args:
        raw: the file's numbers.
        seconds: of the file's unit of time.
    """
    head = raw.tracks[0]
    finite = np.isfinite(head.times) & head.valid & np.isfinite(head.positions).all(-1)
    rows = np.flatnonzero(finite & (np.abs(head.positions).sum(-1) > 0.0))
    if len(rows) < 3:
        return None
    step = float(np.median(np.abs(np.diff(head.times[rows])))) * seconds
    ahead = min(max(round(_STEP_S / step), 1), 30, len(rows) - 1) if step > 0.0 else 1
    starts = np.unique(np.linspace(0, len(rows) - 1 - ahead, min(MOST, len(rows) - ahead)).astype(np.intp))
    pairs = np.stack([rows[starts], rows[starts + ahead]])
    picked = [_pick(track, head.times[pairs], pairs, track is head) for track in raw.tracks]
    return Moments(
        seconds=(head.times[pairs[1]] - head.times[pairs[0]]) * seconds,
        positions=np.stack([positions for positions, _, _ in picked], axis=2),
        values=(picked[0][1], picked[1][1], picked[2][1]),
        known=np.stack([known for _, _, known in picked], axis=1),
    )


def _pick(
    track: Track, times: Array, rows: NDArray[np.intp], same: bool
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """A track's samples nearest to some times, `(2, N, 3)`, `(2, N, k)`, and whether they can be used `(N,)`."""
    count = len(track.times)
    if count < 2:
        moments, width = int(times.shape[1]), int(track.rotations.shape[-1])
        return np.zeros((2, moments, 3)), np.zeros((2, moments, width)), np.zeros(moments, dtype=np.bool_)
    if not same:
        rows = np.clip(np.searchsorted(track.times, times), 1, count - 1)
        rows = rows - (times - track.times[rows - 1] < track.times[rows] - times)
    positions, values = track.positions[rows], track.rotations[rows]
    known = track.valid[rows] & np.isfinite(positions).all(-1) & np.isfinite(values).all(-1)
    known &= (positions != 0.0).any(-1) & (values != 0.0).any(-1)
    both: Any = known[0] & known[1]
    return np.nan_to_num(positions), values, both


def moving(moments: Moments) -> NDArray[np.bool_]:
    """`(3,)` whether a tracker moves at all: one that sleeps tells nothing."""
    out = np.zeros(3, np.bool_)
    for i in range(3):
        places = moments.positions[0, moments.known[:, i], i]
        out[i] = len(places) > 2 and bool((np.ptp(places, axis=0) > 0.0).any())
    return out


def measure(moments: Moments, rotation: str, hands: str) -> Figures:
    """The figures of one way of writing rotations.

    Args:
        moments: of a recording.
        rotation: how rotations are written, one of `rotations.KINDS`.
        hands: where positions of hands are, as in `Reading`.
    """
    turns = [_unit(to_quaternions(values, rotation)) for values in moments.values]
    turned = _turned(moments, turns)
    positions, turns = in_world(moments.positions, turns, hands)
    axes = [quat.to_matrix(turn[0]) for turn in turns]
    known = moments.known & moving(moments)
    head = axes[0][known[:, 0]]
    upright = np.median(head, axis=0) if len(head) else np.zeros((3, 3))
    ahead, beside, left = _sides(positions[0], axes[0], known)
    levers = [_lever(moments, positions, turns, i, known) for i in range(3)]
    walk, walked = _walk(moments, positions, axes[0], known)
    return Figures(
        upright=upright,
        ahead=ahead,
        left=left,
        beside=beside,
        lever=np.stack([lever for lever, _, _ in levers]),
        lever_spread=np.array([spread for _, spread, _ in levers]),
        fit=np.array([fit for _, _, fit in levers]),
        turned=turned,
        below=_below(positions[0], known),
        walk=walk,
        walked=walked,
        pointing=np.stack([_pointing(axes[0], axes[i], known[:, 0] & known[:, i]) for i in (1, 2)]),
    )


def in_world(positions: Array, turns: list[Array], hands: str) -> tuple[Array, list[Array]]:
    """Positions `(..., 3, 3)` and the three trackers' rotations with the hands in the world, in the file's axes."""
    if hands == "world":
        return positions, turns
    head = positions[..., :1, :]
    if hands == "offset":
        return np.concatenate([head, head + positions[..., 1:, :]], axis=-2), turns
    turned = [quat.rotate(turns[0], positions[..., i, :]) for i in (1, 2)]
    placed = np.stack([positions[..., 0, :], *(positions[..., 0, :] + part for part in turned)], axis=-2)
    return placed, [turns[0], *(quat.multiply(turns[0], turn) for turn in turns[1:])]


def _unit(q: Array) -> Array:
    return quat.normalize(np.nan_to_num(q))


def _turned(moments: Moments, turns: list[Array]) -> float:
    """Mean angle between the two samples of all trackers that are known, radians."""
    angles = [
        2.0 * np.arccos(np.clip(np.abs((turn[0] * turn[1]).sum(-1)), 0.0, 1.0))[moments.known[:, i]]
        for i, turn in enumerate(turns)
    ]
    every: Array = np.concatenate(angles)
    return float(every.mean()) if every.size else 0.0


def _flat(vectors: Array, up: int) -> Array:
    """Vectors without their component along an axis."""
    out = vectors.copy()
    out[..., up] = 0.0
    return out


def _sides(positions: Array, axes: Array, known: NDArray[np.bool_]) -> tuple[Array, Array, Array]:
    """Of both hands: how often ahead and beside the head; how often the left one is on the left."""
    ahead, beside, left = np.full((3, 3, 2), np.nan), np.full((3, 3, 2), np.nan), np.full((3, 3), np.nan)
    offsets = positions[:, 1:] - positions[:, :1]
    both = known.all(axis=1)
    for up in range(3):
        for forward in range(3):
            direction = _flat(axes[:, :, forward], up)
            across = np.cross(np.eye(3)[up], direction)
            for hand in range(2):
                use = known[:, 0] & known[:, hand + 1]
                if use.any():
                    part = offsets[use, hand]
                    ahead[up, forward, hand] = np.mean((part * direction[use]).sum(-1) > 0.0)
                    beside[up, forward, hand] = np.mean((part * across[use]).sum(-1) > 0.0)
            if both.any():
                apart = offsets[both, 0] - offsets[both, 1]
                left[up, forward] = np.mean((apart * across[both]).sum(-1) > 0.0)
    return ahead, beside, left


def _lever(
    moments: Moments, positions: Array, turns: list[Array], i: int, known: NDArray[np.bool_]
) -> tuple[Array, float, float]:
    """Where a device sits from the point about which it turns, in its own axes; how sure and how telling that is.

    A head turns about its neck, a forearm about its elbow: v = w x (R l) + drift, fitted over quick turns for l.
    """
    use = known[:, 0] & known[:, i] & (moments.seconds > 0.0)
    seconds = moments.seconds[use, None]
    first, second = turns[i][0][use], turns[i][1][use]
    spin = quat.to_rotation_vector(quat.multiply(second, quat.conjugate(first))) / seconds
    speed = np.linalg.norm(spin, axis=-1)
    velocity = (positions[1, use, i] - positions[0, use, i]) / seconds
    if i > 0:
        velocity = velocity - (positions[1, use, 0] - positions[0, use, 0]) / seconds
    good = (speed > _LEAST_TURN) & (speed < 20.0)
    if good.sum() < 8:
        return np.zeros(3), np.inf, 0.0
    axes = quat.to_matrix(first[good])
    columns = np.stack([np.cross(spin[good], axes[:, :, k]) for k in range(3)], axis=-1)
    # quick turns must not outweigh the many slow ones
    weight = 1.0 / (0.5 + speed[good])[:, None, None]
    a: Array = (columns * weight).reshape(-1, 3)
    b: Array = (velocity[good][..., None] * weight).reshape(-1)
    normal: Array = a.T @ a + 1e-3 * np.trace(a.T @ a) / 3.0 * np.eye(3)
    lever: Array = np.linalg.solve(normal, a.T @ b)
    rest: Array = b - a @ lever
    spread: Any = np.sqrt(rest @ rest / max(len(b) - 3, 1) * np.trace(np.linalg.inv(normal)) / 3.0)
    return lever, float(spread), float(1.0 - rest @ rest / max(b @ b, 1e-12))


def _below(positions: Array, known: NDArray[np.bool_]) -> Array:
    """How often hands are on the negative side of the head; NaN without hands."""
    offsets = positions[:, 1:] - positions[:, :1]
    use = known[:, :1] & known[:, 1:]
    return np.mean(offsets[use] < 0.0, axis=0) if use.any() else np.full(3, np.nan)


def _walk(moments: Moments, positions: Array, axes: Array, known: NDArray[np.bool_]) -> tuple[Array, float]:
    """How far the way that the head goes lies along its own axes, weighted by the way."""
    use = known[:, 0]
    way = (positions[1, :, 0] - positions[0, :, 0])[use]
    out, walked = np.zeros((3, 3)), 0.0
    for up in range(3):
        flat = _flat(way, up)
        # sway of who stands is no way: the mean of neighbours is
        length = np.linalg.norm(flat, axis=-1)
        for forward in range(3):
            direction = _flat(axes[use][:, :, forward], up)
            size = np.maximum(np.linalg.norm(direction, axis=-1), 1e-9)
            out[up, forward] = ((flat * direction).sum(-1) / size).sum() / max(length.sum(), 1e-12)
        walked = max(
            walked, float(np.linalg.norm(np.ptp(positions[0, use, 0], axis=0))) if use.any() else 0.0
        )
    return out, walked


def _pointing(head: Array, hand: Array, use: NDArray[np.bool_]) -> Array:
    """How far a hand's axes point where the headset's do, level, `(3, 3)` [up axis, device axis]."""
    out = np.zeros((3, 3))
    if not use.any():
        return out
    for up in range(3):
        for axis in range(3):
            a, b = _flat(head[use][:, :, axis], up), hand[use][:, :, axis]
            size = np.maximum(np.linalg.norm(a, axis=-1), 1e-9)
            out[up, axis] = np.median((a * b).sum(-1) / size)
    return out

"""What goes wrong while recording and can be put right: clocks that start again, controllers that change hands."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..raw import RawRecording, Track
from ..recording import Array

_RESTART_S = 1.0
_COARSE = 0.2
"""Share of samples without a time of their own that is worth a doubt."""
_NEARER = 0.35
"""Of the way that both controllers would have jumped, how much is left when they are exchanged."""
_APART_M = 0.12
"""Hands that touch may be mixed up without a trace."""


def one_clock(raw: RawRecording) -> RawRecording:
    """The recording with parts whose clock starts again behind those before, and a doubt that says so."""
    starts = _restarts(raw.tracks[0].times)
    if len(starts) == 0:
        return raw
    tracks = tuple(_continued(track) for track in raw.tracks)
    at = tracks[0].times[starts] - tracks[0].times[0]
    times = ", ".join(f"{second:.1f}" for second in at[:3])
    doubt = f"the clock starts again at {times} s: the parts are joined; cut out what is not wanted"
    extra = tuple(replace(item, track=_continued(item.track)) for item in raw.extra)
    return replace(raw, tracks=(tracks[0], tracks[1], tracks[2]), extra=extra, doubts=(*raw.doubts, doubt))


def _restarts(times: Array) -> NDArray[np.intp]:
    """Samples at which a clock has gone back to about where it began, and then runs for as long as a second."""
    if len(times) < 4:
        return np.empty(0, dtype=np.intp)
    begin = times[0]
    back: NDArray[np.intp] = np.flatnonzero(np.diff(times) < -_RESTART_S) + 1
    ends = np.append(back, len(times))[1:]
    runs = [
        start
        for start, end in zip(back.tolist(), ends.tolist(), strict=True)
        if times[start] - begin < 0.5 * (times[start - 1] - begin)
        and times[end - 1] - times[start] > _RESTART_S
    ]
    return np.array(runs, dtype=np.intp)


def _continued(track: Track) -> Track:
    times = np.array(track.times)
    step = float(np.median(np.abs(np.diff(times)))) if len(times) > 1 else 0.0
    for start in _restarts(track.times).tolist():
        times[start:] += times[start - 1] + step - times[start]
    return replace(track, times=times)


def coarse(raw: RawRecording) -> tuple[str, ...]:
    """A doubt where many samples have the time of the one before."""
    times = raw.tracks[0].times
    steps: Array = np.diff(times)
    share = np.count_nonzero(steps == 0.0) / max(len(steps), 1)
    if share < _COARSE:
        return ()
    return (
        f"{share:.0%} of the samples have the time of the one before and are left out: its clock is too coarse",
    )


def unswapped(raw: RawRecording) -> tuple[RawRecording, tuple[str, ...]]:
    """The recording with controllers back in their hands where they change places between two samples, and a doubt.

    Both jump to where the other one was: no hands do that. For tracks with the same times, in metres.
    """
    head, left, right = raw.tracks
    if (
        len(left.times) != len(right.times)
        or len(left.times) < 3
        or not np.array_equal(left.times, right.times)
    ):
        return raw, ()
    known = (
        left.valid & right.valid & np.isfinite(left.positions).all(-1) & np.isfinite(right.positions).all(-1)
    )
    rows = np.flatnonzero(known)
    a, b = left.positions[rows], right.positions[rows]

    def step(x: Array, y: Array) -> Array:
        way: Any = np.linalg.norm(x[1:] - y[:-1], axis=-1)
        return way

    stay, change = step(a, a) + step(b, b), step(a, b) + step(b, a)
    apart = np.linalg.norm(a - b, axis=-1)
    swaps = rows[1:][(change < _NEARER * stay) & (apart[1:] > _APART_M) & (apart[:-1] > _APART_M)]
    if len(swaps) == 0:
        return raw, ()
    other = np.zeros(len(left.times), dtype=np.bool_)
    for at in swaps.tolist():
        other[at:] ^= True
    if other.mean() > 0.5:
        # what holds most of the time is as it was meant
        other = ~other
    seconds = ", ".join(f"{left.times[at] - head.times[0]:.1f}" for at in swaps[:3].tolist())
    doubt = f"left and right controller change places at {seconds} s: put back"
    return replace(raw, tracks=(head, _mixed(left, right, other), _mixed(right, left, other))), (doubt,)


def _mixed(one: Track, two: Track, other: NDArray[np.bool_]) -> Track:
    positions, rotations, valid = one.positions.copy(), one.rotations.copy(), one.valid.copy()
    positions[other], rotations[other], valid[other] = (
        two.positions[other],
        two.rotations[other],
        two.valid[other],
    )
    return Track(one.times, positions, rotations, valid)

"""Repair of recorded samples, and what was repaired: order, empty poses, sleep, jumps, gaps."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..bounds import FARTHEST, RECORDING_RATE
from ..errors import InputError
from ..maths import quat
from .happenings import NAMES
from .interpolation import blend_positions, blend_rotations, neighbours
from .raw import Extra, RawRecording, Track
from .recording import Array, ExtraTracker, Happening
from .timeline import Samples, at_times, check_pauses, even_out, fill_pauses, join

_FROZEN_S = 0.5
_MOVED_M = 0.001
_JUMP_SPEEDS = (10.0, 40.0, 40.0)
"""m/s that head and hands do not reach: a fast punch is 15, a swung wand's end 30."""
_GLITCH_S = 0.5
_DRIFT_S = 0.15
"""A controller that jumps was lost for about this long before."""
_AT_THE_HIP = np.array([[-0.22, 0.10, -0.75], [0.22, 0.10, -0.75]])
"""Metres from the headset, in its heading, to a hand that hangs down with the elbow a little bent."""


@dataclass(frozen=True, slots=True, eq=False)
class Repaired:
    """Samples without faults, and what was done to them."""

    samples: Samples
    repairs: tuple[str, ...]
    happenings: tuple[Happening, ...]
    extra: tuple[ExtraTracker, ...] = ()


def repair(raw: RawRecording, file: str) -> Repaired:
    """The three trackers on one timeline, finite everywhere; bridged rather than recorded where not `valid`.

    Raises:
        InputError: the headset has fewer than two usable samples, their rate is no recorder's, or a pause is
            too long.
    """
    tracks = tuple(_in_order(track) for track in raw.tracks)
    head, left, right = (_usable(track) for track in tracks)
    if head.valid.sum() < 2:
        usable = _samples(int(head.valid.sum()))
        raise InputError(f"{file}: {usable} of the headset can be used; record it again")
    rate = 1.0 / float(np.median(np.diff(head.times)))
    if not RECORDING_RATE[0] <= rate <= RECORDING_RATE[1]:
        raise InputError(f"{file}: {rate:.3g} samples per second; are its times in another unit?")
    check_pauses(head.times, file)
    dropped = [len(old.times) - len(new.times) for old, new in zip(raw.tracks, tracks, strict=True)]
    empty = [
        int((old.valid & ~new.valid).sum()) for old, new in zip(tracks, (head, left, right), strict=True)
    ]
    repairs = [
        *_told([_samples(n) + " at repeated or earlier times dropped" if n else "" for n in dropped]),
        *_told([_samples(n) + " without a pose" if n else "" for n in empty]),
    ]
    samples, jitter = even_out(join((head, left, right)))
    samples, pauses = fill_pauses(samples)
    repairs += [note for note in (jitter, pauses) if note]
    samples, frozen, still = _mark_frozen(samples, raw.states_validity)
    samples, glitches, jumps = _mark_jumps(samples)
    return Repaired(
        _bridge(samples),
        (*repairs, *frozen, *glitches),
        (*still, *jumps, *_happenings("lost", samples, ~samples.valid)),
        tuple(_extra(item, samples.times + head.times[0], samples.times) for item in raw.extra),
    )


def _extra(item: Extra, times: Array, shown: Array) -> ExtraTracker:
    """Another tracker at the headset's times, `times` on the file's clock; held where it was not tracked."""
    track = at_times(_usable(_in_order(item.track)), times)
    known = np.flatnonzero(track.valid)
    positions, rotations = track.positions, track.rotations
    if len(known):
        ends = known if len(known) > 1 else np.repeat(known, 2)
        before, share = _between(shown[ends], shown)
        positions = np.where(track.valid[:, None], positions, blend_positions(positions[ends], before, share))
        rotations = np.where(track.valid[:, None], rotations, blend_rotations(rotations[ends], before, share))
    return ExtraTracker(item.name, positions, quat.continuous(quat.normalize(rotations)), track.valid)


def _told(notes: list[str]) -> list[str]:
    """Notes on the three trackers, "" for none, each with its tracker's name."""
    if notes[0] and notes.count(notes[0]) == len(notes):
        return [f"all trackers: {notes[0]}"]
    return [f"{name}: {note}" for name, note in zip(NAMES, notes, strict=True) if note]


def _mark_frozen(samples: Samples, believe: bool) -> tuple[Samples, list[str], list[Happening]]:
    """The samples without sleeping trackers' ones, lines on repairs, and what is only doubted.

    Args:
        samples: all trackers.
        believe: whether the file tells itself when a tracker slept; then a still one is only doubted.
    """
    flags = np.stack([_frozen(samples, i) for i in range(len(NAMES))], axis=1)
    if believe:
        return samples, [], _happenings("still", samples, flags)
    seconds = [_seconds(samples, column) for column in flags.T]
    notes = [f"{stood:.2f} s frozen, asleep or out of sight" if stood else "" for stood in seconds]
    return replace(samples, valid=samples.valid & ~flags), _told(notes), []


def _mark_jumps(samples: Samples) -> tuple[Samples, list[str], list[Happening]]:
    """The samples without those off the path and before jumps for good, lines on repairs, and the jumps."""
    notes: list[str] = []
    happenings: list[Happening] = []
    valid = samples.valid.copy()
    for i in range(len(NAMES)):
        glitches, jumps = _jumps(samples, i)
        notes.append(f"{_seconds(samples, glitches):.2f} s off its path" if glitches.any() else "")
        times = samples.times[jumps]
        if len(jumps):
            happenings.append(Happening("jump", i, times, times))
        valid[glitches, i] = False
        if i > 0:
            for end in times:
                valid[(samples.times > end - _DRIFT_S) & (samples.times <= end), i] = False
    return replace(samples, valid=valid), _told(notes), happenings


def _happenings(kind: str, samples: Samples, flags: NDArray[np.bool_]) -> list[Happening]:
    """One for each tracker with flagged samples; each of these lasts until the next one."""
    ends = np.append(samples.times[1:], samples.times[-1] + np.median(np.diff(samples.times)))
    runs = [_runs(column) for column in flags.T]
    return [
        Happening(kind, i, samples.times[firsts], ends[lasts])
        for i, (firsts, lasts) in enumerate(runs)
        if len(firsts)
    ]


def _samples(count: int) -> str:
    return "1 sample" if count == 1 else f"{count} samples"


def _in_order(track: Track) -> Track:
    """The samples whose time is later than all before them."""
    times = np.where(np.isfinite(track.times), track.times, -np.inf)
    latest = np.maximum.accumulate(np.r_[-np.inf, times])[:-1]
    keep = times > latest
    return Track(track.times[keep], track.positions[keep], track.rotations[keep], track.valid[keep])


def _usable(track: Track) -> Track:
    """Unit rotations, finite values; not valid where the file has no pose or zeros for one."""
    # comparisons with NaN are false
    finite = np.asarray((np.abs(np.c_[track.positions, track.rotations]) < FARTHEST).all(axis=-1))
    rotations = np.where(finite[:, None], track.rotations, 0.0)
    positions = np.where(finite[:, None], track.positions, 0.0)
    turned = np.linalg.norm(rotations, axis=-1) > 0.1
    placed = (positions != 0.0).any(axis=-1)
    return Track(track.times, positions, quat.normalize(rotations), track.valid & finite & turned & placed)


def _runs(flags: NDArray[np.bool_]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """First and last index of each run of True."""
    edges = np.diff(np.r_[0, flags, 0])
    return np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1


def _seconds(samples: Samples, flags: NDArray[np.bool_]) -> float:
    """How long flagged samples last together."""
    return float(flags.mean() * (samples.times[-1] + np.median(np.diff(samples.times))))


def _frozen(samples: Samples, i: int) -> NDArray[np.bool_]:
    """Where a tracker repeats its position exactly for long while another one moves; held hands tremble."""
    times, positions = samples.times, samples.positions
    valid = samples.valid
    same = np.r_[False, (positions[1:, i] == positions[:-1, i]).all(axis=-1)] & valid[:, i]
    same[1:] &= valid[:-1, i]
    others = [j for j in range(len(NAMES)) if j != i]
    out = np.zeros(len(times), dtype=np.bool_)
    for first, last in zip(*_runs(same), strict=True):
        if times[last] - times[first - 1] < _FROZEN_S:
            continue
        span = slice(first - 1, last + 1)
        moved = [
            np.ptp(positions[span, j][valid[span, j]], axis=0).max() for j in others if valid[span, j].any()
        ]
        # the first sample of the run was still tracked, but for a tracker that has slept from the beginning
        out[first - (first == 1) : last + 1] = max(moved, default=0.0) > _MOVED_M
    return out


def _jumps(samples: Samples, i: int) -> tuple[NDArray[np.bool_], NDArray[np.intp]]:
    """Samples off a tracker's path that come back within a moment, and the last before each jump for good."""
    known = np.flatnonzero(samples.valid[:, i])
    glitches = np.zeros(len(samples.times), dtype=np.bool_)
    times, positions = samples.times[known], samples.positions[known, i]
    steps = np.maximum(np.diff(times), 0.5 * np.median(np.diff(samples.times)))
    far = np.linalg.norm(np.diff(positions, axis=0), axis=-1)
    starts = np.flatnonzero(far > _JUMP_SPEEDS[i] * steps)
    for_good: list[int] = []
    at = 0
    while at < len(starts):
        out, back = starts[at], starts[min(at + 1, len(starts) - 1)] + 1
        returned = np.linalg.norm(positions[back] - positions[out]) < 0.5 * far[out]
        if at + 1 < len(starts) and times[back] - times[out] < _GLITCH_S and returned:
            glitches[known[out + 1 : back]] = True
            at += 2
        else:
            for_good.append(int(known[out]))
            at += 1
    return glitches, np.array(for_good, dtype=np.intp)


def _bridge(samples: Samples) -> Samples:
    """Values where a tracker is not valid: on the line between its neighbours, for hands from the headset.

    Before the first and after the last valid sample the value is held; a hand that was never seen hangs at
    the hip.
    """
    times, valid = samples.times, samples.valid
    positions, rotations = samples.positions.copy(), samples.rotations.copy()
    for i in range(len(NAMES)):
        base = positions[:, 0] if i else np.zeros((len(times), 3))
        known, lost = np.flatnonzero(valid[:, i]), np.flatnonzero(~valid[:, i])
        if len(lost) == 0:
            continue
        if len(known) == 0:
            facing = quat.from_yaw(quat.heading(rotations[:, 0]))
            positions[:, i], rotations[:, i] = base + quat.rotate(facing, _AT_THE_HIP[i - 1]), facing
            continue
        ends = known if len(known) > 1 else np.repeat(known, 2)
        before, share = _between(times[ends], times[lost])
        positions[lost, i] = base[lost] + blend_positions((positions[:, i] - base)[ends], before, share)
        rotations[lost, i] = blend_rotations(rotations[ends, i], before, share)
    return replace(samples, positions=positions, rotations=quat.continuous(rotations))


def _between(times: Array, at: Array) -> tuple[NDArray[np.intp], Array]:
    """`neighbours`, also of one sample given twice."""
    if times[0] == times[-1]:
        return np.zeros(len(at), dtype=np.intp), np.zeros(len(at))
    return neighbours(times, at)

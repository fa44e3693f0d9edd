"""One timeline for three trackers: own clocks joined, jittering timestamps evened out, pauses filled."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..bounds import PAUSE_S, PAUSE_SAMPLES, PAUSE_TIMES
from ..errors import InputError
from ..maths import quat
from .interpolation import blend_positions, blend_rotations, neighbours
from .raw import Track
from .recording import Array

_JITTER = 0.15
_WINDOW = 21


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """The three trackers on one timeline, as in `Recording`; where not valid, values mean nothing."""

    times: Array
    positions: Array
    rotations: Array
    valid: NDArray[np.bool_]


def pause_limit(times: Array) -> float:
    """Steps longer than this many seconds are gaps in tracking rather than late samples."""
    return max(0.1, 4.0 * float(np.median(np.diff(times))))


def join(tracks: tuple[Track, Track, Track]) -> Samples:
    """All trackers at the headset's times, from 0; a controller is valid between two valid samples of its.

    Args:
        tracks: with increasing times and unit rotations; the headset's has two samples or more.
    """
    times = tracks[0].times
    joined = [at_times(track, times) for track in tracks]
    return Samples(
        times=times - times[0],
        positions=np.stack([track.positions for track in joined], axis=1),
        rotations=np.stack([track.rotations for track in joined], axis=1),
        valid=np.stack([track.valid for track in joined], axis=1),
    )


def at_times(track: Track, times: Array) -> Track:
    """One tracker, with increasing times and unit rotations, at other times."""
    if np.array_equal(track.times, times):
        return track
    if len(track.times) < 2:
        rotations = np.broadcast_to(quat.IDENTITY, (len(times), 4))
        return Track(times, np.zeros((len(times), 3)), rotations, np.zeros(len(times), dtype=np.bool_))
    before, share = neighbours(track.times, times)
    limit = pause_limit(track.times)
    inside = (times >= track.times[0] - limit) & (times <= track.times[-1] + limit)
    short = track.times[before + 1] - track.times[before] <= limit
    return Track(
        times,
        blend_positions(track.positions, before, share),
        blend_rotations(track.rotations, before, share),
        # at a sample itself the neighbour does not matter
        inside
        & (short | (share == 0.0) | (share == 1.0))
        & (track.valid[before] | (share == 1.0))
        & (track.valid[before + 1] | (share == 0.0)),
    )


def even_out(samples: Samples) -> tuple[Samples, str]:
    """Times without the jitter of a recorder that stamped evenly taken samples a little early or late.

    Each time becomes the mean of those around it, which keeps an even series as it is. That is done where the
    steps jitter, and only if the movement gets smoother by it; otherwise the samples really were taken
    unevenly.

    Returns:
        The samples and a line for people, "" where nothing was changed.
    """
    times = samples.times
    steps = np.diff(times)
    usual = float(np.median(steps))
    jitter = float(np.std(steps[steps < pause_limit(times)]))
    if len(times) < 2 * _WINDOW or jitter < _JITTER * usual:
        return samples, ""
    smooth = _running_mean(times, steps > pause_limit(times))
    smooth -= smooth[0]
    if _roughness(samples, smooth) > 0.7 * _roughness(samples, times):
        return samples, ""
    return replace(
        samples, times=smooth
    ), f"timestamps jitter by {jitter * 1e3:.1f} ms: taken as evenly spaced"


def _running_mean(times: Array, breaks: NDArray[np.bool_]) -> Array:
    """Mean of each time and its neighbours within unbroken runs, of as many on both sides."""
    count = len(times)
    index = np.arange(count)
    starts = np.r_[0, np.flatnonzero(breaks) + 1]
    run = np.searchsorted(starts, index, side="right") - 1
    ends = np.r_[starts[1:], count] - 1
    half = np.minimum(np.minimum(index - starts[run], ends[run] - index), _WINDOW // 2)
    total = np.r_[0.0, np.cumsum(times)]
    return (total[index + half + 1] - total[index - half]) / (2 * half + 1)


def _roughness(samples: Samples, times: Array) -> float:
    """How large the trackers' accelerations are, in m/s^2, but for the wildest tenth."""
    steps = np.diff(times)[:, None, None]
    velocity = np.diff(samples.positions, axis=0) / steps
    acceleration = np.linalg.norm(np.diff(velocity, axis=0) / (0.5 * (steps[1:] + steps[:-1])), axis=-1)
    tracked = samples.valid[2:] & samples.valid[1:-1] & samples.valid[:-2]
    return float(np.percentile(acceleration[tracked], 90)) if tracked.any() else 0.0


def check_pauses(times: Array, file: str) -> None:
    """Raise InputError for a pause of more than ten minutes, or for pauses that leave too little between them."""
    steps = np.diff(times)
    longest = int(np.argmax(steps))
    if steps[longest] > PAUSE_S:
        raise InputError(
            f"{file}: time jumps by {steps[longest]:.4g} s after {times[longest] - times[0]:.2f} s; cut it there"
        )
    gaps = steps[steps > pause_limit(times)]
    if gaps.sum() / np.median(steps) > max(PAUSE_SAMPLES, PAUSE_TIMES * len(times)):
        raise InputError(
            f"{file}: {len(gaps)} pauses of {gaps.sum():.0f} s, far longer than what was recorded; cut it there"
        )


def fill_pauses(samples: Samples) -> tuple[Samples, str]:
    """Samples, not valid, at the usual rate wherever the recording paused.

    Returns:
        The samples and a line for people, "" where there was no pause.
    """
    times = samples.times
    steps = np.diff(times)
    gaps = np.flatnonzero(steps > pause_limit(times))
    if len(gaps) == 0:
        return samples, ""
    longest = int(gaps[np.argmax(steps[gaps])])
    counts = np.round(steps[gaps] / np.median(steps)).astype(np.intp) - 1
    inside: list[Array] = [
        np.linspace(times[g], times[g + 1], n + 2)[1:-1] for g, n in zip(gaps, counts, strict=True)
    ]
    at = np.repeat(gaps + 1, counts)
    filled = Samples(
        times=np.insert(times, at, np.concatenate(inside)),
        positions=np.insert(samples.positions, at, 0.0, axis=0),
        rotations=np.insert(samples.rotations, at, quat.IDENTITY, axis=0),
        valid=np.insert(samples.valid, at, False, axis=0),
    )
    plural = "pause" if len(gaps) == 1 else "pauses"
    return (
        filled,
        f"{len(gaps)} {plural} of {steps[gaps].sum():.2f} s bridged, the longest at {times[longest]:.2f} s",
    )

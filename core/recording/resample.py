"""Recordings at an even rate."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..errors import InputError
from ..maths import quat
from .interpolation import blend_positions, blend_rotations, neighbours
from .recording import Recording


def resample(recording: Recording, fps: float) -> Recording:
    """The recording at `fps` frames per second from its first sample to the last that fits.

    Positions run on lines and rotations on great arcs between the recorded samples; a tracker is valid where
    the nearest recorded sample is.

    Raises:
        InputError: the recording is shorter than two frames.
    """
    times = recording.times
    # a last sample that rounding puts a hair before its frame still counts
    at = np.arange(int(np.floor(times[-1] * fps + 1e-4)) + 1) / fps
    if len(at) < 2:
        raise InputError(
            f"{recording.name}: {times[-1]:.3f} s are too short for a recording; record for longer"
        )
    if len(at) == len(times) and np.array_equal(at, times):
        return recording
    before, share = neighbours(times, at)
    nearest = before + (share > 0.5)
    return replace(
        recording,
        times=at,
        positions=blend_positions(recording.positions, before, share),
        rotations=quat.continuous(blend_rotations(recording.rotations, before, share)),
        valid=recording.valid[nearest],
        extra=tuple(
            replace(
                item,
                positions=blend_positions(item.positions, before, share),
                rotations=quat.continuous(blend_rotations(item.rotations, before, share)),
                valid=item.valid[nearest],
            )
            for item in recording.extra
        ),
    )

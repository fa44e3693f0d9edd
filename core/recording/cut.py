"""A stretch of a recording: people put headsets on and off."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..errors import InputError
from .happenings import clip, in_words
from .recording import Recording


def cut(recording: Recording, start: float, stop: float) -> Recording:
    """The samples from `start` to `stop` seconds, both included, with times from 0 again.

    What happened outside is no longer among the doubts.

    Args:
        recording: at any rate.
        start: seconds; before the first sample means from there.
        stop: seconds; past the last sample, or infinite, means up to there.

    Raises:
        InputError: fewer than two samples lie between them.
    """
    kept = (recording.times >= start - 1e-9) & (recording.times <= stop + 1e-9)
    if np.count_nonzero(kept) < 2:
        raise InputError(
            f"{recording.name}: nothing is left between {start:g} and {stop:g} s of its {recording.times[-1]:.1f} s;"
            " choose a longer part"
        )
    times = recording.times[kept]
    told = in_words(recording.happenings, recording.times[-1])
    happenings = clip(recording.happenings, times[0], times[-1])
    others = [doubt for doubt in recording.doubts if doubt not in told]
    return replace(
        recording,
        doubts=(*in_words(happenings, times[-1] - times[0]), *others),
        happenings=happenings,
        times=times - times[0],
        positions=recording.positions[kept],
        rotations=recording.rotations[kept],
        valid=recording.valid[kept],
        extra=tuple(
            replace(
                item,
                positions=item.positions[kept],
                rotations=item.rotations[kept],
                valid=item.valid[kept],
            )
            for item in recording.extra
        ),
    )

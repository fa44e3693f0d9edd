"""How far predicted body yaws are from the truth of samples."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...core.measure.measures import yaw_errors
from ...core.recording.windows import stream
from ..inputs import RATE, headings
from ..predictor import run_recurrent, run_windows
from ..weights import Predictor
from .samples import Array, Sample


def predicted(predictor: Predictor, sample: Sample) -> Array:
    """The yaws `(T,)` in radians that the predictor gives for a sample."""
    if predictor.layout is None:
        return run_recurrent(predictor, sample.positions, sample.rotations)
    tracked = np.ones((len(sample), 3), dtype=bool)
    rows = stream(sample.positions, sample.rotations, tracked, sample.head_height)
    return run_windows(predictor, predictor.layout, rows, RATE).yaws


def held_out_error_deg(predictor: Predictor, samples: Sequence[Sample]) -> float:
    """Mean absolute error in degrees over all frames, as in use."""
    return _mean_error_deg([predicted(predictor, sample) for sample in samples], samples)


def headset_forward_error_deg(samples: Sequence[Sample]) -> float:
    """Mean absolute error in degrees of the headset's forward."""
    return _mean_error_deg([headings(sample.rotations) for sample in samples], samples)


def _mean_error_deg(yaws: Sequence[Array], samples: Sequence[Sample]) -> float:
    errors = [yaw_errors(found, sample.yaws) for found, sample in zip(yaws, samples, strict=True)]
    return float(np.degrees(np.mean(np.concatenate(errors))))

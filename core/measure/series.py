"""Metrics over time, for graphs: the mean of each second."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .catalogue import METRICS, Values

Array = NDArray[np.floating[Any]]


def series(values: Values, step_s: float = 1.0) -> dict[str, Any]:
    """Means over stretches of time, of the metrics that reports have over time.

    Returns:
        `{"step_s": ..., NAME: [mean or None for each stretch], ...}`, ready for JSON; the last stretch may
        be shorter; None where nothing was to be measured.
    """
    out: dict[str, Any] = {"step_s": step_s}
    for name, metric in METRICS.items():
        if metric.series and name in values.own:
            means = stretch_means(values.own[name], round(step_s * values.fps))
            out[name] = [None if np.isnan(mean) else round(mean, 4) for mean in means.tolist()]
    return out


def stretch_means(values: Array, frames: int) -> Array:
    """Means `(S,)` of the values, `(T, ...)`, of every `frames` frames; NaN where none counts."""
    # values that need several frames are none at all of a shorter bake; then -1 would be ambiguous
    rows = values.reshape(len(values), int(np.prod(values.shape[1:])))
    counts = (~np.isnan(rows)).sum(axis=1)
    starts = np.arange(0, len(rows), max(frames, 1))
    total = np.add.reduceat(np.nansum(rows, axis=1), starts)
    number = np.add.reduceat(counts, starts)
    return np.where(number > 0, total / np.maximum(number, 1), np.nan)

"""Filters over time that do not lag: Savitzky-Golay, the median of booleans, Gaussian smoothing.

All take arrays with time first, `(T, ...)`, and return the same shape. Blender has no scipy, hence these.
"""

from __future__ import annotations

from math import ceil
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]


def odd_window(seconds: float, fps: float) -> int:
    """The odd number of frames nearest to a window's length in seconds, at least 1."""
    return max(1, 2 * round((seconds * fps - 1.0) / 2.0) + 1)


def savitzky_golay(values: Array, window: int, order: int = 3) -> Array:
    """Least-squares polynomials through a sliding window (Savitzky and Golay 1964).

    Near the ends the polynomial of the outermost whole window is read off its centre. A window longer than
    the series is shortened to it, an order too high for the window is lowered.

    Args:
        values: `(T, ...)`.
        window: odd number of frames; 1 changes nothing.
        order: degree of the polynomials.
    """
    values = np.asarray(values, dtype=np.float64)
    frames = len(values)
    window = min(window, frames - 1 + frames % 2)
    half = window // 2
    if half < 1:
        return values.copy()
    place = np.arange(-half, half + 1) / half
    powers = np.vander(place, min(order, window - 1) + 1)
    # row i reads the fitted polynomial off at the window's i-th frame
    fit = powers @ np.linalg.pinv(powers)
    flat = values.reshape(frames, -1)
    middle = _correlate(flat, fit[half])
    out = np.concatenate([fit[:half] @ flat[:window], middle, fit[half + 1 :] @ flat[-window:]])
    return out.reshape(values.shape)


def median(flags: NDArray[np.bool_], window: int) -> NDArray[np.bool_]:
    """The running median, that is majority, of booleans; the first and last value go on past the ends.

    Args:
        flags: `(T, ...)`.
        window: odd number of frames; 1 changes nothing.
    """
    half = window // 2
    if half == 0 or len(flags) == 0:
        return flags.copy()
    widths = [(half, half), *[(0, 0)] * (flags.ndim - 1)]
    counts = np.cumsum(np.pad(flags, widths, mode="edge"), axis=0)
    counts[window:] = counts[window:] - counts[:-window]
    return counts[window - 1 :] > half


def gaussian(values: Array, sigma: float) -> Array:
    """Gaussian smoothing without lag; straight lines stay as they are up to their ends.

    Past its ends the series goes on as its point reflection about the end, so a steady walk is not slowed.

    Args:
        values: `(T, ...)`.
        sigma: standard deviation in frames, cut off at four of them; 0 changes nothing.
    """
    values = np.asarray(values, dtype=np.float64)
    if sigma <= 0.0 or len(values) < 2:
        return values.copy()
    half = ceil(4.0 * sigma)
    kernel = np.exp(-0.5 * (np.arange(-half, half + 1) / sigma) ** 2)
    flat = values.reshape(len(values), -1)
    padded = np.pad(flat, ((half, half), (0, 0)), mode="reflect", reflect_type="odd")
    return _correlate(padded, kernel / kernel.sum()).reshape(values.shape)


def _correlate(flat: Array, kernel: Array) -> Array:
    """The kernel's product with every whole window of the columns `(T, D)`: `(T - K + 1, D)`."""
    # BLAS rounds by where its operands lie in memory and by the number of threads
    return np.einsum("tdk,k->td", sliding_window_view(flat, len(kernel), axis=0), kernel)

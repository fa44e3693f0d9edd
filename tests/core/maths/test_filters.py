from __future__ import annotations

import numpy as np
import pytest
from footwork.core.maths import filters
from hypothesis import given
from hypothesis import strategies as st
from scipy import ndimage, signal

RNG = np.random.default_rng(3)


@pytest.mark.parametrize(("window", "order"), [(5, 2), (31, 3), (13, 4), (7, 0)])
def test_savitzky_golay_is_scipys(window: int, order: int) -> None:
    values = RNG.normal(size=(120, 3, 2)).cumsum(axis=0)
    expected = signal.savgol_filter(values, window, order, axis=0, mode="interp")
    np.testing.assert_allclose(filters.savitzky_golay(values, window, order), expected, atol=1e-9)


def test_savitzky_golay_keeps_cubics_exactly() -> None:
    t = np.linspace(-1.0, 2.0, 80)
    cubic = 3.0 * t**3 - t**2 + 5.0
    np.testing.assert_allclose(filters.savitzky_golay(cubic, 21), cubic, atol=1e-12)


def test_savitzky_golay_on_short_series() -> None:
    for frames in range(1, 9):
        values = RNG.normal(size=(frames, 2))
        out = filters.savitzky_golay(values, 31)
        assert out.shape == values.shape
        assert np.isfinite(out).all()
    # four points and fewer: the window of three carries a parabola, which passes through them
    short = RNG.normal(size=3)
    np.testing.assert_allclose(filters.savitzky_golay(short, 31), short, atol=1e-12)


@given(st.lists(st.booleans(), min_size=1, max_size=60), st.integers(0, 12))
def test_median_is_scipys(flags: list[bool], half: int) -> None:
    values = np.array(flags)
    expected = ndimage.median_filter(values.astype(np.uint8), size=2 * half + 1, mode="nearest").astype(bool)
    np.testing.assert_array_equal(filters.median(values, 2 * half + 1), expected)


def test_median_of_columns_is_each_columns() -> None:
    flags = RNG.random((90, 2)) < 0.4
    out = filters.median(flags, 13)
    for side in (0, 1):
        np.testing.assert_array_equal(out[:, side], filters.median(flags[:, side], 13))


@pytest.mark.parametrize("sigma", [0.4, 3.0, 20.0])
def test_gaussian_is_scipys(sigma: float) -> None:
    values = RNG.normal(size=(90, 2, 2)).cumsum(axis=0)
    pad = int(np.ceil(4 * sigma))
    widths = ((pad, pad), (0, 0), (0, 0))
    padded = np.pad(values, widths, mode="reflect", reflect_type="odd")
    expected = ndimage.gaussian_filter1d(padded, sigma, axis=0, radius=pad)[pad:-pad]
    np.testing.assert_allclose(filters.gaussian(values, sigma), expected, atol=1e-9)


@given(st.integers(2, 50), st.floats(0.1, 30.0), st.floats(-5, 5), st.floats(-5, 5))
def test_gaussian_keeps_straight_lines(frames: int, sigma: float, start: float, slope: float) -> None:
    line = start + slope * np.arange(frames)
    np.testing.assert_allclose(filters.gaussian(line, sigma), line, atol=1e-8)


def test_gaussian_does_not_lag() -> None:
    pulse = np.zeros(101)
    pulse[50] = 1.0
    out = filters.gaussian(pulse, 6.0)
    np.testing.assert_allclose(out, out[::-1], atol=1e-15)
    assert out.argmax() == 50


def test_odd_window() -> None:
    assert filters.odd_window(13 / 60, 60.0) == 13
    assert filters.odd_window(13 / 60, 30.0) == 7
    assert filters.odd_window(13 / 60, 120.0) in (25, 27)
    assert filters.odd_window(0.0, 60.0) == 1

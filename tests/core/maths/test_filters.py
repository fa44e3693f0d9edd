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


@given(st.floats(0.0, 3.0), st.floats(1.0, 240.0))
def test_odd_window_is_the_nearest_odd_number(seconds: float, fps: float) -> None:
    found = filters.odd_window(seconds, fps)
    assert isinstance(found, int) and found % 2 == 1 and found >= 1
    assert abs(found - seconds * fps) <= 1.0 + 1e-9


@pytest.mark.parametrize(
    ("frames", "window", "used"),
    [(3, 31, 3), (4, 31, 3), (7, 9, 7), (8, 9, 7), (9, 9, 9), (10, 9, 9), (6, 3, 3)],
)
@pytest.mark.parametrize("order", [0, 1, 2])
def test_savitzky_golay_shortens_a_window_to_the_series(
    frames: int, window: int, used: int, order: int
) -> None:
    values = RNG.normal(size=(frames, 2))
    expected = signal.savgol_filter(values, used, order, axis=0, mode="interp")
    np.testing.assert_allclose(filters.savitzky_golay(values, window, order), expected, atol=1e-12)


@pytest.mark.parametrize("order", [4, 5, 40])
def test_an_order_as_high_as_the_window_changes_nothing(order: int) -> None:
    values = RNG.normal(size=(30, 2))
    np.testing.assert_allclose(filters.savitzky_golay(values, 5, order), values, atol=1e-9)


def test_savitzky_golay_is_of_order_three_if_nothing_is_said() -> None:
    values = RNG.normal(size=40)
    np.testing.assert_array_equal(filters.savitzky_golay(values, 11), filters.savitzky_golay(values, 11, 3))


@pytest.mark.parametrize("frames", [0, 1, 2, 20])
def test_filters_that_change_nothing_return_a_copy(frames: int) -> None:
    values = RNG.normal(size=(frames, 2))
    flags = values > 0.0
    for before, after in (
        (values, filters.savitzky_golay(values, 1)),
        (values, filters.gaussian(values, 0.0)),
        (values, filters.gaussian(values, -2.0)),
        (flags, filters.median(flags, 1)),
    ):
        np.testing.assert_array_equal(after, before)
        assert not np.shares_memory(after, before)
    if frames < 2:
        np.testing.assert_array_equal(filters.gaussian(values, 3.0), values)
        np.testing.assert_array_equal(filters.median(flags, 9), flags)


@pytest.mark.parametrize("kind", [np.float32, np.int64])
def test_filters_work_in_full_precision_on_any_kind_of_number(kind: type) -> None:
    values = RNG.integers(-9, 9, (25, 2)).astype(kind)
    exact = values.astype(np.float64)
    for smooth in (
        lambda v: filters.savitzky_golay(v, 7),
        lambda v: filters.savitzky_golay(v, 1),
        lambda v: filters.gaussian(v, 2.0),
        lambda v: filters.gaussian(v, 0.0),
    ):
        assert smooth(values).dtype == np.float64
        np.testing.assert_array_equal(smooth(values), smooth(exact))


def test_median_of_more_axes_and_longer_windows_than_the_series() -> None:
    flags = RNG.random((5, 2, 3)) < 0.5
    for window in (3, 5, 7, 21):
        expected = ndimage.median_filter(flags.astype(np.uint8), size=(window, 1, 1), mode="nearest")
        found = filters.median(flags, window)
        assert found.dtype == np.bool_
        np.testing.assert_array_equal(found, expected.astype(bool))
    assert not np.shares_memory(filters.median(flags, 3), flags)

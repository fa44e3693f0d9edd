"""Measures against numbers worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest
from footwork.core.maths import quat
from footwork.core.measure import measures


def toes(left_x: list[float]) -> np.ndarray:
    """Left toe at these x on the ground, right toe still at x = 1."""
    out = np.zeros((len(left_x), 2, 3))
    out[:, 0, 0], out[:, 1, 0] = left_x, 1.0
    return out


def test_summary() -> None:
    assert measures.summary(np.array([[1.0, 2.0], [3.0, 6.0]])) == {
        "mean": 3.0,
        "std": pytest.approx(np.sqrt(3.5)),
        "p95": pytest.approx(3.0 + 0.85 * 3.0),
        "max": 6.0,
        "count": 4,
    }
    nothing = {"mean": 0.0, "std": 0.0, "p95": 0.0, "max": 0.0, "count": 0}
    assert measures.summary(np.empty(0)) == measures.summary(np.full(3, np.nan)) == nothing


def test_what_does_not_count() -> None:
    values = measures.counted(np.array([[1.0, 9.0], [3.0, 9.0]]), np.array([[True, False], [True, False]]))
    assert measures.summary(values)["mean"] == 2.0
    rows = measures.counted(np.array([[1.0, 9.0], [3.0, 9.0]]), np.array([False, True]))
    assert measures.summary(rows)["count"] == 2 and measures.summary(rows)["mean"] == 6.0


def test_yaw_errors_take_the_short_way() -> None:
    a, b = np.radians([179.0, 10.0, -90.0, 370.0]), np.radians([-179.0, -10.0, 90.0, 5.0])
    np.testing.assert_allclose(np.degrees(measures.yaw_errors(a, b)), [2.0, 20.0, 180.0, 5.0], atol=1e-9)


def test_rotation_errors() -> None:
    a = quat.from_axis("X", np.radians([30.0, 0.0]))
    b = np.stack([quat.from_axis("X", np.radians(-15.0)), -quat.from_axis("Z", np.radians(90.0))])
    np.testing.assert_allclose(np.degrees(measures.rotation_errors(a, b)), [45.0, 90.0], atol=1e-9)
    # as rotation vectors: (30, 0, 0) - (-15, 0, 0) and (0, 0, 0) - (0, 0, 90)
    expected = [[45.0, 0.0, 0.0], [0.0, 0.0, 90.0]]
    np.testing.assert_allclose(np.degrees(measures.rotation_vector_errors(a, b)), expected, atol=1e-9)


def test_contact_speed_counts_steps_with_contact_at_both_ends() -> None:
    contacts = np.array([[1, 0], [1, 0], [0, 1], [1, 1], [1, 1]], dtype=bool)
    # left: 0.01 in contact, two steps out of it, 0.03 in contact; right: still for two steps
    speeds = measures.contact_speeds(toes([0.0, 0.01, 0.2, 0.4, 0.43]), contacts, fps=10.0)
    np.testing.assert_allclose(speeds[:, 0], [0.1, np.nan, np.nan, 0.3], atol=1e-12)
    np.testing.assert_allclose(speeds[:, 1], [np.nan, np.nan, 0.0, 0.0], atol=1e-12)


def test_contact_speed_is_horizontal() -> None:
    rising = toes([0.0, 0.0, 0.0])
    rising[:, 0, 2] = [0.0, 0.1, 0.2]
    assert measures.contact_speeds(rising, np.ones((3, 2), bool), 60.0).max() == 0.0


def test_slides_add_up_over_each_contact_phase() -> None:
    left = [0.0, 0.01, 0.03, 0.5, 0.9, 0.86, 0.87]
    contacts = np.zeros((7, 2), dtype=bool)
    contacts[:3, 0] = contacts[4:, 0] = True
    contacts[6, 1] = True
    # there and back again counts in full; a phase of one frame slides by nothing
    np.testing.assert_allclose(measures.slides(toes(left), contacts), [0.03, 0.05, 0.0], atol=1e-12)
    assert measures.slides(toes(left), np.zeros((7, 2), bool)).size == 0


def test_nsm_skate_fades_with_height() -> None:
    heights = np.zeros((5, 2))
    heights[:, 0] = [0.0, -0.01, 0.0125, 0.025, 0.3]
    speeds = measures.nsm_skate(toes([0.0, 0.1, 0.2, 0.3, 0.4]), heights, fps=10.0, limit=0.025)
    np.testing.assert_allclose(speeds[:, 0], [1.0, 2.0 - np.sqrt(2.0), 0.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(speeds[:, 1], 0.0, atol=1e-12)


def test_skating_ratio_needs_a_low_and_fast_foot() -> None:
    path = toes([0.0, 0.05, 0.12, 0.13, 0.20, 0.27])
    heights = np.zeros((6, 2))
    heights[4, 0] = 0.06
    # at 10 frames per second 0.05 m a frame is the border: only the second step is faster and low at both ends
    assert measures.skating(path, heights, fps=10.0).tolist() == [False, True, False, False, False]
    assert len(measures.skating(path[:1], heights[:1], fps=10.0)) == 0


def test_jitter_is_the_third_derivative() -> None:
    t = np.arange(50) / 25.0
    cubic = np.stack([2.0 * t**3, np.zeros(50), t**2], axis=-1)[:, None]
    # d3/dt3 of 2 t^3 is 12, and third differences of a cubic are exact
    np.testing.assert_allclose(measures.jitter(cubic, 25.0), 12.0, rtol=1e-6)
    assert len(measures.jitter(cubic[:3], 25.0)) == 0


def test_speeds_and_distances() -> None:
    points = np.array([[[0.0, 0.0, 0.0]], [[3.0, 0.0, 4.0]]])
    assert measures.speeds(points, 2.0).tolist() == [[10.0]]
    assert measures.distances(np.array([3.0, 4.0]), np.zeros(2)) == 5.0

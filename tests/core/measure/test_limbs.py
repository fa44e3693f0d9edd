"""Bends, gaps between shins and swivels of elbows beside brute force and scipy."""

from __future__ import annotations

import numpy as np
import pytest
from footwork.core.measure import limbs
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

RNG = np.random.default_rng(21)


def test_gaps_are_the_shortest_ways_between_segments() -> None:
    points = RNG.standard_normal((60, 4, 3))
    # parallel ones, crossing ones, one that is a point
    points[0, 3] = points[0, 2] + points[0, 1] - points[0, 0]
    middle, aside = points[1, :2].mean(axis=0), np.array([0.1, 0.3, 0.2])
    points[1, 2:] = middle - aside, middle + aside
    points[2, 3] = points[2, 2]
    found = limbs.segment_gaps(*np.swapaxes(points, 0, 1))

    for (a, b, c, d), gap in zip(points, found, strict=True):

        def way(at, a=a, b=b, c=c, d=d) -> float:
            return float(np.sum((a + at[0] * (b - a) - c - at[1] * (d - c)) ** 2))

        best = min(
            minimize(way, start, bounds=[(0, 1), (0, 1)]).fun
            for start in ((0.1, 0.9), (0.9, 0.1), (0.5, 0.4))
        )
        assert gap == pytest.approx(np.sqrt(best), abs=1e-4)
    assert found[1] == pytest.approx(0.0, abs=1e-12)


def test_bends_are_the_turns_of_the_shin() -> None:
    thigh, axis = RNG.standard_normal((2, 9, 3))
    axis -= thigh * (np.sum(axis * thigh, 1) / np.sum(thigh**2, 1))[:, None]
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    angle = np.linspace(0.0, 3.0, 9)
    shin = Rotation.from_rotvec(axis * angle[:, None]).apply(0.8 * thigh)
    hips = RNG.standard_normal((9, 3))
    np.testing.assert_allclose(limbs.bends(hips, hips + thigh, hips + thigh + shin), angle, atol=1e-9)


def test_swivels_are_turns_about_the_line_from_shoulder_to_wrist() -> None:
    arm = RNG.standard_normal((7, 3, 3))
    line = arm[:, 2] - arm[:, 0]
    line /= np.linalg.norm(line, axis=1, keepdims=True)
    angle = np.array([0.0, 0.3, -0.7, 1.5, -2.2, 3.0, 0.1])
    other = arm.copy()
    other[:, 1] = arm[:, 0] + Rotation.from_rotvec(line * angle[:, None]).apply(arm[:, 1] - arm[:, 0])
    np.testing.assert_allclose(limbs.swivel_errors(arm, other, 1e-6), np.abs(angle), atol=1e-9)
    other[2, 1] = 0.4 * other[2, 0] + 0.6 * other[2, 2]
    found = limbs.swivel_errors(arm, other, 0.04)
    assert np.isnan(found[2]) and np.isfinite(np.delete(found, 2)).all()

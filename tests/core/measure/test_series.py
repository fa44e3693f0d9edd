"""Metrics over time and pooled over takes."""

from __future__ import annotations

import numpy as np
import pytest
from footwork.core.measure.catalogue import Values, pool, summarise
from footwork.core.measure.series import series, stretch_means


def values(own: dict[str, list], floor: dict[str, list] | None = None) -> Values:
    def arrays(side: dict[str, list]) -> dict[str, np.ndarray]:
        return {name: np.array(rows, dtype=float) for name, rows in side.items()}

    return Values(2.0, arrays(own), arrays(floor or {}))


def test_means_of_stretches_leave_out_what_does_not_count() -> None:
    rows = np.array([[1.0, 3.0], [np.nan, 5.0], [np.nan, np.nan], [np.nan, np.nan], [7.0, np.nan]])
    np.testing.assert_allclose(stretch_means(rows, 2), [3.0, np.nan, 7.0])


@pytest.mark.parametrize("shape", [(0,), (0, 2), (0, 4)])
def test_a_bake_too_short_to_measure_has_no_stretches(shape: tuple[int, ...]) -> None:
    assert stretch_means(np.zeros(shape), 30).shape == (0,)


def test_series_have_a_value_for_each_second_or_none() -> None:
    made = series(
        values({"root_error_cm": [1, 2, 3, 4, 9], "foot_skate_cm_s": [np.nan] * 4, "pose_jump": [1]})
    )
    assert made == {"step_s": 1.0, "root_error_cm": [1.5, 3.5, 9.0], "foot_skate_cm_s": [None, None]}


def test_pooled_takes_count_by_their_length() -> None:
    short = values(
        {"root_error_cm": [10.0], "jitter": [1.0], "poses_used": [[0, 5], [0, 6]]}, {"root_error_cm": [1.0]}
    )
    long = values(
        {"root_error_cm": [1.0] * 9, "jitter": [3.0], "poses_used": [[0, 6], [1, 6]]},
        {"root_error_cm": [0.0] * 3},
    )
    metrics = summarise(pool([short, long]))
    assert metrics["root_error_cm"]["mean"] == pytest.approx(1.9)
    assert metrics["root_error_cm"]["max"] == 10.0 and metrics["root_error_cm"]["count"] == 10
    assert metrics["root_error_cm"]["floor"]["mean"] == pytest.approx(0.25)
    assert metrics["jitter"] == 2.0
    assert metrics["poses_used"] == 3, "a pose that two takes use is one pose"


def test_what_was_not_measured_has_no_number() -> None:
    metrics = summarise(values({"phase_agreement": [np.nan, np.nan], "jitter": []}, {"jitter": [2.0]}))
    assert metrics == {"phase_agreement": None, "jitter": None, "jitter_floor": 2.0}

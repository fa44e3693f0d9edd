"""What is good, and what a terminal shows of a report."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from footwork.core.measure.catalogue import METRICS
from footwork.core.measure.words import rating, report_in_words

SKATE, JERK, PHASE, HEAD = (
    METRICS[name]
    for name in ("nsm_skate_cm_s", "shin_jerk_m_s3", "phase_agreement", "head_position_error_cm")
)


def row(mean: float, count: int = 9, **more: Any) -> dict[str, Any]:
    return {"mean": mean, "std": 1.0, "p95": 2.0 * mean, "max": 3.0 * mean, "count": count, **more}


def test_without_a_truth_the_limit_and_the_worst_second_decide() -> None:
    metric = replace(SKATE, limit=20.0, worst=60.0)
    for mean, seconds, said in (
        (19.0, (), "GOOD"),
        (19.0, (10.0, None, 59.0), "GOOD"),
        (19.0, (10.0, None, 61.0), "POOR"),
        (21.0, (21.0,), "POOR"),
    ):
        assert rating(metric, {metric.name: row(mean)}, seconds) == said
    head = replace(HEAD, limit=1.0, worst=None)
    assert rating(head, {head.name: row(0.2)}, (0.1, 2.9)) == "GOOD"
    assert rating(head, {head.name: row(0.2)}, (0.1, 3.1)) == "POOR"


def test_beside_a_truth_much_less_is_as_wrong_as_much_more() -> None:
    for metric in (SKATE, JERK):
        found = [
            rating(metric, {metric.name: row(mean, floor=row(12.0))}) for mean in (2.0, 5.9, 6.1, 17.9, 18.1)
        ]
        assert found == ["POOR", "POOR", "GOOD", "GOOD", "POOR"]


def test_what_was_not_measured_is_never_good() -> None:
    for metric in METRICS.values():
        for value in (None, row(0.0, count=0)):
            assert rating(metric, {metric.name: value}) == "NONE", metric.name
        assert rating(metric, {}) == "NONE"


def test_phases_are_good_from_their_limit_on() -> None:
    assert [rating(PHASE, {PHASE.name: value}) for value in (0.2, PHASE.limit, 0.99)] == [
        "POOR",
        "GOOD",
        "GOOD",
    ]


@pytest.mark.parametrize("known", [True, False])
def test_a_terminal_shows_the_truth_first_and_a_dash_for_what_is_unknown(known: bool) -> None:
    metrics: dict[str, Any] = {
        "root_error_cm": row(3.0),
        "hand_position_error_cm": row(0.0, count=0),
        "resting_steps_per_min": None,
        "crossed_shins_frames": 7,
    }
    if known:
        metrics |= {
            "lower_body_mpjpe_cm": row(11.0),
            "frozen_pose_lower_body_mpjpe_cm": row(14.5),
            "crossed_shins_frames_floor": 2,
        }
    report = {"metrics": metrics, "timing_s": {"recorded": 5.0, "search": 0.5}, "warnings": ["look out"]}
    lines = report_in_words(report)
    text = {line.strip().partition("  ")[0]: line.split() for line in lines}
    assert (
        text["hand error, cm"][-3:] == ["-", "-", "-"]
        and text["steps while the head rests, 1/min"][-1] == "-"
    )
    assert text["crossed shins, frames"][-2:] == (["7.00", "2.00"] if known else ["frames", "7.00"])
    assert lines[-1] == "  warning: look out" and "5.0 s recorded, baked in 0.50 s" in lines[-2]
    if known:
        assert text["legs (lower body MPJPE), cm"][-4:] == ["11.00", "22.00", "33.00", "14.50"]
        order = list(text)
        assert order.index("legs (lower body MPJPE), cm") < order.index("root to its own target, cm")

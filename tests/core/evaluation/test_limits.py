"""Limits on metrics and comparisons of reports."""

from __future__ import annotations

from typing import Any

import pytest
from footwork.core.errors import InputError
from footwork.core.evaluation.compare import compare_reports, comparison_in_words
from footwork.core.evaluation.limits import failures, parse_limit
from footwork.core.measure.catalogue import METRICS
from footwork.core.measure.metric import KINDS, TABLES, get

SKATE = {"mean": 2.5, "std": 1.0, "p95": 6.0, "max": 9.0, "count": 100}
METRICS_NOW: dict[str, Any] = {
    "foot_skate_cm_s": {**SKATE, "floor": {**SKATE, "mean": 1.2}},
    "hand_position_error_cm": {"mean": 0.0, "std": 0.0, "p95": 0.0, "max": 0.0, "count": 0},
    "clamped_fraction": 0.125,
    "jitter": 400.0,
    "jitter_floor": 350.0,
    "poses_used": 800,
}


@pytest.mark.parametrize(
    ("text", "fails"),
    [
        ("foot_skate_cm_s.mean > 2", True),
        ("foot_skate_cm_s.mean>2.5", False),
        ("foot_skate_cm_s.mean >= 2.5", True),
        ("  foot_skate_cm_s.floor.mean < 1.3 ", True),
        ("clamped_fraction > 1e-1", True),
        ("poses_used < 500", False),
        ("poses_used == 800", True),
        ("poses_used != 800", False),
        ("jitter_floor <= 350", True),
    ],
)
def test_limits(text: str, fails: bool) -> None:
    assert bool(failures(METRICS_NOW, [parse_limit(text)])) is fails


def test_what_was_not_measured_has_failed() -> None:
    (line,) = failures(METRICS_NOW, [parse_limit("hand_position_error_cm.mean > 1")])
    assert "not measured" in line
    (line,) = failures(METRICS_NOW, [parse_limit("mpjpe_cm.mean > 1")])
    assert "not measured" in line


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("foot_skate > 2", "there is no metric 'foot_skate'"),
        ("foot_skate_cm_s > 2", "mean, std, p95, max"),
        ("foot_skate_cm_s.median > 2", "mean, std, p95, max"),
        ("foot_skate_cm_s.mean.floor > 2", "mean, std, p95, max"),
        ("clamped_fraction.mean > 2", "single number"),
        ("foot_skate_cm_s.mean = 2", "COMPARISON"),
        ("foot_skate_cm_s.mean >", "COMPARISON"),
        ("foot_skate_cm_s.mean > 1.2.3", "COMPARISON"),
        ("", "COMPARISON"),
        ("__import__('os') > 1", "COMPARISON"),
    ],
)
def test_bad_limits_are_told_in_one_line(text: str, told: str) -> None:
    with pytest.raises(InputError, match="--fail-if") as error:
        parse_limit(text)
    assert told in str(error.value) and len(str(error.value).splitlines()) == 1


def test_getting_figures() -> None:
    assert get(METRICS_NOW, "foot_skate_cm_s.floor.mean") == 1.2
    assert get(METRICS_NOW, "clamped_fraction") == 0.125
    for path in ("absent", "clamped_fraction.mean", "foot_skate_cm_s.absent", "hand_position_error_cm.max"):
        assert get(METRICS_NOW, path) is None


def test_every_metric_is_explained() -> None:
    for name, metric in METRICS.items():
        assert metric.name == name and metric.label and metric.says and metric.kind in KINDS, name
        assert set(metric.tables) <= set(TABLES), name


def report(**changes: Any) -> dict[str, Any]:
    base = {"metrics": METRICS_NOW, "settings": {"alpha": 0.3}, "inputs": [], "measured": "core"}
    return {**base, **changes}


def test_a_report_beside_itself_is_the_same() -> None:
    comparison = compare_reports(report(), report())
    assert {row["verdict"] for row in comparison["rows"]} == {"same", ""}
    assert comparison["worse"] == 0 and not comparison["differences"]


def test_better_and_worse() -> None:
    now = {**METRICS_NOW, "foot_skate_cm_s": {**SKATE, "mean": 2.0, "p95": 7.0}, "poses_used": 100}
    comparison = compare_reports(report(), report(metrics=now))
    verdicts = {row["metric"]: row["verdict"] for row in comparison["rows"]}
    assert verdicts["foot_skate_cm_s.mean"] == "better" and verdicts["foot_skate_cm_s.p95"] == "worse"
    assert verdicts["poses_used"] == "", "neither way is better"
    assert "hand_position_error_cm.mean" not in verdicts, "nothing was measured"
    assert comparison["worse"] == 1
    rows = {row["metric"]: row for row in comparison["rows"]}
    assert rows["foot_skate_cm_s.mean"]["change"] == pytest.approx(-0.2)
    assert "worse" in comparison_in_words(comparison)[-1]


def test_small_changes_are_none() -> None:
    now = {**METRICS_NOW, "foot_skate_cm_s": {**SKATE, "mean": 2.6}}
    assert compare_reports(report(), report(metrics=now))["worse"] == 0
    assert compare_reports(report(), report(metrics=now), tolerance=0.01)["worse"] == 1


def test_reports_of_other_things_say_so() -> None:
    a = report(inputs=[{"kind": "take", "name": "a.bvh", "sha256": "0" * 64}])
    b = report(inputs=[{"kind": "take", "name": "b.bvh", "sha256": "1" * 64}], settings={"alpha": 0.1})
    lines = compare_reports(a, b)["differences"]
    assert any("alpha: 0.3 before, 0.1 now" in line for line in lines)
    assert any("a.bvh" in line for line in lines) and any("b.bvh" in line for line in lines)
    with pytest.raises(InputError, match="no metric in common"):
        compare_reports(report(metrics={}), report())

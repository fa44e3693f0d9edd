"""A report's figures as text for a terminal, and whether they are good."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from .catalogue import METRICS
from .metric import GROUPS, Metric, get

NEAR_TRUTH = (0.5, 1.5)
"""Shares of the true motion's own figure between which one is good that should be near it."""
WORST = 3.0
"""A second may be this many times as bad as the limit of the mean, for metrics that say nothing else."""
NONE = "-"
"""What stands for a figure that was not measured."""


def report_in_words(report: Mapping[str, Any]) -> list[str]:
    """The figures that a person looks at first, line by line: against the truth, then the rest."""
    metrics, timing = report["metrics"], report["timing_s"]
    lines = [f"  {'':<40}{'mean':>9}{'p95':>9}{'max':>9}{'true':>9}{'frozen':>9}"]
    for group, title in GROUPS.items():
        rows = [_row(metric, metrics) for metric in _summary(group) if metric.name in metrics]
        lines += [f"  {title}", *rows] if rows else []
    seconds = sum(value for stage, value in timing.items() if stage != "recorded")
    lines.append(f"  {timing['recorded']:.1f} s recorded, baked in {seconds:.2f} s")
    return lines + [f"  warning: {warning}" for warning in report["warnings"]]


def _summary(group: str) -> Iterable[Metric]:
    return (metric for metric in METRICS.values() if metric.group == group and "summary" in metric.tables)


def _row(metric: Metric, metrics: Mapping[str, Any]) -> str:
    """Label and figures; of numbers, shares and totals there is the mean alone."""
    unit = metric.unit.replace("°", "degrees")
    label = f"{metric.label}, {unit}" if unit else metric.label
    if metric.kind == "distribution":
        paths = [f"{metric.name}.{key}" for key in ("mean", "p95", "max", "floor.mean")]
    else:
        paths = [metric.name, "", "", f"{metric.name}_floor"]
    frozen = f"frozen_pose_{metric.name}"
    cells = [_cell(metrics, path) for path in (*paths, f"{frozen}.mean" if frozen in METRICS else "")]
    return f"    {label:<38}" + "".join(cells)


def _cell(metrics: Mapping[str, Any], path: str) -> str:
    if not path:
        return " " * 9
    value = get(metrics, path)
    known = path.partition(".")[0] in metrics and ("floor" not in path or value is not None)
    return f"{value:9.2f}" if value is not None else f"{NONE:>9}" if known else " " * 9


def rating(metric: Metric, metrics: Mapping[str, Any], over_time: Sequence[float | None] = ()) -> str:
    """Whether a figure is as it should be.

    Args:
        metric: the figure's.
        metrics: of the report.
        over_time: its means of each second, None where nothing was measured.

    Returns:
        "GOOD", "POOR", or "NONE" where it is not judged or was not measured.
    """
    path = f"{metric.name}.mean" if metric.kind == "distribution" else metric.name
    value = get(metrics, path)
    if metric.limit is None or value is None:
        return "NONE"
    floor = get(
        metrics, f"{metric.name}.floor.mean" if metric.kind == "distribution" else f"{metric.name}_floor"
    )
    if metric.near_truth and floor is not None:
        return "GOOD" if NEAR_TRUTH[0] * floor <= value <= NEAR_TRUTH[1] * floor else "POOR"
    if metric.better == "higher":
        return "GOOD" if value >= metric.limit else "POOR"
    seconds = [second for second in over_time if second is not None]
    most = WORST * metric.limit if metric.worst is None else metric.worst
    return "GOOD" if value <= metric.limit and (not seconds or max(seconds) <= most) else "POOR"

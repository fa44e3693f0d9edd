"""The summary of a batch: a row for each recording, the worst first."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from .. import VERSION
from ..measure.catalogue import METRICS
from ..measure.metric import Metric, get

FORMAT = "footwork-batch-report"
SCHEMA = 1
DONE, KEPT, FAILED = "done", "kept", "failed"
"""How a recording came out: baked, left as an earlier run made it, or not baked."""

Row = dict[str, Any]
_COLUMNS = ("name", "recording", "state", "recorded_s", "spent_s", "bytes_out", "worst", "times", "error")


def metric_names() -> tuple[str, ...]:
    """The metrics that a summary has of each recording: what is first looked at in a bake without the truth."""
    return tuple(
        metric.name
        for metric in METRICS.values()
        if metric.group != "truth" and ("summary" in metric.tables or metric.limit is not None)
    )


def row_of(report: Mapping[str, Any], name: str, state: str, failed: Sequence[str] = ()) -> Row:
    """The row of a recording that is baked.

    Args:
        report: its report.
        name: of its outputs.
        state: `DONE` or `KEPT`.
        failed: the limits that it passes, a line each.
    """
    timing = report["timing_s"]
    values = {key: _value(METRICS[key], report["metrics"]) for key in metric_names()}
    worst, times = worst_of(values)
    return {
        "name": name,
        "recording": report["recording"],
        "state": state,
        "recorded_s": timing["recorded"],
        "worst": worst,
        "times": times,
        "metrics": values,
        "warnings": list(report["warnings"]),
        "failed": list(failed),
        "producer": report["producer"],
    }


def failed_row(recording: str, name: str, lines: Sequence[str], trace: str = "") -> Row:
    """The row of a recording that could not be baked; `trace` where it is our bug."""
    row: Row = {"name": name, "recording": recording, "state": FAILED, "error": "; ".join(lines)}
    return {**row, "trace": trace} if trace else row


def worst_of(values: Mapping[str, float | None]) -> tuple[str, float]:
    """The metric that is farthest past what is good, and how many times as bad as that limit it is; "" for none."""
    ratios = {name: _ratio(METRICS[name], value) for name, value in values.items() if value is not None}
    name = max(ratios, key=lambda key: ratios[key], default="")
    return name, round(ratios.get(name, 0.0), 3)


def _ratio(metric: Metric, value: float) -> float:
    if not metric.limit:
        return 0.0
    if metric.better == "higher":
        return metric.limit / max(value, 1e-3 * metric.limit)
    return value / metric.limit


def _value(metric: Metric, metrics: Mapping[str, Any]) -> float | None:
    return get(metrics, f"{metric.name}.mean" if metric.kind == "distribution" else metric.name)


def worst_first(rows: Iterable[Row]) -> list[Row]:
    """Failed ones, then those past a limit of --fail-if, then by how many times as bad as is good they are."""
    return sorted(
        rows,
        key=lambda row: (
            row["state"] != FAILED,
            not row.get("failed"),
            -row.get("times", 0.0),
            row["name"],
        ),
    )


def batch_report(
    rows: Sequence[Row], timing: Mapping[str, Any], warnings: Sequence[str] = (), left: int = 0
) -> dict[str, Any]:
    """The JSON-ready report of a batch.

    Args:
        rows: of all recordings that were come to.
        timing: `wall_s`, `workers` and what else is known of the run.
        warnings: lines.
        left: recordings that a batch did not come to because it was stopped.

    Returns:
        With `unfinished` (names of failed recordings) and `failed` (limits passed) for the exit code.
    """
    ordered = worst_first(rows)
    states = [row["state"] for row in ordered]
    makers = sorted({row["producer"] for row in ordered if "producer" in row})
    mixed = [f"made by different versions: {', '.join(makers)}"] if len(makers) > 1 else []
    stopped = f"stopped: {left} of {len(rows) + left} recordings are left; --resume does them"
    return {
        "format": FORMAT,
        "schema": SCHEMA,
        "producer": f"footwork {VERSION}",
        "counts": {**{state: states.count(state) for state in (DONE, KEPT, FAILED)}, "left": left},
        "recorded_s": sum(row.get("recorded_s", 0.0) for row in ordered),
        "timing": dict(timing),
        "warnings": [*([stopped] if left else []), *warnings, *mixed],
        "unfinished": [row["name"] for row in ordered if row["state"] == FAILED],
        "failed": [f"{row['name']}: {line}" for row in ordered for line in row.get("failed", ())],
        "recordings": ordered,
    }


def to_csv(report: Mapping[str, Any]) -> str:
    """The rows as a table for spreadsheets, in the report's order."""
    names = metric_names()
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([*_COLUMNS, "warnings", "failed", *names])
    for row in report["recordings"]:
        lines = ["; ".join(row.get(key, ())) for key in ("warnings", "failed")]
        values = row.get("metrics", {})
        writer.writerow(
            [*(row.get(key, "") for key in _COLUMNS), *lines, *(values.get(name) for name in names)]
        )
    return text.getvalue()

"""Two reports side by side: what got better and what got worse."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, cast

from ..bounds import LARGEST_FIGURE
from ..errors import FaultError, InputError
from ..measure.catalogue import METRICS
from ..measure.metric import get

TOLERANCE = 0.05
"""Change, as a share of the old figure, up to which nothing is said to have changed."""
_TINY = {"cm": 0.02, "cm/s": 0.05, "°": 0.05, "": 0.002}
"""And changes that are nothing in any case, by unit."""


def check_report(report: Any) -> dict[str, Any]:
    """A report from a file, if it is one that can be compared; FaultError with what is wrong if not."""
    if not isinstance(report, dict):
        raise FaultError("is no report")
    found = cast(dict[str, Any], report)
    metrics, inputs = found.get("metrics"), found.get("inputs", [])
    if not isinstance(metrics, dict):
        raise FaultError("has no metrics")
    for name, metric in METRICS.items():
        value = cast(dict[str, Any], metrics).get(name)
        if metric.kind == "distribution" and value is not None and _schema(found) >= metric.since:
            rows = cast(dict[str, Any], value) if isinstance(value, dict) else {"mean": value}
            wrong = not isinstance(value, dict) or not all(
                _is_figure(rows.get(key)) for key in ("mean", "p95")
            )
        else:
            wrong = metric.kind != "distribution" and not _is_figure(value)
        if wrong:
            raise FaultError(f"its metric {name!r} is not what a report has there")
    if not isinstance(inputs, list) or not all(map(_is_input, cast(list[Any], inputs))):
        raise FaultError("its inputs are no list of kind, name and sha256")
    return found


def _is_figure(value: Any) -> bool:
    """Whether this is a number as reports have them, or none."""
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return value is None or (number and abs(value) <= LARGEST_FIGURE)


def _is_input(row: Any) -> bool:
    return isinstance(row, dict) and all(
        isinstance(cast(dict[str, Any], row).get(key), str) for key in ("kind", "name", "sha256")
    )


def compare_reports(
    old: Mapping[str, Any], new: Mapping[str, Any], tolerance: float = TOLERANCE
) -> dict[str, Any]:
    """A table of all metrics that both reports have, of evaluations or bakes.

    Args:
        old: a report.
        new: a later one.
        tolerance: relative change that counts as none.

    Returns:
        JSON-ready: `rows` with `metric`, `old`, `new`, `change` (relative; None from zero) and `verdict`
        ("better", "worse", "same", or "" where neither way is better), the number `worse`, and
        `differences`: inputs and settings that are not the same.

    Raises:
        InputError: they have no metric in common.
    """
    rows: list[dict[str, Any]] = []
    for name, metric in METRICS.items():
        if min(_schema(old), _schema(new)) < metric.since:
            continue
        paths = [f"{name}.{key}" for key in ("mean", "p95")] if metric.kind == "distribution" else [name]
        for path in paths:
            before, after = get(old["metrics"], path), get(new["metrics"], path)
            if before is None or after is None:
                continue
            moved = after - before
            same = abs(moved) <= max(tolerance * abs(before), _TINY.get(metric.unit, 0.0))
            verdict = "same" if same else "better" if _is_better(metric.better, before, after) else "worse"
            rows.append(
                {
                    "metric": path,
                    "unit": metric.unit,
                    "old": before,
                    "new": after,
                    "change": moved / before if before else None,
                    "verdict": verdict if metric.better else "",
                }
            )
    if not rows:
        raise InputError("the two reports have no metric in common; give reports of evaluate or bake")
    worse = sum(row["verdict"] == "worse" for row in rows)
    return {"tolerance": tolerance, "rows": rows, "worse": worse, "differences": _differences(old, new)}


def _schema(report: Mapping[str, Any]) -> float:
    value = report.get("schema", 0)
    return value if isinstance(value, int | float) else 0


def _is_better(better: str, before: float, after: float) -> bool:
    if better == "zero":
        return abs(after) < abs(before)
    return after < before if better == "lower" else after > before


def _differences(old: Mapping[str, Any], new: Mapping[str, Any]) -> list[str]:
    """Why two reports may not be comparable, a line each."""
    lines: list[str] = []
    for key in ("settings", "measured", "true_orientation", "format"):
        a, b = old.get(key), new.get(key)
        if isinstance(a, dict) and isinstance(b, dict):
            lines += _changed(cast(dict[str, Any], a), cast(dict[str, Any], b))
        elif a != b:
            lines.append(f"{key}: {a} before, {b} now")
    before, after = ({_input(row) for row in report.get("inputs", [])} for report in (old, new))
    lines += [f"only before: {text}" for text in sorted(before - after)]
    lines += [f"only now: {text}" for text in sorted(after - before)]
    return lines


def _changed(old: dict[str, Any], new: dict[str, Any]) -> list[str]:
    keys = sorted(old.keys() | new.keys())
    return [
        f"{key.replace('_', '-')}: {old.get(key)} before, {new.get(key)} now"
        for key in keys
        if old.get(key) != new.get(key)
    ]


def _input(row: Mapping[str, str]) -> str:
    return f"{row['kind']} {row['name']} {row['sha256'][:8]}".rstrip()


def comparison_in_words(comparison: Mapping[str, Any]) -> list[str]:
    """The table for people, line by line."""
    lines = [f"{'':<38}{'old':>10}{'new':>10}{'change':>9}"]
    for row in comparison["rows"]:
        change = "" if row["change"] is None else f"{row['change']:+.0%}"
        lines.append(
            f"{row['metric']:<38}{row['old']:>10.3f}{row['new']:>10.3f}{change:>9}  {row['verdict']}"
        )
    lines += [f"not the same: {line}" for line in comparison["differences"]]
    return [*lines, f"{comparison['worse']} worse by more than {comparison['tolerance']:.0%}"]

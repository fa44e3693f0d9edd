"""A report from a file can be compared, or what is wrong with it is said."""

from __future__ import annotations

from typing import Any

import pytest
from footwork.core.errors import FaultError
from footwork.core.evaluation.compare import check_report, compare_reports


def report() -> dict[str, Any]:
    row = {"mean": 1.25, "std": 0.5, "p95": 2.0, "max": 3.0, "count": 140}
    return {
        "metrics": {"root_error_cm": row, "yaw_error_deg": None, "clamped_fraction": 0.25, "poses_used": 12},
        "inputs": [{"kind": "take", "name": "walk.bvh", "sha256": "ab" * 32}],
        "settings": {"alpha": 0.3},
    }


def put(*path: Any):
    *keys, last, value = path

    def change(data: Any) -> None:
        for key in keys:
            data = data[key]
        data[last] = value

    return change


def drop(*path: Any):
    *keys, last = path

    def change(data: Any) -> None:
        for key in keys:
            data = data[key]
        del data[last]

    return change


FAULTS = [
    (put("metrics", [1]), "no metrics"),
    (drop("metrics"), "no metrics"),
    (put("metrics", "root_error_cm", 3.0), "'root_error_cm'"),
    (put("metrics", "root_error_cm", "mean", "small"), "'root_error_cm'"),
    (put("metrics", "root_error_cm", "p95", [2.0]), "'root_error_cm'"),
    (put("metrics", "root_error_cm", "mean", True), "'root_error_cm'"),
    (put("metrics", "root_error_cm", "mean", 10**300), "'root_error_cm'"),
    (put("metrics", "root_error_cm", "mean", float("nan")), "'root_error_cm'"),
    (put("metrics", "clamped_fraction", {"mean": 1.0}), "'clamped_fraction'"),
    (put("inputs", 7), "inputs"),
    (put("inputs", {"kind": "take"}), "inputs"),
    (put("inputs", ["walk.bvh"]), "inputs"),
    (drop("inputs", 0, "name"), "inputs"),
    (put("inputs", 0, "sha256", None), "inputs"),
]


@pytest.mark.parametrize(("change", "words"), FAULTS)
def test_faults(change: Any, words: str) -> None:
    data = report()
    change(data)
    with pytest.raises(FaultError, match=words):
        check_report(data)


@pytest.mark.parametrize("data", [None, 3, "report", [report()]])
def test_what_is_no_report_at_all(data: Any) -> None:
    with pytest.raises(FaultError, match="no report"):
        check_report(data)


@pytest.mark.parametrize("change", [drop("inputs"), drop("settings"), put("settings", 5), put("more", [1])])
def test_what_reports_may_lack_or_have(change: Any) -> None:
    data = report()
    change(data)
    compare_reports(check_report(data), check_report(report()))

"""What a metric is, and how its figures are found in a report."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from .subject import Subject

Array = NDArray[np.floating[Any]]

STATISTICS = ("mean", "std", "p95", "max")
KINDS = ("distribution", "number", "share", "count")
TABLES = ("summary", "panel", "graph")


@dataclass(frozen=True, slots=True)
class Metric:
    """One metric: the whole of it, for reports, comparisons, limits, series, the panel and the graph."""

    name: str
    """In reports, with its unit: `foot_skate_cm_s`."""
    label: str
    unit: str
    says: str
    """One sentence without a final period: what exactly is measured."""
    values: Callable[[Subject], Array | None]
    """All single values `(T, ...)`, NaN where one does not count; None where the bake has not what it takes, such as
    the true motion. The first axis is time or, for events, their number; of a count, one row for each thing counted."""
    kind: str = "distribution"
    """"distribution" (mean, std, p95, max), "number" (a mean alone), "share" (of frames) or "count" (of different
    rows)."""
    better: str = "lower"
    """"lower", "higher" or "" where neither is."""
    floor: bool = False
    """Whether the true motion has one of its own, to be shown beside."""
    series: bool = False
    """Whether reports have it over time."""
    tables: tuple[str, ...] = ()
    """Where else it is shown: of `TABLES`."""
    short: str = ""
    """Label in the panel and the graph, "" for `label`."""
    limit: float | None = None
    """The mean up to which the panel calls it good; None where it is not judged."""

    @property
    def heading(self) -> str:
        """Label in the panel and the graph."""
        return self.short or self.label.capitalize()

    def text(self, value: float) -> str:
        """A value with its unit."""
        if self.kind == "share":
            return f"{value:.0%}"
        if self.kind == "count":
            return f"{value:.0f}"
        return f"{value:.1f} {'per s' if self.unit == '1/s' else self.unit}".rstrip()


def get(metrics: Mapping[str, Any], path: str) -> float | None:
    """The number at `name`, `name.mean` or `name.floor.mean` of a report's `metrics`; None where there is
    none, or nothing was measured."""
    name, *rest = path.split(".")
    value: Any = metrics.get(name)
    for key in rest:
        if not isinstance(value, Mapping):
            return None
        inner = cast(Mapping[str, Any], value)
        value = inner.get(key) if inner.get("count") != 0 else None
    return float(value) if isinstance(value, int | float) else None

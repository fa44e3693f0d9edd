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
KINDS = ("distribution", "number", "share", "count", "total")
GROUPS = {
    "truth": "against the user's true motion",
    "motion": "the motion itself",
    "trackers": "against the trackers",
    "own": "agreement with the bake's own target, prediction and contacts",
    "played": "what was played",
}
"""What metrics compare with, in the order in which they are shown, and its heading."""
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
    group: str = "motion"
    """Of `GROUPS`."""
    kind: str = "distribution"
    """"distribution" (mean, std, p95, max), "number" (a mean alone), "share" (of frames), "count" (of different
    rows) or "total" (the sum)."""
    better: str = "lower"
    """"lower", "higher", "zero" for signed values, or "" where none is."""
    floor: bool = False
    """Whether the true motion has one of its own, to be shown beside."""
    series: bool = False
    """Whether reports have it over time."""
    tables: tuple[str, ...] = ()
    """Where else it is shown: of `TABLES`."""
    short: str = ""
    """Label in the panel and the graph, "" for `label`."""
    limit: float | None = None
    """The mean up to which (of shares that are better higher: from which) it is good; None where it is not judged."""
    worst: float | None = None
    """The mean of any second up to which it is good; needs `series`."""
    near_truth: bool = False
    """Whether the true motion's own is the measure where it is known: much less is as wrong as much more."""
    since: int = 0
    """Schema of reports from which on the name means this."""

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
        if self.kind == "total":
            return f"{value:.0f} {self.unit}"
        unit = {"1/s": "per s", "1/min": "per min"}.get(self.unit, self.unit)
        return f"{value:.1f} {unit}".rstrip()


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

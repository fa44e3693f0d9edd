"""Every metric by name, and what a body's motion gives for all of them.

Reports, comparisons, limits, series, the panel and docs/evaluation.md go by this table. A new metric is one entry in
one of the modules that it is put together from.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import feet, legs, played, root, tracking, truth
from .measures import Array, summary
from .metric import GROUPS, Metric
from .subject import Body, Subject, Yardstick, subjects

_ENTRIES = (*truth.METRICS, *feet.METRICS, *legs.METRICS, *tracking.METRICS, *root.METRICS, *played.METRICS)
METRICS: dict[str, Metric] = {
    metric.name: metric for group in GROUPS for metric in _ENTRIES if metric.group == group
}
"""In the order in which they are shown: what an outsider would confirm before what agrees with the bake itself."""

Metrics = dict[str, Any]
"""JSON-ready, by name. Where the true motion is known and has one, its own is in a distribution as "floor", beside
a number as "NAME_floor"."""


@dataclass(frozen=True, slots=True, eq=False)
class Values:
    """All single values that were measured, by metric; NaN does not count."""

    fps: float
    own: Mapping[str, Array]
    floor: Mapping[str, Array]
    """The same of the true motion, for the metrics that have one."""


def measure(yardstick: Yardstick, body: Body) -> Values:
    """Every metric on one body.

    Raises:
        InputError: the true motion has another length or rate than the body.
    """
    avatar, user = subjects(yardstick, body)
    floors = [metric for metric in METRICS.values() if metric.floor]
    return Values(
        body.fps,
        _measured(METRICS.values(), avatar),
        {} if user is None else _measured(floors, user),
    )


def _measured(metrics: Iterable[Metric], subject: Subject) -> dict[str, Array]:
    found = ((metric.name, metric.values(subject)) for metric in metrics)
    return {name: values for name, values in found if values is not None}


def summarise(values: Values) -> Metrics:
    """The metrics of a report."""
    out: Metrics = {}
    for name, metric in METRICS.items():
        if name not in values.own:
            continue
        own, floor = values.own[name], values.floor.get(name)
        if metric.kind == "count":
            out[name] = len(np.unique(own, axis=0))
        elif metric.kind == "total":
            out[name] = int(own.sum())
            if floor is not None:
                out[f"{name}_floor"] = int(floor.sum())
        elif metric.kind == "distribution":
            out[name] = {**summary(own), **({} if floor is None else {"floor": summary(floor)})}
        else:
            out[name] = _mean(own)
            if floor is not None:
                out[f"{name}_floor"] = _mean(floor)
    return out


def _mean(values: Array) -> float | None:
    """None where nothing was to be measured."""
    found = summary(values)
    return found["mean"] if found["count"] else None


def pool(parts: Sequence[Values]) -> Values:
    """All values of several bakes with the same databases together: a second of any counts the same."""

    def together(sides: Sequence[Mapping[str, Array]]) -> dict[str, Array]:
        names = [name for name in sides[0] if all(name in side for side in sides)]
        return {name: _joined(METRICS[name], [side[name] for side in sides]) for name in names}

    return Values(
        parts[0].fps, together([part.own for part in parts]), together([part.floor for part in parts])
    )


def _joined(metric: Metric, values: Sequence[Array]) -> Array:
    """A metric's values of several bakes: rows where they are counted, else numbers, since joints may differ."""
    if metric.kind == "count":
        return np.concatenate(values)
    return np.concatenate([value.ravel() for value in values])

"""What the paper's experiments share: users, databases, conditions, and the form of their results."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..database.motion_database import MotionDatabase
from ..jobs import Job, part
from ..matching.playback import Playback
from ..measure.catalogue import METRICS, Metrics, Values, pool, summarise
from ..measure.metric import get
from ..measure.series import stretch_means
from ..mocap.take import Take
from ..settings import PAPER, BakeSettings
from .evaluate import Predict, evaluate_take, lighten

Array = NDArray[np.floating[Any]]
Cell = str | float | int | None


@dataclass(frozen=True, slots=True, eq=False)
class Study:
    """On whom and with what the experiments are made."""

    takes: Sequence[Take]
    """The users, at the databases' rate."""
    databases: Sequence[MotionDatabase]
    predict: Predict | None
    """Body yaws of a recording; None gives the true ones."""
    settings: BakeSettings
    predictors: Mapping[str, Predict] = field(default_factory=dict[str, Predict])
    """Those whose orientation is compared, by label."""
    trained_on: Mapping[str, frozenset[str]] = field(default_factory=dict[str, frozenset[str]])
    """SHA-256 of the takes that each of them has seen in training."""


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """One line, or cloud of points, of a plot."""

    label: str
    x: Array
    y: Array


@dataclass(frozen=True, slots=True, eq=False)
class Plot:
    """A figure, to be drawn by whoever can."""

    title: str
    x: str
    y: str
    lines: Sequence[Line]
    kind: str = "lines"
    """"lines" or "points"; points have equal axes."""


@dataclass(frozen=True, slots=True)
class Relation:
    """Something that the paper found, and whether it is found here."""

    claim: str
    holds: bool
    figures: str

    def report(self) -> dict[str, Any]:
        """JSON-ready."""
        return {"claim": self.claim, "holds": self.holds, "figures": self.figures}


@dataclass(frozen=True, slots=True, eq=False)
class Experiment:
    """The result of one experiment."""

    name: str
    title: str
    about: str
    columns: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    relations: Sequence[Relation]
    plots: Sequence[Plot]
    notes: Sequence[str] = ()

    def report(self) -> dict[str, Any]:
        """JSON-ready, without the plots: their points would be motion of the takes."""
        return {
            "name": self.name,
            "title": self.title,
            "about": self.about,
            "columns": list(self.columns),
            "rows": [list(row) for row in self.rows],
            "relations": [relation.report() for relation in self.relations],
            "notes": list(self.notes),
        }


@dataclass(frozen=True, slots=True, eq=False)
class Runs:
    """All users of a study under one condition."""

    metrics: Metrics
    values: Sequence[Values]
    playbacks: Sequence[Playback]

    def mean(self, name: str) -> float:
        """The mean of a metric over all frames of all users."""
        return get(self.metrics, f"{name}.mean" if METRICS[name].kind == "distribution" else name) or 0.0

    def joined(self, name: str) -> Array:
        """A metric's values over time, one user after the other."""
        return np.concatenate([values.own[name] for values in self.values])


def as_paper(settings: BakeSettings) -> BakeSettings:
    """The paper's search and nothing after it: the matched motion alone is judged.

    Greedy search along a causal trajectory under springs, towards the centre of the head; no head or hands at
    the trackers, feet as matched. What else is set stays.
    """
    return replace(settings, **PAPER, head=False, arms=False, feet="matched")


def modes(settings: BakeSettings) -> dict[str, BakeSettings]:
    """The two conditions that most experiments are made under, by label."""
    return {"as the paper": as_paper(settings), "as set": settings}


def run_all(
    study: Study,
    conditions: Mapping[str, tuple[Sequence[MotionDatabase], BakeSettings]],
) -> Job[dict[str, Runs]]:
    """Every user under every condition, by label."""
    out: dict[str, Runs] = {}
    count = len(conditions) * len(study.takes)
    for label, (databases, settings) in conditions.items():
        values: list[Values] = []
        playbacks: list[Playback] = []
        for take in study.takes:
            at = len(out) * len(study.takes) + len(values)
            job = evaluate_take(take, databases, study.predict, settings)
            done = yield from part(job, at / count, (at + 1) / count)
            values.append(lighten(done.values))
            playbacks.append(done.result.playback)
        out[label] = Runs(summarise(pool(values)), values, playbacks)
    return out


def over_time(values: Array, fps: float, step_s: float) -> tuple[Array, Array]:
    """Minutes at the middle of each stretch of `step_s`, and the mean of the values `(T, ...)` there."""
    means = stretch_means(values, round(step_s * fps))
    return (np.arange(len(means)) + 0.5) * step_s / 60.0, means


def averaging(frames: int, fps: float) -> float:
    """The paper's 20 s to average over, or less where that would leave fewer than a dozen points."""
    return float(min(20.0, max(1.0, round(frames / fps / 12.0))))


def in_order(labels: Sequence[str], figures: Sequence[float], claim: str, unit: str) -> Relation:
    """The relation that `figures` rise from the first to the last."""
    text = " < ".join(f"{label} {figure:.1f}" for label, figure in zip(labels, figures, strict=True))
    holds = all(a < b for a, b in pairwise(figures))
    told = text if holds else text.replace(" < ", ", ")
    return Relation(claim, holds, f"{told} {unit}".rstrip())

"""A new metric needs its entry alone: reports, series, summaries, comparisons, limits and pages then have it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from footwork.core.body.edit import cut
from footwork.core.database.build import build_database
from footwork.core.evaluation.compare import compare_reports
from footwork.core.evaluation.evaluate import evaluate_takes
from footwork.core.evaluation.limits import failures, parse_limit
from footwork.core.evaluation.page import page
from footwork.core.jobs import run
from footwork.core.measure.catalogue import METRICS
from footwork.core.measure.metric import Metric
from footwork.core.measure.subject import Subject
from footwork.core.measure.words import report_in_words
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.take import Take
from footwork.core.settings import BakeSettings, DatabaseSettings


def above_the_hips(subject: Subject) -> np.ndarray:
    head = subject.body.skeleton.joint("head")
    return (subject.body.positions[:, head, 2] - subject.body.positions[:, 0, 2]) * 100.0


@pytest.fixture
def toy() -> Iterator[Metric]:
    metric = Metric(
        "head_above_hips_cm",
        "toy measure",
        "cm",
        "Height of the head over the hips",
        above_the_hips,
        floor=True,
        series=True,
        tables=("summary", "panel"),
        limit=40.0,
    )
    METRICS[metric.name] = metric
    yield metric
    del METRICS[metric.name]


def test_a_toy_metric_needs_its_entry_alone(toy: Metric) -> None:
    takes = [Take(name, f"{name}.bvh", name, demo_motion(name, 1), {}, ()) for name in ("walk", "visit")]
    user = cut(takes[1].motion, 0, 300)
    users = [Take("user", "user.bvh", "user", user, {}, ())]
    database = run(build_database(takes[:1], DatabaseSettings(), name="walk"))
    report = run(evaluate_takes(users, [database], None, BakeSettings()))
    figures = report["metrics"][toy.name]
    positions = user.forward()[0]
    own = 100.0 * (positions[:, user.skeleton.joint("head"), 2] - positions[:, 0, 2])
    assert figures["floor"]["mean"] == pytest.approx(own.mean(), rel=1e-6)
    assert figures["floor"]["count"] == len(user)
    entry = report["takes"][0]
    assert len(entry["series"][toy.name]) == 5
    assert any("toy measure, cm" in line for line in report_in_words(entry))
    (row,) = [row for row in compare_reports(report, report)["rows"] if row["metric"] == f"{toy.name}.mean"]
    assert row["verdict"] == "same"
    assert len(failures(report["metrics"], [parse_limit(f"{toy.name}.floor.mean > 1")])) == 1
    assert toy.says in page(report, {}, [])


@pytest.mark.parametrize(
    ("kind", "unit", "value", "text"),
    [
        ("distribution", "cm", 3.14, "3.1 cm"),
        ("number", "1/s", 2.0, "2.0 per s"),
        ("share", "", 0.256, "26%"),
        ("count", "", 1234.0, "1234"),
        ("distribution", "", 1.26, "1.3"),
    ],
)
def test_values_are_shown_with_their_unit(kind: str, unit: str, value: float, text: str) -> None:
    assert Metric("x", "x", unit, "x", lambda _: None, kind=kind).text(value) == text

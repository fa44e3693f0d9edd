"""The paper's experiments on the procedural demo: their form, what they vary, and that they tell the truth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core import jobs
from footwork.core.body.edit import cut
from footwork.core.database.build import build_database
from footwork.core.database.virtual_root import virtual_root
from footwork.core.errors import InputError
from footwork.core.evaluation.experiments import EXPERIMENTS
from footwork.core.evaluation.study import Experiment, Study, averaging, in_order, over_time
from footwork.core.evaluation.words import experiment_in_words
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.take import Take
from footwork.core.recording.body_estimate import BodyEstimate
from footwork.core.settings import BakeSettings, DatabaseSettings


def take(script: str, seed: int, stop: int = 100_000) -> Take:
    return Take(script, f"{script}.bvh", f"{seed}{script}", cut(demo_motion(script, seed), 0, stop), {}, ())


@pytest.fixture(scope="module")
def study() -> Study:
    upright = [take(script, i) for i, script in enumerate(("walk", "turn", "sidestep"))]
    walk = jobs.run(build_database(upright, DatabaseSettings(height_low=0.85, mirror=True), name="walk"))
    crouch = jobs.run(build_database([take("crouch", 3)], DatabaseSettings(height_high=0.85), name="crouch"))
    return Study([take("visit", 4)], [walk, crouch], None, BakeSettings(search="greedy"))


def make(name: str, study: Study) -> Experiment:
    experiment = jobs.run(EXPERIMENTS[name](study))
    assert experiment.name == name
    assert all(len(row) == len(experiment.columns) for row in experiment.rows)
    assert all(
        np.isfinite(line.y).any() and len(line.x) == len(line.y) for p in experiment.plots for line in p.lines
    )
    assert experiment.title in experiment_in_words(experiment.report())[0]
    return experiment


def column(experiment: Experiment, name: str) -> list:
    return [row[list(experiment.columns).index(name)] for row in experiment.rows]


def test_positional_error(study: Study) -> None:
    experiment = make("positional-error", study)
    frames = sum(len(database) for database in study.databases)
    assert column(experiment, "frames")[:3] == [frames, pytest.approx(0.25 * frames, abs=2), pytest.approx(
        0.1 * frames, abs=2)]  # fmt: skip
    assert max(column(experiment, "max")) <= 30.0 + 1e-3
    within = [relation for relation in experiment.relations if "never farther" in relation.claim]
    assert len(within) == 2 and all(relation.holds for relation in within)
    means = column(experiment, "root error, cm")
    for relation, figures in zip(experiment.relations[::2], (means[:3], means[3:]), strict=True):
        assert relation.holds == (figures[0] < figures[1] < figures[2])
    assert column(experiment, "paper, cm") == [19.0, 22.0, 27.0, None, None, None]


def test_coverage(study: Study) -> None:
    experiment = make("coverage", study)
    most = dict(zip(column(experiment, "alpha, m")[:2], column(experiment, "max")[:2], strict=True))
    assert most[0.1] <= 10.0 + 1e-3 and most[0.3] <= 30.0 + 1e-3
    used = column(experiment, "poses used")
    for plot, first in zip(experiment.plots, (0, 2), strict=True):
        assert plot.kind == "points"
        assert [len(line.x) for line in plot.lines[1:]] == used[first : first + 2]
    # 0.33 s ahead is less than a metre away for people who walk
    assert all(np.abs(line.y).max() < 1.0 for plot in experiment.plots for line in plot.lines)


def test_responsiveness(study: Study) -> None:
    experiment = make("responsiveness", study)
    betas, halves = column(experiment, "beta, 1/s"), column(experiment, "half-life, s")
    np.testing.assert_allclose(np.exp(-np.array(betas) * halves), 0.5)
    lags = column(experiment, "lag, s")
    assert all(0.0 <= lag <= 1.0 for lag in lags)
    assert experiment.relations[0].holds == (lags[-1] < lags[0])


def test_orientation(study: Study) -> None:
    def truth(recording) -> np.ndarray:
        return virtual_root(study.takes[0].motion)[1]

    def off(degrees: float):
        return lambda recording: BodyEstimate(truth(recording) + np.radians(degrees), None)

    ways = {"headset": off(20.0), "r = 50": off(-5.0), "r = 1": off(30.0), "ours": off(2.0)}
    seen = {"ours": frozenset([study.takes[0].sha256])}
    experiment = make("orientation", replace(study, predictors=ways, trained_on=seen))
    np.testing.assert_allclose(column(experiment, "mean, °"), [20.0, 5.0, 30.0, 2.0], atol=1e-6)
    np.testing.assert_allclose(column(experiment, "std"), 0.0, atol=1e-6)
    assert column(experiment, "takes seen in training") == ["0 of 1", "0 of 1", "0 of 1", "1 of 1"]
    assert [relation.holds for relation in experiment.relations] == [True, True, True]
    assert not experiment.notes

    worse = {**ways, "r = 50": off(25.0)}
    del worse["r = 1"]
    experiment = make("orientation", replace(study, predictors=worse))
    assert [relation.holds for relation in experiment.relations] == [False, True]
    assert len(experiment.notes) == 1 and "r = 1" in experiment.notes[0]


def test_leg_bend(study: Study) -> None:
    experiment = make("leg-bend", study)
    paper = [row for row in experiment.rows if row[0] == "as the paper"]
    knees = column(experiment, "knee error bent, °")[:2]
    assert knees[0] < 0.5 * knees[1], "the visitor crouches, and only one of the databases does"
    assert paper[0][-2] > 0.1 and paper[1][-2] == 0.0
    assert paper[0][-1] >= 2 and paper[1][-1] == 0


def test_leg_bend_needs_databases_and_people_who_crouch(study: Study) -> None:
    with pytest.raises(InputError, match="two databases"):
        make("leg-bend", replace(study, databases=study.databases[:1]))
    with pytest.raises(InputError, match="crouch"):
        make("leg-bend", replace(study, takes=[take("walk", 0, 300)]))


def test_relations_are_judged_by_their_figures() -> None:
    assert in_order(["a", "b"], [1.0, 2.0], "claim", "cm").holds
    assert not in_order(["a", "b"], [2.0, 2.0], "claim", "cm").holds
    assert "<" not in in_order(["a", "b"], [3.0, 2.0], "claim", "cm").figures


def test_averaging_over_time() -> None:
    x, y = over_time(np.arange(10.0), 2.0, 2.0)
    np.testing.assert_allclose(x * 60.0, [1.0, 3.0, 5.0])
    np.testing.assert_allclose(y, [1.5, 5.5, 8.5])
    assert averaging(20 * 60 * 60, 60.0) == 20.0, "as in the paper"
    assert averaging(60, 60.0) == 1.0

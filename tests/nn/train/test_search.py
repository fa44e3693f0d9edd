"""The search for training settings: what is drawn, who is pruned, and that the best trial is kept."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from footwork.core.errors import InputError
from footwork.core.jobs import Job, run
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.take import Take
from footwork.nn.inputs import Scaler
from footwork.nn.settings import TrainSettings
from footwork.nn.train import search as searching
from footwork.nn.train.held_out import held_out_error_deg
from footwork.nn.train.job import train_predictor
from footwork.nn.train.learners import make_learner
from footwork.nn.train.samples import samples_of
from footwork.nn.train.search import History, Search, Trained, check_search, search
from footwork.nn.weights import Predictor, read_predictor

HAS_OPTUNA = importlib.util.find_spec("optuna") is not None
needs_optuna = pytest.mark.skipif(not HAS_OPTUNA, reason="optuna is not installed")
needs_torch = pytest.mark.skipif(importlib.util.find_spec("torch") is None, reason="torch is not installed")


class StandIn:
    """Trains nothing: a trial's error falls with its measurements towards what its settings are worth."""

    def __init__(self, measurements: int = 15) -> None:
        self.measurements = measurements
        self.asked: list[TrainSettings] = []
        self.curves: list[list[float]] = []
        self.learnt: list[Trained] = []
        self.closed = 0

    def __call__(self, settings: TrainSettings, ended: Callable[[History], bool]) -> Job[Trained]:
        self.asked.append(settings)
        # crossing curves, so that the least at an early measurement need not be the least at the end
        worth = 5.0 + abs(np.log10(settings.learning_rate / 3e-4)) + settings.decay
        curve = [worth + 20.0 * settings.learning_rate * 1e3 / k for k in range(1, self.measurements + 1)]
        self.curves.append(curve)
        history: History = []
        try:
            for k, error in enumerate(curve):
                yield k / len(curve), "between measurements"
                history.append({"step": 10.0 * k, "loss": 1.0, "held_out_deg": error})
                yield (k + 1) / len(curve), f"held out {error:.2f} degrees"
                if ended(history):
                    break
        except GeneratorExit:
            self.closed += 1
            raise
        predictor = Predictor(f"{len(self.asked)}", (), Scaler(np.zeros(1), np.ones(1)), None, 0.0, {})
        self.learnt.append(Trained(predictor, history[-1]["held_out_deg"], history))
        return self.learnt[-1]


def _search(settings: TrainSettings, **how: int) -> tuple[Search, StandIn]:
    train = StandIn(**how)
    return run(search(settings, train)), train


def _halving(curves: list[list[float]]) -> list[int | None]:
    """After how many measurements asynchronous successive halving prunes each, written down anew."""
    rungs: dict[int, list[float]] = {5: [], 10: []}
    ends: list[int | None] = []
    for curve in curves:
        end = None
        for at, passed in rungs.items():
            passed.append(curve[at - 1])
            if sorted(passed).index(curve[at - 1]) >= max(1, len(passed) // 2):
                end = at
                break
        ends.append(end)
    return ends


@needs_optuna
def test_the_worse_half_is_pruned_and_the_best_of_the_rest_kept() -> None:
    found, train = _search(TrainSettings(trials=12, seed=3))
    ends = _halving(train.curves)
    assert {None, 5, 10} >= set(ends) and None in ends and 5 in ends
    assert [row["pruned"] for row in found.trials] == [end is not None for end in ends]
    assert [row["measurements"] for row in found.trials] == [end or 15 for end in ends]
    for row, curve, end in zip(found.trials, train.curves, ends, strict=True):
        assert row["held_out_error_deg"] == pytest.approx(curve[(end or 15) - 1], abs=1e-3)
    best = int(np.argmin([trained.error_deg for trained in train.learnt]))
    assert found.best is train.learnt[best]
    assert found.settings == replace(train.asked[best], time_limit=TrainSettings().time_limit)


@needs_optuna
def test_a_pruned_trial_can_be_the_best() -> None:
    """The second is pruned for its fifth measurement; the first has got worse since its own."""
    curves = iter([[9.0] * 5 + [20.0] * 5, [10.0] * 15, [11.0] * 15])

    def train(settings: TrainSettings, ended: Callable[[History], bool]) -> Job[Trained]:
        history: History = []
        for error in next(curves):
            history.append({"held_out_deg": error})
            yield 0.0, ""
            if ended(history):
                break
        predictor = Predictor("", (), Scaler(np.zeros(1), np.ones(1)), None, 0.0, {})
        return Trained(predictor, error, history)

    found = run(search(TrainSettings(trials=3), train))
    assert [(row["held_out_error_deg"], row["pruned"]) for row in found.trials] == [
        (20.0, False),
        (10.0, True),
        (11.0, True),
    ]
    assert found.best.error_deg == 10.0


@needs_optuna
@pytest.mark.parametrize(("kind", "widths"), [("paper", {32, 64, 128}), ("causal", {64, 128, 256})])
def test_what_is_drawn(kind: str, widths: set[int]) -> None:
    settings = TrainSettings(kind=kind, trials=20, batch=77, time_limit=100.0)
    found, train = _search(settings, measurements=2)
    assert {row["hidden"] for row in found.trials} == widths
    for drawn, row in zip(train.asked, found.trials, strict=True):
        assert 1e-4 <= drawn.learning_rate <= 1e-3 and 1e-2 <= drawn.decay <= 1.0
        assert (drawn.batch, drawn.kind, drawn.seed) == (77, kind, 0)
        assert all(row[name] == getattr(drawn, name) for name in ("hidden", "learning_rate", "decay"))
    assert train.asked[0].time_limit <= 100.0 / 20


@needs_optuna
def test_same_seed_same_trials() -> None:
    settings = TrainSettings(trials=12, seed=1)
    one, other, another = (_search(replace(settings, seed=seed))[0].trials for seed in (1, 1, 2))
    assert one == other != another


@needs_optuna
def test_progress_rises_and_names_the_trial() -> None:
    steps: list[tuple[float, str]] = []
    run(search(TrainSettings(trials=6), StandIn()), lambda *step: steps.append(step))
    fractions = [fraction for fraction, _ in steps]
    assert fractions == sorted(fractions) and fractions[-1] == 1.0
    assert all(message.startswith("trial ") for _, message in steps)
    assert any("pruned after 5" in message for _, message in steps)


@needs_optuna
def test_a_search_that_is_cancelled_ends_the_training() -> None:
    train = StandIn()
    job = search(TrainSettings(trials=3), train)
    next(job)
    job.close()
    assert train.closed == 1


def test_without_optuna_one_line_says_how_to_get_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "optuna" else object())
    job = train_predictor([], TrainSettings(trials=2), tmp_path / "p.npz")
    with pytest.raises(InputError, match="pip install optuna") as caught:
        run(job)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("settings", "said"),
    [(TrainSettings(trials=2, resume=True), "resume"), (TrainSettings(trials=2, voters=2), "one voter")],
)
def test_what_cannot_be_searched_with(
    settings: TrainSettings, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(searching.importlib.util, "find_spec", lambda name: object())
    with pytest.raises(InputError, match=said):
        check_search(settings)
    check_search(TrainSettings(kind="paper", trials=2, voters=2))


@pytest.fixture(scope="module")
def takes() -> list[Take]:
    motions = [demo_motion("turn", 1), demo_motion("walk", 0)]
    return [Take(f"{n}", f"{n}.bvh", "0" * 64, motion, {}, ()) for n, motion in enumerate(motions)]


@needs_torch
@pytest.mark.parametrize(
    ("kind", "hidden", "widths"),
    [
        ("paper", 0, (32, 32)),
        ("paper", 64, (64, 64)),
        ("look-ahead", 0, (256, 128)),
        ("look-ahead", 64, (64, 32)),
    ],
)
def test_hidden_widths(takes: list[Take], kind: str, hidden: int, widths: tuple[int, ...]) -> None:
    samples = samples_of(takes)[0]
    learner, _ = make_learner(samples, TrainSettings(kind=kind, hidden=hidden), 0)
    assert learner.network().sizes[1:-1] == widths


@needs_optuna
@needs_torch
@pytest.mark.parametrize("kind", ["look-ahead", "paper"])
def test_a_small_search_writes_what_its_best_trial_has_learnt(
    tmp_path: Path, takes: list[Take], kind: str
) -> None:
    settings = TrainSettings(
        kind=kind, trials=3, iterations=2, epochs=1, batch=256, seed=5, keep_worse=True, time_limit=3600.0
    )
    paths = [tmp_path / "a" / "p.npz", tmp_path / "b" / "p.npz"]
    reports = []
    for path in paths:
        path.parent.mkdir()
        reports.append(run(train_predictor(takes, settings, path)))
    assert [file.name for file in tmp_path.rglob("*.*")] == ["p.npz", "p.npz"]
    one, other = (read_predictor(path) for path in paths)
    for a, b in zip(one.networks[0].weights, other.networks[0].weights, strict=True):
        np.testing.assert_array_equal(a, b)
    assert reports[0]["trials"] == reports[1]["trials"] == one.provenance["trials"]
    best = min(one.provenance["trials"], key=lambda row: row["held_out_error_deg"])
    assert one.provenance["held_out_error_deg"] == best["held_out_error_deg"]
    kept = one.provenance["settings"]
    assert {name: kept[name] for name in ("hidden", "learning_rate", "decay")} == {
        name: best[name] for name in ("hidden", "learning_rate", "decay")
    }
    assert (kept["trials"], kept["time_limit"]) == (3, 3600.0)
    assert one.networks[0].sizes[1] == best["hidden"]
    # the file holds what was measured
    (testing,) = [take for take in takes if take.name in one.provenance["held_out"]]
    error = held_out_error_deg(one, samples_of([testing])[0])
    assert error == pytest.approx(best["held_out_error_deg"], abs=1e-2)

"""Search for the settings that learn best, by asynchronous successive halving as the paper's were found.

optuna draws and stops trials; it is needed for nothing else.
"""

from __future__ import annotations

import importlib
import importlib.util
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from ...core.errors import InputError
from ...core.jobs import Job, part
from ..settings import TrainSettings
from ..weights import Predictor

GRACE, REDUCTION = 5, 2
"""Measurements before the first halving, and one in how many goes on after each."""
PAPER_WIDTHS = (32, 64, 128)
WINDOW_WIDTHS = (64, 128, 256)
LEARNING_RATES = (1e-4, 1e-3)
DECAYS = (1e-2, 1.0)
NO_OPTUNA = "trials need optuna, which is not installed; get it with: pip install optuna"

History = list[dict[str, float]]


@dataclass(frozen=True, slots=True, eq=False)
class Trained:
    """What one trial has learnt."""

    predictor: Predictor
    error_deg: float
    """On held-out takes."""
    history: History
    """Its measurements."""


Train = Callable[[TrainSettings, Callable[[History], bool]], Job[Trained]]


@dataclass(frozen=True, slots=True, eq=False)
class Search:
    """What a search has found."""

    best: Trained
    """The trial with the least held-out error, pruned or not."""
    settings: TrainSettings
    """With what that trial has drawn."""
    trials: list[dict[str, Any]]
    """JSON-ready: what each has drawn, its held-out error in degrees, after how many measurements, and whether it
    was pruned."""


def check_search(settings: TrainSettings) -> None:
    """Raise InputError where the trials that are asked for cannot be made."""
    if importlib.util.find_spec("optuna") is None:
        raise InputError(NO_OPTUNA)
    if settings.resume:
        raise InputError("trials begin anew, each with other settings; leave out either trials or resume")
    if settings.voters > 1 and settings.kind != "paper":
        raise InputError(
            "trials are of one network each; search with one voter, then train several with what was found"
        )


def search(settings: TrainSettings, train: Train) -> Job[Search]:
    """Train as often as `settings.trials` says, each time under other settings, and keep the best.

    Hidden width, learning rate and weight decay are drawn from the space that the paper's network was tuned in,
    window networks being wider. After `GRACE` measurements, and again after twice as many, a trial goes on only
    if it is among the better half of those that got there. The trials share the time limit. Same settings and
    seed, same trials, unless time runs out.

    Args:
        settings: what the trials have in common.
        train: trains under settings. After each measurement it asks the function given, with all measurements so
            far, whether to end there.
    """
    # by name, so that types can be checked without it
    optuna: Any = importlib.import_module("optuna")
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    study = optuna.create_study(
        sampler=optuna.samplers.TPESampler(seed=settings.seed),
        pruner=optuna.pruners.SuccessiveHalvingPruner(min_resource=GRACE, reduction_factor=REDUCTION),
    )
    deadline = time.monotonic() + settings.time_limit
    rows: list[dict[str, Any]] = []
    best: tuple[Trained, TrainSettings] | None = None
    for n in range(settings.trials):
        trial, name = study.ask(), f"trial {n + 1} of {settings.trials}"
        drawn = _draw(trial, settings)
        ended = _Pruning(trial)
        share = (deadline - time.monotonic()) / (settings.trials - n)
        job = _named(train(replace(drawn, time_limit=share), ended), name)
        trained = yield from part(job, n / settings.trials, (n + 1) / settings.trials)
        rows.append(_row(drawn, trained, ended.pruned))
        yield (n + 1) / settings.trials, f"{name}: {_in_words(rows[-1])}"
        if ended.pruned:
            study.tell(trial, state=optuna.trial.TrialState.PRUNED)
        else:
            study.tell(trial, trained.error_deg)
        if best is None or trained.error_deg < best[0].error_deg:
            best = trained, drawn
    assert best is not None, "there is at least one trial"
    return Search(*best, rows)


@dataclass(slots=True)
class _Pruning:
    """Tells a trial's measurements, and whether it is to end for them."""

    trial: Any
    pruned: bool = False

    def __call__(self, history: History) -> bool:
        self.trial.report(history[-1]["held_out_deg"], len(history))
        self.pruned = self.trial.should_prune()
        return self.pruned


def _draw(trial: Any, settings: TrainSettings) -> TrainSettings:
    widths = PAPER_WIDTHS if settings.kind == "paper" else WINDOW_WIDTHS
    return replace(
        settings,
        hidden=trial.suggest_categorical("hidden", widths),
        learning_rate=trial.suggest_float("learning_rate", *LEARNING_RATES, log=True),
        decay=trial.suggest_float("decay", *DECAYS, log=True),
    )


def _row(drawn: TrainSettings, trained: Trained, pruned: bool) -> dict[str, Any]:
    return {
        **{name: getattr(drawn, name) for name in ("hidden", "learning_rate", "decay")},
        "held_out_error_deg": round(trained.error_deg, 3),
        "measurements": len(trained.history),
        "pruned": pruned,
    }


def _in_words(row: dict[str, Any]) -> str:
    """A trial for people."""
    drawn = f"hidden {row['hidden']}, learning rate {row['learning_rate']:.1e}, decay {row['decay']:.2f}"
    error = f"{row['held_out_error_deg']:.2f} degrees"
    return f"{error} with {drawn}" + (f", pruned after {row['measurements']}" if row["pruned"] else "")


def _named(job: Job[Trained], name: str) -> Job[Trained]:
    """`job` with its name before each message."""
    while True:
        try:
            fraction, message = next(job)
        except StopIteration as end:
            return end.value
        yield fraction, f"{name}: {message}"

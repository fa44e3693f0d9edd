"""The whole training: takes in, a predictor's file and a report out."""

from __future__ import annotations

import importlib.util
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from ...core.errors import InputError
from ...core.jobs import Job
from ...core.mocap.take import Take
from ...core.settings import check
from ...core.transaction import Transaction, joined
from ..settings import TrainSettings
from ..weights import Predictor, save_predictor
from .beginning import Beginning, find_beginning, restore_learner, save
from .checkpoint import Progress, remove_checkpoint
from .fit import fit
from .held_out import headset_forward_error_deg, held_out_error_deg
from .learners import make_learner
from .search import History, Trained, check_search, search
from .split import Material, split

NO_TORCH = (
    "training needs torch, which is not installed; get it with: pip install torch (baking works without it)"
)


def train_predictor(
    takes: Sequence[Take],
    settings: TrainSettings,
    output: Path,
    *,
    held_out: Sequence[Take] = (),
    licences: Mapping[str, str] | None = None,
    outputs: Transaction | None = None,
) -> Job[dict[str, Any]]:
    """Train a predictor and write it to `output`.

    Yields `(fraction, message)` with the loss and the held-out error. On the way it keeps a checkpoint beside
    `output`, which stays when it is cancelled or fails and goes once `output` is written; nothing else is
    written before the end.

    Args:
        takes: what to learn from.
        settings: kind, length, seed.
        output: the `.npz` to write. With `settings.resume` training goes on from its checkpoint exactly as if
            it had not stopped; where there is none, from the weights of `output` with a fresh optimiser.
        held_out: takes to measure the error on; by default some of `takes` are kept back.
        licences: licence of each take by name, for the provenance.
        outputs: the transaction that `output` is part of; None to write it at once.

    Returns:
        A JSON-ready report: errors in degrees on the held-out takes, beside the headset's forward, and what
        was left out.

    Raises:
        InputError: torch is missing, the takes are too short, there is nothing to resume or it belongs to
            another training, or the result is worse than the headset's forward.
    """
    _check(settings)
    beginning = find_beginning(output, settings, takes, held_out)
    yield 0.0, "reading takes"
    material = split(takes, held_out, settings)
    headset_deg = headset_forward_error_deg(material.testing)
    began = time.monotonic()
    made = yield from _make(material, settings, beginning)
    if made.error_deg >= headset_deg and not settings.keep_worse:
        raise _no_better(output, made.error_deg, headset_deg, settings)
    report = _report(output, made, headset_deg, material.left_out, time.monotonic() - began)
    provenance = {
        **_provenance(made.settings, report),
        "takes": [_origin(take, licences) for take in takes],
        "held_out": sorted({sample.take for sample in material.testing}),
    }
    with joined(outputs) as transaction:
        made_here = replace(made.predictor, name=output.stem, provenance=provenance)
        save_predictor(output, made_here, transaction)
        transaction.afterwards(partial(remove_checkpoint, beginning.path))
    told = f"{made.error_deg:.1f} degrees on held-out takes, the headset's forward {headset_deg:.1f}"
    yield 1.0, f"{output.name}: {told}"
    return report


def _check(settings: TrainSettings) -> None:
    """Raise InputError where the training that is asked for cannot be made."""
    check(settings)
    if importlib.util.find_spec("torch") is None:
        raise InputError(NO_TORCH)
    if settings.trials:
        check_search(settings)


@dataclass(frozen=True, slots=True, eq=False)
class _Made:
    """What a training, or the best trial of a search, has come to."""

    predictor: Predictor
    error_deg: float
    """On held-out takes."""
    history: History
    settings: TrainSettings
    """With what a search has drawn."""
    trials: list[dict[str, Any]] | None


def _make(material: Material, settings: TrainSettings, beginning: Beginning) -> Job[_Made]:
    if settings.trials:
        found = yield from search(settings, partial(_trial, material))
        best = found.best
        return _Made(best.predictor, best.error_deg, best.history, found.settings, found.trials)
    predictor, history = yield from _train(material, settings, beginning)
    return _Made(predictor, held_out_error_deg(predictor, material.testing), history, settings, None)


def _train(
    material: Material, settings: TrainSettings, beginning: Beginning
) -> Job[tuple[Predictor, History]]:
    """The best predictor by held-out error, and the losses on the way."""
    voters = 1 if settings.kind == "paper" else settings.voters
    deadline = time.monotonic() + settings.time_limit
    saved, scaler, learner = beginning.saved, None, None
    progress = Progress() if saved is None else saved.progress
    while (turn := len(progress.found)) < voters:
        seed = settings.seed + turn
        if saved is None:
            learner, steps = make_learner(material.training, settings, seed, beginning.start, scaler)
        else:
            learner, steps = restore_learner(material.training, settings, seed, beginning.path, saved)
            saved = None
            yield (turn + progress.step / steps) / voters, f"going on after step {progress.step} of {steps}"
        scaler = learner.scaler
        limit = time.monotonic() + (deadline - time.monotonic()) / (voters - turn)
        keep = partial(save, beginning, progress, learner)
        yield from fit(learner, steps, material.testing, settings, limit, (turn, voters), progress, keep)
        progress = progress.next_voter()
    assert learner is not None, "a checkpoint has a voter that is not done"
    return replace(learner.predictor(), networks=tuple(progress.found)), progress.history


def _trial(material: Material, settings: TrainSettings, ended: Callable[[History], bool]) -> Job[Trained]:
    """One network of a search; without checkpoints, since a search begins anew."""
    deadline = time.monotonic() + settings.time_limit
    learner, steps = make_learner(material.training, settings, settings.seed)
    progress, measured = Progress(), 0
    for told in fit(learner, steps, material.testing, settings, deadline, (0, 1), progress, lambda: None):
        yield told
        if len(progress.history) > measured:
            measured = len(progress.history)
            if ended(progress.history):
                break
    assert progress.best is not None, "fit keeps the network that it began with, at least"
    predictor = replace(learner.predictor(), networks=(progress.best,))
    return Trained(predictor, held_out_error_deg(predictor, material.testing), progress.history)


def _no_better(output: Path, error_deg: float, headset_deg: float, settings: TrainSettings) -> InputError:
    """What to say of a predictor that is not worth writing."""
    anyway = "keep-worse" if settings.trials else "resume and keep-worse"
    return InputError(
        f"{output}: not written, {error_deg:.1f} degrees on held-out takes is no better than the headset's "
        f"forward ({headset_deg:.1f}); give more takes or epochs, or save it all the same with {anyway}"
    )


def _report(
    output: Path, made: _Made, headset_deg: float, left_out: Sequence[str], seconds: float
) -> dict[str, Any]:
    """JSON-ready: what came of a training."""
    return {
        "file": str(output),
        "kind": made.settings.kind,
        "held_out_error_deg": round(made.error_deg, 3),
        "headset_forward_error_deg": round(headset_deg, 3),
        "seconds": round(seconds, 1),
        "parameters": made.predictor.parameters,
        "losses": made.history,
        "left_out": list(left_out),
        **({} if made.trials is None else {"trials": made.trials}),
    }


def _provenance(settings: TrainSettings, report: Mapping[str, Any]) -> dict[str, Any]:
    """What a predictor's file tells of its training."""
    told = ("held_out_error_deg", "headset_forward_error_deg", "losses", "left_out", "trials")
    return {
        **{key: report[key] for key in told if key in report},
        "settings": {name: getattr(settings, name) for name in settings.__slots__},
    }


def _origin(take: Take, licences: Mapping[str, str] | None) -> dict[str, str]:
    origin = {"take": take.name, "sha256": take.sha256}
    if licences is not None:
        origin["licence"] = licences[take.name]
    return origin

"""Training of body-orientation predictors; the only part of Footwork that needs torch."""

from __future__ import annotations

import importlib.util
import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ..core.errors import InputError
from ..core.jobs import Job
from ..core.measure.measures import yaw_errors
from ..core.mocap.take import Take
from ..core.settings import check
from .checkpoint import (
    Checkpoint,
    Progress,
    checkpoint_path,
    damaged,
    origin_of,
    other_version,
    read_checkpoint,
    remove_checkpoint,
    write_checkpoint,
)
from .inputs import INPUTS, RATE, Scaler, headings
from .network import Network
from .predictor import run_recurrent, run_windows
from .samples import Array, Sample, samples_of
from .search import Trained, check_search, search
from .settings import TrainSettings
from .weights import Predictor, read_predictor, save_predictor
from .windows import CAUSAL, LOOK_AHEAD, stream

MEASUREMENTS = 15
"""How often the held-out error is measured in a full training."""
SAVE_EVERY_S = 15.0
"""A checkpoint is written at each measurement, and this often where measurements are far apart."""
PAPER_HIDDEN = (32, 32)
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

    Returns:
        A JSON-ready report: errors in degrees on the held-out takes, beside the headset's forward, and what
        was left out.

    Raises:
        InputError: torch is missing, the takes are too short, there is nothing to resume or it belongs to
            another training, or the result is worse than the headset's forward.
    """
    check(settings)
    if importlib.util.find_spec("torch") is None:
        raise InputError(NO_TORCH)
    if settings.trials:
        check_search(settings)
    plan = _plan(output, settings, takes, held_out)
    yield 0.0, "reading takes"
    training, testing, notes = _split(takes, held_out, settings)
    forward = headset_forward_error_deg(testing)
    began = time.monotonic()
    trials: list[dict[str, Any]] | None = None
    if settings.trials:
        found = yield from search(settings, partial(_trial, training, testing))
        predictor, history = found.best.predictor, found.best.history
        settings, trials = found.settings, found.trials
    else:
        predictor, history = yield from _train(training, testing, settings, plan)
    error = held_out_error_deg(predictor, testing)
    if error >= forward and not settings.keep_worse:
        raise InputError(
            f"{output}: not written, {error:.1f} degrees on held-out takes is no better than the headset's "
            f"forward ({forward:.1f}); give more takes or epochs, or save it all the same with "
            + ("keep-worse" if settings.trials else "resume and keep-worse")
        )
    report = {
        "file": str(output),
        "kind": settings.kind,
        "held_out_error_deg": round(error, 3),
        "headset_forward_error_deg": round(forward, 3),
        "seconds": round(time.monotonic() - began, 1),
        "parameters": predictor.parameters,
        "losses": history,
        "left_out": notes,
        **({} if trials is None else {"trials": trials}),
    }
    told = ("held_out_error_deg", "headset_forward_error_deg", "losses", "left_out", "trials")
    provenance = {
        **{key: report[key] for key in told if key in report},
        "settings": {name: getattr(settings, name) for name in settings.__slots__},
        "takes": [_origin(take, licences) for take in takes],
        "held_out": sorted({sample.take for sample in testing}),
    }
    save_predictor(output, replace(predictor, name=output.stem, provenance=provenance))
    remove_checkpoint(plan.path)
    yield 1.0, f"{output.name}: {error:.1f} degrees on held-out takes, the headset's forward {forward:.1f}"
    return report


@dataclass(frozen=True, slots=True)
class _Plan:
    """Where a training begins, and where its checkpoint lies."""

    path: Path
    origin: Mapping[str, Any]
    saved: Checkpoint | None
    start: Predictor | None


def _plan(output: Path, settings: TrainSettings, takes: Sequence[Take], held_out: Sequence[Take]) -> _Plan:
    """Raises InputError where there is nothing to resume, or it is of another training."""
    path, origin = checkpoint_path(output), origin_of(settings, takes, held_out)
    if not settings.resume:
        return _Plan(path, origin, None, None)
    if path.exists():
        saved = read_checkpoint(path, origin)
        start = None if saved.start is None else _begun_with(saved.start, saved.scaler)
        return _Plan(path, origin, saved, start)
    if output.exists():
        return _Plan(path, origin, None, read_predictor(output))
    raise InputError(
        f"{output}: neither it nor {path.name} is there to go on from; start anew without resume"
    )


def _origin(take: Take, licences: Mapping[str, str] | None) -> dict[str, str]:
    origin = {"take": take.name, "sha256": take.sha256}
    if licences is not None:
        origin["licence"] = licences[take.name]
    return origin


def _split(
    takes: Sequence[Take], held_out: Sequence[Take], settings: TrainSettings
) -> tuple[list[Sample], list[Sample], list[str]]:
    """Samples to learn from, samples to measure on, and what was left out. Whole takes, or the end of a
    single one."""
    samples, notes = samples_of(takes)
    if held_out:
        testing, more = samples_of(held_out)
        return _long_enough(samples, settings), testing, notes + more
    names = sorted({sample.take for sample in samples})
    if len(names) < 2:
        halves = [_cut(sample, 1.0 - settings.held_out) for sample in samples]
        return _long_enough([a for a, _ in halves], settings), [b for _, b in halves], notes
    order = np.random.default_rng(settings.seed).permutation(len(names))
    lengths = {name: sum(len(s) for s in samples if s.take == name) for name in names}
    wanted, chosen = settings.held_out * sum(lengths.values()), set[str]()
    for index in order[:-1]:
        if wanted <= 0:
            break
        chosen.add(names[index])
        wanted -= lengths[names[index]]
    training = [s for s in samples if s.take not in chosen]
    return _long_enough(training, settings), [s for s in samples if s.take in chosen], notes


def _long_enough(samples: list[Sample], settings: TrainSettings) -> list[Sample]:
    least = settings.iterations + 2 if settings.kind == "paper" else 2
    kept = [sample for sample in samples if len(sample) >= least]
    if sum(len(sample) for sample in kept) < 10 * RATE:
        raise InputError("the takes hold less than ten seconds fit to learn from; give more or longer takes")
    return kept


def _cut(sample: Sample, share: float) -> tuple[Sample, Sample]:
    at = int(len(sample) * share)
    first, second = (
        replace(sample, positions=sample.positions[s], rotations=sample.rotations[s], yaws=sample.yaws[s])
        for s in (slice(None, at), slice(at, None))
    )
    return first, second


def _train(
    training: list[Sample], testing: list[Sample], settings: TrainSettings, plan: _Plan
) -> Job[tuple[Predictor, list[dict[str, float]]]]:
    """The best predictor by held-out error, and the losses on the way."""
    voters = 1 if settings.kind == "paper" else settings.voters
    deadline = time.monotonic() + settings.time_limit
    saved, scaler, learner = plan.saved, None, None
    progress = Progress() if saved is None else saved.progress
    while (turn := len(progress.found)) < voters:
        seed = settings.seed + turn
        if saved is None:
            learner, steps = make_learner(training, settings, seed, plan.start, scaler)
        else:
            learner, steps = _restore_learner(training, settings, seed, plan.path, saved)
            saved = None
            yield (turn + progress.step / steps) / voters, f"going on after step {progress.step} of {steps}"
        scaler = learner.scaler
        limit = time.monotonic() + (deadline - time.monotonic()) / (voters - turn)
        save = partial(_save, plan, progress, learner)
        yield from _fit(learner, steps, testing, settings, limit, (turn, voters), progress, save)
        progress = progress.next_voter()
    return replace(learner.predictor(), networks=tuple(progress.found)), progress.history


def _trial(
    training: list[Sample],
    testing: list[Sample],
    settings: TrainSettings,
    ended: Callable[[list[dict[str, float]]], bool],
) -> Job[Trained]:
    """One network of a search; without checkpoints, since a search begins anew."""
    deadline = time.monotonic() + settings.time_limit
    learner, steps = make_learner(training, settings, settings.seed)
    progress, measured = Progress(), 0
    for told in _fit(learner, steps, testing, settings, deadline, (0, 1), progress, lambda: None):
        yield told
        if len(progress.history) > measured:
            measured = len(progress.history)
            if ended(progress.history):
                break
    predictor = replace(learner.predictor(), networks=(progress.best,))
    return Trained(predictor, held_out_error_deg(predictor, testing), progress.history)


def _save(plan: _Plan, progress: Progress, learner: Any) -> None:
    start = None if plan.start is None else plan.start.networks[0]
    state = Checkpoint(plan.origin, progress, learner.scaler, learner.network(), start, learner.state())
    write_checkpoint(plan.path, state)


def _restore_learner(
    samples: list[Sample], settings: TrainSettings, seed: int, path: Path, saved: Checkpoint
) -> tuple[Any, int]:
    """The learner as it was, and its number of steps."""
    try:
        learner, steps = make_learner(samples, settings, seed, _begun_with(saved.network, saved.scaler))
        learner.restore(saved.state)
    except InputError as error:
        raise other_version(path) from error
    except (ValueError, KeyError, TypeError, ArithmeticError, RuntimeError) as error:
        raise damaged(path) from error
    return learner, steps


def _begun_with(network: Network, scaler: Scaler) -> Predictor:
    """Weights for a learner to begin with."""
    return Predictor("", (network,), scaler, None, 0.0, {})


def make_learner(
    samples: list[Sample],
    settings: TrainSettings,
    seed: int,
    start: Predictor | None = None,
    scaler: Scaler | None = None,
) -> tuple[Any, int]:
    """The learner of the settings' kind and its number of steps; `scaler` is the first voter's, for those
    after it.

    Raises:
        InputError: the weights to start from are of another kind of network.
    """
    frames = sum(len(sample) for sample in samples)
    if settings.kind == "paper":
        from .train_paper import RecurrentLearner

        hidden = (settings.hidden,) * 2 if settings.hidden else PAPER_HIDDEN
        _check_sizes(start, (INPUTS, *hidden, 6))
        batch = settings.batch or 64
        learner = RecurrentLearner(
            samples,
            iterations=settings.iterations,
            hidden=hidden,
            batch=batch,
            learning_rate=settings.learning_rate or 3e-4,
            decay=settings.decay,
            seed=seed,
            start=start,
        )
        return learner, learner.steps_per_epoch * (settings.epochs or 10)
    from .train_window import HIDDEN, WindowLearner

    layout = CAUSAL if settings.kind == "causal" else LOOK_AHEAD
    hidden = (settings.hidden, -(-settings.hidden // 2)) if settings.hidden else HIDDEN
    _check_sizes(start, (layout.inputs, *hidden, 2))
    batch = settings.batch or 512
    steps = max(1, frames // batch) * (settings.epochs or 15)
    learner = WindowLearner(
        samples,
        layout,
        hidden=hidden,
        batch=batch,
        learning_rate=settings.learning_rate or 1e-3,
        decay=settings.decay,
        steps=steps,
        seed=seed,
        start=start,
        scaler=scaler,
    )
    return learner, steps


def _check_sizes(start: Predictor | None, sizes: tuple[int, ...]) -> None:
    if start is not None and start.networks[0].sizes != sizes:
        raise InputError(
            "the weights to go on from are of another kind, width or version of network; ask for theirs, or "
            "start anew without resume"
        )


def _fit(
    learner: Any,
    steps: int,
    testing: list[Sample],
    settings: TrainSettings,
    deadline: float,
    turn: tuple[int, int],
    progress: Progress,
    save: Callable[[], None],
) -> Job[None]:
    """Train one network until it is done, stops getting better, or is out of time; `progress` keeps the best."""
    if progress.best is None:
        progress.best = learner.network()
    every = max(1, steps // MEASUREMENTS)
    saved = -math.inf
    try:
        while progress.step < steps and progress.waited < settings.patience:
            progress.losses.append(learner.step())
            progress.step += 1
            n, late = progress.step, time.monotonic() > deadline
            measured = n % every == 0 or n == steps or late
            if measured:
                message = _measure(learner, testing, progress)
            elif n % 20 == 0:
                message = f"step {n} of {steps}, best {progress.best_error_deg:.2f} degrees"
            else:
                continue
            if measured or time.monotonic() > saved + SAVE_EVERY_S:
                save()
                saved = time.monotonic()
            yield (turn[0] + n / steps) / turn[1], message
            if late:
                break
    except GeneratorExit:
        save()
        raise


def _measure(learner: Any, testing: list[Sample], progress: Progress) -> str:
    """Take the held-out error into `progress`; returns what to say of it."""
    candidate = learner.predictor()
    error, loss = held_out_error_deg(candidate, testing), float(np.mean(progress.losses))
    progress.history.append({"step": progress.step, "loss": round(loss, 5), "held_out_deg": round(error, 3)})
    progress.losses.clear()
    # later steps are smaller and steadier: a later network that is about as good is the better one
    if error < 1.05 * progress.best_error_deg:
        progress.best = candidate.networks[0]
    progress.waited = 0 if error < progress.best_error_deg else progress.waited + 1
    progress.best_error_deg = min(error, progress.best_error_deg)
    return f"loss {loss:.4f}, held out {error:.2f} degrees, best {progress.best_error_deg:.2f}"


def predicted(predictor: Predictor, sample: Sample) -> Array:
    """The yaws `(T,)` in radians that the predictor gives for a sample."""
    if predictor.layout is None:
        return run_recurrent(predictor, sample.positions, sample.rotations)
    tracked = np.ones((len(sample), 3), dtype=bool)
    rows = stream(sample.positions, sample.rotations, tracked, sample.head_height)
    return run_windows(predictor, predictor.layout, rows, RATE).yaws


def held_out_error_deg(predictor: Predictor, samples: Sequence[Sample]) -> float:
    """Mean absolute error in degrees over all frames, as in use."""
    return _mean_error_deg([predicted(predictor, sample) for sample in samples], samples)


def headset_forward_error_deg(samples: Sequence[Sample]) -> float:
    """Mean absolute error in degrees of the headset's forward."""
    return _mean_error_deg([headings(sample.rotations) for sample in samples], samples)


def _mean_error_deg(yaws: Sequence[Array], samples: Sequence[Sample]) -> float:
    errors = [yaw_errors(found, sample.yaws) for found, sample in zip(yaws, samples, strict=True)]
    return float(np.degrees(np.mean(np.concatenate(errors))))

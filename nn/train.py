"""Training of body-orientation predictors; the only part of Footwork that needs torch."""

from __future__ import annotations

import importlib.util
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..core.errors import InputError
from ..core.jobs import Job
from ..core.mocap.skeleton import Take
from ..core.settings import check
from .evaluate import yaw_errors
from .inputs import RATE, headings
from .layouts import CAUSAL, LOOK_AHEAD
from .predictor import run_recurrent, run_windows
from .samples import Sample, samples_of
from .settings import TrainSettings
from .weights import Predictor, read_predictor, save_predictor
from .windows import stream

MEASUREMENTS = 15
"""How often the held-out error is measured in a full training."""
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

    Yields `(fraction, message)` with the loss and the held-out error. Cancelled before its end, it writes
    nothing.

    Args:
        takes: what to learn from.
        settings: kind, length, seed.
        output: the `.npz` to write; with `settings.resume` its weights are the start.
        held_out: takes to measure the error on; by default some of `takes` are kept back.
        licences: licence of each take by name, for the provenance.

    Returns:
        A JSON-ready report: errors in degrees on the held-out takes, beside the headset's forward, and what
        was left out.

    Raises:
        InputError: torch is missing, the takes are too short, or the result is worse than the headset's
        forward.
    """
    check(settings)
    if importlib.util.find_spec("torch") is None:
        raise InputError(NO_TORCH)
    start = read_predictor(output) if settings.resume else None
    yield 0.0, "reading takes"
    training, testing, notes = _split(takes, held_out, settings)
    forward = error_of_forward(testing)
    began = time.monotonic()
    predictor, history = yield from _train(training, testing, settings, start)
    error = held_out_error(predictor, testing)
    if error >= forward and not settings.keep_worse:
        raise InputError(
            f"{output}: not written, {error:.1f} degrees on held-out takes is no better than the headset's "
            f"forward ({forward:.1f}); give more takes or epochs, or say keep-worse"
        )
    report = {
        "file": str(output),
        "kind": settings.kind,
        "held_out_error_deg": round(error, 3),
        "hmd_forward_error_deg": round(forward, 3),
        "seconds": round(time.monotonic() - began, 1),
        "parameters": predictor.parameters,
        "losses": history,
        "left_out": notes,
    }
    provenance = {
        **{key: report[key] for key in ("held_out_error_deg", "hmd_forward_error_deg", "losses", "left_out")},
        "settings": {name: getattr(settings, name) for name in settings.__slots__},
        "takes": [_origin(take, licences) for take in takes],
        "held_out": sorted({sample.take for sample in testing}),
    }
    save_predictor(output, replace(predictor, name=output.stem, provenance=provenance))
    yield 1.0, f"{output.name}: {error:.1f} degrees on held-out takes, the headset's forward {forward:.1f}"
    return report


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
    training: list[Sample], testing: list[Sample], settings: TrainSettings, start: Predictor | None
) -> Job[tuple[Predictor, list[dict[str, float]]]]:
    """The best predictor by held-out error, and the losses on the way."""
    voters = 1 if settings.kind == "paper" else settings.voters
    deadline = time.monotonic() + settings.time_limit
    found: list[Predictor] = []
    history: list[dict[str, float]] = []
    for n in range(voters):
        learner, steps = make_learner(
            training, settings, settings.seed + n, start, found[0] if found else None
        )
        limit = time.monotonic() + (deadline - time.monotonic()) / (voters - n)
        best = yield from _fit(learner, steps, testing, settings, limit, (n, voters), history)
        found.append(best)
    networks = tuple(predictor.networks[0] for predictor in found)
    return replace(found[0], networks=networks), history


def make_learner(
    samples: list[Sample],
    settings: TrainSettings,
    seed: int,
    start: Predictor | None = None,
    first: Predictor | None = None,
) -> tuple[Any, int]:
    """The learner of the settings' kind and its number of steps; `first` lends its scaler to voters after
    it."""
    frames = sum(len(sample) for sample in samples)
    if settings.kind == "paper":
        from .train_paper import RecurrentLearner

        batch = settings.batch or 64
        learner = RecurrentLearner(
            samples,
            iterations=settings.iterations,
            hidden=(32, 32),
            batch=batch,
            learning_rate=settings.learning_rate or 3e-4,
            decay=settings.decay,
            seed=seed,
            start=start,
        )
        return learner, learner.steps_per_epoch * (settings.epochs or 10)
    from .train_window import WindowLearner

    batch = settings.batch or 512
    steps = max(1, frames // batch) * (settings.epochs or 15)
    learner = WindowLearner(
        samples,
        CAUSAL if settings.kind == "causal" else LOOK_AHEAD,
        batch=batch,
        learning_rate=settings.learning_rate or 1e-3,
        decay=settings.decay,
        steps=steps,
        seed=seed,
        start=start,
        scaler=first.scaler if first is not None else None,
    )
    return learner, steps


def _fit(
    learner: Any,
    steps: int,
    testing: list[Sample],
    settings: TrainSettings,
    deadline: float,
    turn: tuple[int, int],
    history: list[dict[str, float]],
) -> Job[Predictor]:
    """Train one network until it is done, stops getting better, or is out of time; the best one measured."""
    best, best_error, waited, losses = learner.predictor(), np.inf, 0, list[float]()
    every = max(1, steps // MEASUREMENTS)
    for n in range(1, steps + 1):
        losses.append(learner.step())
        late = time.monotonic() > deadline
        if n % every == 0 or n == steps or late:
            candidate = learner.predictor()
            error, loss = held_out_error(candidate, testing), float(np.mean(losses))
            history.append({"step": n, "loss": round(loss, 5), "held_out_deg": round(error, 3)})
            losses.clear()
            # later steps are smaller and steadier: a later network that is about as good is the better one
            if error < 1.05 * best_error:
                best = candidate
            waited = 0 if error < best_error else waited + 1
            best_error = min(error, best_error)
            fraction = (turn[0] + n / steps) / turn[1]
            yield fraction, f"loss {loss:.4f}, held out {error:.2f} degrees, best {best_error:.2f}"
            if late or waited >= settings.patience:
                break
        elif n % 20 == 0:
            yield (turn[0] + n / steps) / turn[1], f"step {n} of {steps}, best {best_error:.2f} degrees"
    return best


def predicted(predictor: Predictor, sample: Sample) -> Any:
    """The yaws `(T,)` in radians that the predictor gives for a sample."""
    if predictor.layout is None:
        return run_recurrent(predictor, sample.positions, sample.rotations)
    tracked = np.ones((len(sample), 3), dtype=bool)
    rows = stream(sample.positions, sample.rotations, tracked, sample.head_height)
    return run_windows(predictor, predictor.layout, rows, RATE).yaws


def held_out_error(predictor: Predictor, samples: Sequence[Sample]) -> float:
    """Mean absolute error in degrees over all frames, as in use."""
    return float(np.mean(np.concatenate([yaw_errors(predicted(predictor, s), s.yaws) for s in samples])))


def error_of_forward(samples: Sequence[Sample]) -> float:
    """Mean absolute error in degrees of the headset's forward."""
    return float(np.mean(np.concatenate([yaw_errors(headings(s.rotations), s.yaws) for s in samples])))

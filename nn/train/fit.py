"""One network, trained until it is done, stops getting better, or is out of time."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import numpy as np

from ...core.jobs import Job
from ..settings import TrainSettings
from .checkpoint import Progress
from .held_out import held_out_error_deg
from .learners import Learner
from .samples import Sample

MEASUREMENTS = 15
"""How often the held-out error is measured in a full training."""
SAVE_EVERY_S = 15.0
"""A checkpoint is written at each measurement, and this often where measurements are far apart."""


def fit(
    learner: Learner,
    steps: int,
    testing: list[Sample],
    settings: TrainSettings,
    deadline: float,
    turn: tuple[int, int],
    progress: Progress,
    save: Callable[[], None],
) -> Job[None]:
    """Train one network; `progress` keeps the best.

    Args:
        learner: of that network.
        steps: after which it is done.
        testing: samples to measure on.
        settings: how many measurements may bring nothing better.
        deadline: on the monotonic clock, seconds.
        turn: which network of how many it is, for the fraction done.
        progress: how far it is, brought up to date.
        save: writes a checkpoint.
    """
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


def _measure(learner: Learner, testing: list[Sample], progress: Progress) -> str:
    """Take the held-out error into `progress`; returns what to say of it."""
    candidate = learner.predictor()
    error_deg, loss = held_out_error_deg(candidate, testing), float(np.mean(progress.losses))
    entry = {"step": progress.step, "loss": round(loss, 5), "held_out_deg": round(error_deg, 3)}
    progress.history.append(entry)
    progress.losses.clear()
    # later steps are smaller and steadier: a later network that is about as good is the better one
    if error_deg < 1.05 * progress.best_error_deg:
        progress.best = candidate.networks[0]
    progress.waited = 0 if error_deg < progress.best_error_deg else progress.waited + 1
    progress.best_error_deg = min(error_deg, progress.best_error_deg)
    return f"loss {loss:.4f}, held out {error_deg:.2f} degrees, best {progress.best_error_deg:.2f}"

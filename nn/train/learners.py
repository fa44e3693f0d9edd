"""The learner of each kind of predictor, without torch until one is made."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from numpy.typing import NDArray

from ...core.errors import InputError
from ...core.recording.windows import CAUSAL, LOOK_AHEAD
from ..inputs import INPUTS, Scaler
from ..network import Network
from ..parts import EVERYTHING
from ..settings import TrainSettings
from ..weights import Predictor
from .samples import Sample

PAPER_HIDDEN = (32, 32)
WINDOW_HIDDEN = (256, 128)


class Learner(Protocol):
    """Fits one network, a batch at a time."""

    scaler: Scaler

    def step(self) -> float:
        """One optimisation step; returns the batch's loss."""
        ...

    def network(self) -> Network:
        """The network as it is now."""
        ...

    def predictor(self) -> Predictor:
        """What has been learnt so far."""
        ...

    def state(self) -> dict[str, NDArray[Any]]:
        """All that steps change besides the weights."""
        ...

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Take over a `state`; ValueError, KeyError, TypeError or RuntimeError where it does not fit."""
        ...


def make_learner(
    samples: list[Sample],
    settings: TrainSettings,
    seed: int,
    start: Predictor | None = None,
    scaler: Scaler | None = None,
) -> tuple[Learner, int]:
    """The learner of the settings' kind and its number of steps.

    Args:
        samples: what to learn from.
        settings: kind, sizes, step size, length.
        seed: of the first weights and of the order of batches.
        start: weights to begin with.
        scaler: the first voter's, for window networks that vote with it.

    Raises:
        InputError: the weights to start from are of another kind of network.
    """
    if settings.kind == "paper":
        return _recurrent(samples, settings, seed, start)
    return _window(samples, settings, seed, start, scaler)


def _recurrent(
    samples: list[Sample], settings: TrainSettings, seed: int, start: Predictor | None
) -> tuple[Learner, int]:
    from .paper import RecurrentLearner

    hidden = (settings.hidden,) * 2 if settings.hidden else PAPER_HIDDEN
    _check_sizes(start, (INPUTS, *hidden, 6))
    learner = RecurrentLearner(
        samples,
        iterations=settings.iterations,
        hidden=hidden,
        batch=settings.batch or 64,
        learning_rate=settings.learning_rate or 3e-4,
        decay=settings.decay,
        seed=seed,
        start=start,
    )
    return learner, learner.steps_per_epoch * (settings.epochs or 10)


def _window(
    samples: list[Sample],
    settings: TrainSettings,
    seed: int,
    start: Predictor | None,
    scaler: Scaler | None,
) -> tuple[Learner, int]:
    from .window import WindowLearner

    layout = CAUSAL if settings.kind == "causal" else LOOK_AHEAD
    hidden = (settings.hidden, -(-settings.hidden // 2)) if settings.hidden else WINDOW_HIDDEN
    _check_sizes(start, (layout.inputs, *hidden, EVERYTHING.size))
    batch = settings.batch or 512
    steps = max(1, sum(len(sample) for sample in samples) // batch) * (settings.epochs or 15)
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

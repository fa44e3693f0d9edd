"""Where a training begins: anew, from weights, or from the checkpoint of one that was cut short."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...core.errors import InputError
from ...core.mocap.take import Take
from ..inputs import Scaler
from ..network import Network
from ..settings import TrainSettings
from ..weights import Predictor, read_predictor
from .checkpoint import (
    Checkpoint,
    Progress,
    checkpoint_path,
    damaged,
    origin_of,
    other_version,
    read_checkpoint,
    write_checkpoint,
)
from .learners import Learner, make_learner
from .samples import Sample


@dataclass(frozen=True, slots=True)
class Beginning:
    """Where a training begins, and where its checkpoint lies."""

    path: Path
    origin: Mapping[str, Any]
    saved: Checkpoint | None
    start: Predictor | None


def find_beginning(
    output: Path, settings: TrainSettings, takes: Sequence[Take], held_out: Sequence[Take]
) -> Beginning:
    """Where the training that writes `output` begins.

    Raises:
        InputError: there is nothing to resume, or it is of another training.
    """
    path, origin = checkpoint_path(output), origin_of(settings, takes, held_out)
    if not settings.resume:
        return Beginning(path, origin, None, None)
    if path.exists():
        saved = read_checkpoint(path, origin)
        start = None if saved.start is None else _begun_with(saved.start, saved.scaler)
        return Beginning(path, origin, saved, start)
    if output.exists():
        return Beginning(path, origin, None, read_predictor(output))
    raise InputError(
        f"{output}: neither it nor {path.name} is there to go on from; start anew without resume"
    )


def save(beginning: Beginning, progress: Progress, learner: Learner) -> None:
    """Write a checkpoint to go on from; InputError where it cannot be written."""
    start = None if beginning.start is None else beginning.start.networks[0]
    checkpoint = Checkpoint(
        beginning.origin, progress, learner.scaler, learner.network(), start, learner.state()
    )
    write_checkpoint(beginning.path, checkpoint)


def restore_learner(
    samples: list[Sample], settings: TrainSettings, seed: int, path: Path, saved: Checkpoint
) -> tuple[Learner, int]:
    """The learner as it was when `saved` was written to `path`, and its number of steps.

    Raises:
        InputError: the checkpoint is damaged or of another version.
    """
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

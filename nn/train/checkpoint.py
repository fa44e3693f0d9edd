"""Checkpoints: all it takes to go on with a training as if it had never stopped.

A `.npz` without pickles beside the output, since a file may come from elsewhere.
"""

from __future__ import annotations

import contextlib
import itertools
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.bounds import JSON_BYTES
from ...core.errors import FaultError, InputError
from ...core.json_text import parse_json, to_json
from ...core.mocap.take import Take
from ...core.npz import open_npz, write_npz
from ...core.transaction import write_atomically
from ..inputs import Scaler
from ..network import Network
from ..settings import CHECKPOINT, TrainSettings

FORMAT = "footwork-training"
SCHEMA = 1
_FREE = {"resume", "time_limit", "patience", "keep_worse"}
"""Settings that change when a training ends, not the way there."""
_SHOWN = 3
"""How many takes an error names."""

_WRONG = (KeyError, IndexError, TypeError, ValueError, AttributeError, ArithmeticError, RecursionError)
"""What reading values of the wrong form raises."""

State = Mapping[str, NDArray[Any]]


@dataclass(slots=True)
class Progress:
    """How far a training is; `step` to `losses` are of the voter at work."""

    found: list[Network] = field(default_factory=lambda: list[Network]())
    """Of the voters that are done."""
    history: list[dict[str, float]] = field(default_factory=lambda: list[dict[str, float]]())
    """All measurements."""
    step: int = 0
    best: Network | None = None
    best_error_deg: float = math.inf
    waited: int = 0
    """Measurements since the held-out error was last better."""
    losses: list[float] = field(default_factory=lambda: list[float]())
    """Since the last measurement."""

    def next_voter(self) -> Progress:
        """Where the voter after this one begins."""
        assert self.best is not None
        return Progress([*self.found, self.best], self.history)


@dataclass(frozen=True, slots=True, eq=False)
class Checkpoint:
    """A training between two steps."""

    origin: Mapping[str, Any]
    """Whose training this is, as `origin_of` says."""
    progress: Progress
    scaler: Scaler
    """Of all voters."""
    network: Network
    """As it is now."""
    start: Network | None
    """The weights that every voter began with, if it was given some."""
    state: State
    """What else steps change: the optimiser, its schedule, the random states."""


def checkpoint_path(output: str | os.PathLike[str]) -> Path:
    """Where the checkpoint of a training that writes `output` lies."""
    output = Path(output)
    return output.with_name(f"{output.name}{CHECKPOINT}")


def origin_of(settings: TrainSettings, takes: Sequence[Take], held_out: Sequence[Take]) -> dict[str, Any]:
    """JSON-ready: the settings and takes that decide over every step of a training."""
    unused = "voters" if settings.kind == "paper" else "iterations"
    return {
        "settings": {
            name: getattr(settings, name) for name in settings.__slots__ if name not in _FREE | {unused}
        },
        "takes": [[take.name, take.sha256] for take in takes],
        "held-out takes": [[take.name, take.sha256] for take in held_out],
    }


def write_checkpoint(path: str | os.PathLike[str], checkpoint: Checkpoint) -> None:
    """Write a checkpoint, whole or not at all; InputError where it cannot be written."""
    progress = checkpoint.progress
    networks = {"now": checkpoint.network, "best": progress.best, "start": checkpoint.start}
    networks |= {f"voter_{n}": network for n, network in enumerate(progress.found)}
    arrays: dict[str, Any] = {"mean": checkpoint.scaler.mean, "deviation": checkpoint.scaler.deviation}
    arrays |= {f"state_{key}": array for key, array in checkpoint.state.items()}
    for name, network in networks.items():
        if network is not None:
            for layer, (weight, bias) in enumerate(zip(network.weights, network.biases, strict=True)):
                arrays[f"{name}_weight_{layer}"], arrays[f"{name}_bias_{layer}"] = weight, bias
    header = {
        "format": FORMAT,
        "schema": SCHEMA,
        "origin": checkpoint.origin,
        "sizes": checkpoint.network.sizes,
        "voters_done": len(progress.found),
        "started": checkpoint.start is not None,
        # JSON has no infinity: None before the first measurement
        "best_error": progress.best_error_deg if math.isfinite(progress.best_error_deg) else None,
        **{key: getattr(progress, key) for key in ("history", "step", "waited", "losses")},
    }
    text = np.frombuffer(to_json(header).encode(), dtype=np.uint8)
    write_atomically(path, lambda file: write_npz(file, {"header": text, **arrays}))


def read_checkpoint(path: str | os.PathLike[str], origin: Mapping[str, Any]) -> Checkpoint:
    """Read a checkpoint written by `write_checkpoint`.

    Args:
        path: the file.
        origin: of the training that is to go on.

    Raises:
        InputError: the file cannot be read, is damaged or of another version, or belongs to another
            training; one line says what and what to do.
    """
    try:
        with open_npz(path) as arrays:
            header: Any = parse_json(arrays.read("header", JSON_BYTES).tobytes())
            if header["format"] != FORMAT:
                raise damaged(path)
            if header["schema"] != SCHEMA:
                raise other_version(path)
            difference = _difference(header["origin"], origin)
            if difference:
                raise InputError(
                    f"{path}: its training differs in {difference}; ask for the same again, "
                    "or start anew without resume"
                )
            return _from_arrays(header, arrays)
    except InputError:
        raise
    except (*_WRONG, FaultError) as error:
        raise damaged(path) from error


def remove_checkpoint(path: Path) -> None:
    """Remove a checkpoint whose training is done."""
    # one that stays does no harm: going on from it gives the same predictor again
    with contextlib.suppress(OSError):
        path.unlink()


def damaged(path: str | os.PathLike[str]) -> InputError:
    """What to say of a file that is no complete checkpoint."""
    return InputError(f"{path}: is no complete training to go on with; start anew without resume")


def other_version(path: str | os.PathLike[str]) -> InputError:
    """What to say of a checkpoint that this version cannot go on with."""
    return InputError(f"{path}: is of another version of Footwork; start anew without resume")


def _from_arrays(header: Any, arrays: State) -> Checkpoint:
    """Raises ValueError, KeyError or TypeError for whatever is missing or of the wrong form."""
    sizes = [int(size) for size in header["sizes"]]
    if header["voters_done"] >= header["origin"]["settings"].get("voters", 1):
        raise ValueError("voters_done")
    progress = Progress(
        found=[_network(arrays, f"voter_{n}", sizes) for n in range(int(header["voters_done"]))],
        history=[{str(key): float(value) for key, value in entry.items()} for entry in header["history"]],
        step=int(header["step"]),
        best=_network(arrays, "best", sizes),
        best_error_deg=math.inf if header["best_error"] is None else float(header["best_error"]),
        waited=int(header["waited"]),
        losses=[float(loss) for loss in header["losses"]],
    )
    mean, deviation = (_array(arrays, key, (sizes[0],)) for key in ("mean", "deviation"))
    if not np.all(deviation > 0.0):
        raise ValueError("deviation")
    return Checkpoint(
        origin=header["origin"],
        progress=progress,
        scaler=Scaler(mean, deviation),
        network=_network(arrays, "now", sizes),
        start=_network(arrays, "start", sizes) if header["started"] else None,
        state={key.removeprefix("state_"): arrays[key] for key in arrays if key.startswith("state_")},
    )


def _network(arrays: State, name: str, sizes: Sequence[int]) -> Network:
    pairs = list(itertools.pairwise(sizes))
    return Network(
        tuple(_array(arrays, f"{name}_weight_{n}", pair, np.float32) for n, pair in enumerate(pairs)),
        tuple(_array(arrays, f"{name}_bias_{n}", pair[1:], np.float32) for n, pair in enumerate(pairs)),
    )


def _array(arrays: State, key: str, shape: tuple[int, ...], kind: type = np.float64) -> NDArray[Any]:
    array = arrays[key]
    if array.shape != shape or array.dtype != kind or not np.all(np.isfinite(array)):
        raise ValueError(key)
    return array


def _difference(saved: Mapping[str, Any], wanted: Mapping[str, Any]) -> str:
    """What sets two origins apart, for people; "" for nothing."""
    was, now = saved["settings"], wanted["settings"]
    # another kind has other settings, too
    names = ["kind"] if was["kind"] != now["kind"] else list(now)
    found = [
        f"{name.replace('_', ' ')} (was {was[name]}, now {now[name]})"
        for name in names
        if was[name] != now[name]
    ]
    for group in ("takes", "held-out takes"):
        if saved[group] != wanted[group]:
            found.append(f"{group} ({_takes_apart(saved[group], wanted[group])})")
    return ", ".join(found)


def _takes_apart(saved: Sequence[Sequence[str]], wanted: Sequence[Sequence[str]]) -> str:
    was = [name for name, sha256 in saved if [name, sha256] not in wanted]
    now = [name for name, sha256 in wanted if [name, sha256] not in saved]
    found = [f"{name} is missing" for name in was if name not in now]
    found += [f"{name} {'has changed' if name in was else 'is new'}" for name in now]
    if not found:
        return "their order"
    more = [f"{len(found) - _SHOWN} more"] if len(found) > _SHOWN else []
    return ", ".join(found[:_SHOWN] + more)

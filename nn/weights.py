"""Trained predictors and the `.npz` files that hold them."""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ..core.bounds import INPUT_DEVIATION, INPUT_MEAN, JSON_BYTES, LAYERS, NETWORKS, WEIGHT, WIDTH
from ..core.errors import FaultError, InputError
from ..core.json_text import parse_json, to_json
from ..core.npz import Npz, open_npz, write_npz
from ..core.recording.windows import WindowLayout
from ..core.transaction import Transaction, write_atomically
from .inputs import INPUTS, Scaler
from .network import Network
from .parts import ALL, YAW, Outputs, are_parts, outputs_of

Array = NDArray[np.floating[Any]]

FORMAT = "footwork-predictor"
SCHEMA = 2
"""1 knew the yaw alone."""
_HALF = 65504.0
"""The largest number of half precision."""


@dataclass(frozen=True, slots=True, eq=False)
class Predictor:
    """A trained network, or several that vote, with all it takes to run them."""

    name: str
    networks: tuple[Network, ...]
    scaler: Scaler
    layout: WindowLayout | None
    """The window around each moment; None for the paper's network, which feeds on its own last answer."""
    smoothing: float
    """Seconds: deviation of the bell that smooths answers without lag, or time constant of the causal
    filter."""
    provenance: Mapping[str, Any]
    """JSON-ready: takes with SHA-256 and licence, seed, iterations, losses, errors."""
    parts: tuple[str, ...] = (YAW,)
    """What it answers, in the order of its outputs (see `parts.outputs_of`)."""

    @property
    def outputs(self) -> Outputs:
        """Where each part lies in an answer of a window network."""
        return outputs_of(self.parts)

    @property
    def kind(self) -> str:
        """ "recurrent" (the paper's) or "window"."""
        return "recurrent" if self.layout is None else "window"

    @property
    def causal(self) -> bool:
        """Whether an answer needs nothing of the future."""
        return self.layout is None or self.layout.causal

    @property
    def parameters(self) -> int:
        """How many trained numbers there are."""
        return sum(network.parameters for network in self.networks)


def save_predictor(
    path: str | os.PathLike[str], predictor: Predictor, outputs: Transaction | None = None
) -> None:
    """Write a predictor as `.npz`, at once or in a transaction; InputError where it cannot be written."""
    arrays: dict[str, Any] = {"mean": predictor.scaler.mean, "deviation": predictor.scaler.deviation}
    for n, network in enumerate(predictor.networks):
        for layer, (weight, bias) in enumerate(zip(network.weights, network.biases, strict=True)):
            arrays[f"weight_{n}_{layer}"], arrays[f"bias_{n}_{layer}"] = _short(weight), _short(bias)
    layout = predictor.layout
    if layout is not None:
        arrays["offsets"] = layout.offsets
    header = {
        "format": FORMAT,
        "schema": SCHEMA,
        "name": predictor.name,
        "kind": predictor.kind,
        "causal": predictor.causal,
        "parts": list(predictor.parts),
        "rotations_every": 0 if layout is None else layout.rotations_every,
        "sizes": [list(network.sizes) for network in predictor.networks],
        "smoothing": predictor.smoothing,
        "provenance": dict(predictor.provenance),
    }
    text = np.frombuffer(to_json(header, sort_keys=True).encode(), dtype=np.uint8)
    write_atomically(path, lambda file: write_npz(file, {"header": text, **arrays}, compressed=True), outputs)


def _short(array: Array) -> Array:
    """The same numbers in half the bytes, where those hold them exactly."""
    half = np.clip(array, -_HALF, _HALF).astype(np.float16)
    return half if np.array_equal(half.astype(np.float32), array) else array


def read_predictor(path: str | os.PathLike[str]) -> Predictor:
    """Read a predictor written by `save_predictor`.

    Raises:
        InputError: the file is missing, no predictor, of a newer schema, or damaged; one line says which.
    """
    whole = False
    try:
        with open_npz(path) as arrays:
            whole = True
            return _from_arrays(arrays, f"{path}")
    except FaultError as fault:
        if whole:
            raise _damaged(f"{path}", f"{fault}") from None
        raise InputError(f"{path}: is no complete predictor file; train or copy it again") from None


def _from_arrays(arrays: Npz, path: str) -> Predictor:
    header = _header(arrays, path)
    recurrent = header["kind"] == "recurrent"
    layout = None if recurrent else _layout(arrays, header, path)
    parts = tuple(header["parts"])
    inputs, outputs = (INPUTS, 6) if layout is None else (layout.inputs, outputs_of(parts).size)
    networks: list[Network] = []
    for n, sizes in enumerate(header["sizes"]):
        if sizes[0] != inputs or sizes[-1] != outputs:
            raise _damaged(
                path, f"network {n} maps {sizes[0]} to {sizes[-1]} numbers, not {inputs} to {outputs}"
            )
        pairs = list(itertools.pairwise(sizes))
        weights = [_array(arrays, f"weight_{n}_{k}", shape, path) for k, shape in enumerate(pairs)]
        biases = [_array(arrays, f"bias_{n}_{k}", shape[1:], path) for k, shape in enumerate(pairs)]
        networks.append(
            Network(tuple(w.astype(np.float32) for w in weights), tuple(b.astype(np.float32) for b in biases))
        )
    if any(np.abs(array).max(initial=0.0) > WEIGHT for n in networks for array in (*n.weights, *n.biases)):
        raise _damaged(path, f"a weight is larger than {WEIGHT:g}")
    mean, deviation = (_array(arrays, key, (inputs,), path) for key in ("mean", "deviation"))
    if (
        np.abs(mean).max() > INPUT_MEAN
        or deviation.min() < INPUT_DEVIATION[0]
        or deviation.max() > INPUT_DEVIATION[1]
    ):
        raise _damaged(path, "a mean or deviation of its scaler is none of a body's movement")
    return Predictor(
        name=Path(path).stem,
        networks=tuple(networks),
        scaler=Scaler(mean, deviation),
        layout=layout,
        smoothing=float(header["smoothing"]),
        provenance=header["provenance"],
        parts=parts,
    )


def _header(arrays: Npz, path: str) -> dict[str, Any]:
    """The checked description; what it lacks or has of the wrong type is told apart from a foreign file."""
    try:
        header: Any = parse_json(arrays.read("header", JSON_BYTES).tobytes())
        ours = header["format"] == FORMAT
    except (KeyError, TypeError, FaultError) as error:
        raise InputError(f"{path}: is no Footwork predictor; train one with train-predictor") from error
    if not ours:
        raise InputError(f"{path}: is no Footwork predictor; train one with train-predictor")
    schema = header.get("schema")
    if not isinstance(schema, int) or schema < 1:
        raise _damaged(path, "its schema number is missing")
    if schema > SCHEMA:
        raise InputError(f"{path}: has schema {schema}, newer than {SCHEMA}; update Footwork to use it")
    header.setdefault("parts", [YAW])
    _check_parts(header["parts"], path)
    fine = (
        header.get("kind") in ("recurrent", "window")
        and isinstance(header.get("rotations_every"), int)
        and 0 <= header["rotations_every"] <= 1000
        and isinstance(header.get("smoothing"), (int, float))
        and 0.0 <= header["smoothing"] < 10.0
        and _is_provenance(header.get("provenance"))
        and _are_sizes(header.get("sizes"))
    )
    if not fine:
        raise _damaged(path, "its description is incomplete")
    return header


def _check_parts(parts: Any, path: str) -> None:
    if not isinstance(parts, list) or not all(isinstance(name, str) for name in cast(list[Any], parts)):
        raise _damaged(path, "its list of parts is missing")
    names = cast(list[str], parts)
    unknown = [name for name in names if name not in ALL]
    if unknown:
        raise _damaged(path, f"it answers {unknown[0][:40]!r}, which is no part of a body ({', '.join(ALL)})")
    if not are_parts(names):
        raise _damaged(path, "its parts do not begin with the yaw, or one comes twice")


def _is_provenance(value: Any) -> bool:
    """Whether this tells of a training; of what is used, the expected error is an angle in degrees."""
    if not isinstance(value, dict):
        return False
    found = cast(dict[str, Any], value)
    error = found.get("held_out_error_deg", 0.0)
    return (
        isinstance(error, (int, float))
        and 0.0 <= error <= 180.0
        and isinstance(found.get("settings", {}), dict)
        and isinstance(found.get("takes", []), list)
    )


def _are_sizes(sizes: Any) -> bool:
    """Whether these are the layer widths of one network or more."""
    try:
        return 0 < len(sizes) <= NETWORKS and all(
            2 <= len(widths) <= LAYERS + 1
            and all(isinstance(width, int) and 0 < width <= WIDTH for width in widths)
            for widths in sizes
        )
    except TypeError:
        return False


def _layout(arrays: Npz, header: Mapping[str, Any], path: str) -> WindowLayout:
    offsets = arrays.read("offsets", 1000) if "offsets" in arrays else None
    if offsets is None or offsets.ndim != 1 or not 0 < len(offsets) < 1000 or offsets.dtype.kind != "f":
        raise _damaged(path, "its window is missing")
    if not np.all(np.diff(offsets) > 0.0) or np.min(np.abs(offsets)) > 1e-9 or np.max(np.abs(offsets)) > 60.0:
        raise _damaged(path, "its window does not run through the moment itself")
    if header["rotations_every"] < 1:
        raise _damaged(path, "its description is incomplete")
    return WindowLayout(offsets.astype(np.float64), header["rotations_every"])


def _array(arrays: Npz, key: str, shape: tuple[int, ...], path: str) -> Array:
    array = arrays.read(key, math.prod(shape)) if key in arrays else None
    if array is None or array.shape != tuple(shape) or array.dtype.kind != "f":
        raise _damaged(path, f"{key} is missing or not of shape {tuple(shape)}")
    if not np.all(np.isfinite(array)):
        raise _damaged(path, f"{key} holds numbers that are not finite")
    return array


def _damaged(path: str, what: str) -> InputError:
    return InputError(f"{path}: is damaged, {what}; train or copy it again")

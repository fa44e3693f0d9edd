"""The motion model: a network that answers with poses, given the way of the body, its steps and a manner."""

from __future__ import annotations

import itertools
import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ...core.bounds import INPUT_DEVIATION, INPUT_MEAN, JSON_BYTES, WEIGHT
from ...core.errors import FaultError, InputError
from ...core.json_text import parse_json, to_json
from ...core.npz import Npz, open_npz, write_npz
from ...core.transaction import write_atomically
from ..network import product
from .body import starter_skeleton
from .conditions import SIZE

Array = NDArray[np.floating[Any]]

FORMAT = "footwork-motion-model"
SCHEMA = 1
ANSWERS = 3 + 6 * len(starter_skeleton())
"""Numbers of a pose, as `conditions.poses_of` orders them."""
LATENT = 8
"""Numbers that tell a manner: what the way and the steps leave open."""
HIDDEN = (384, 384, 384)


@dataclass(frozen=True, slots=True, eq=False)
class MotionModel:
    """Trained weights; every layer sees the manner, between them are ELUs."""

    people: tuple[str, ...]
    """Whose movements it knows, P."""
    scale: tuple[Array, Array]
    """Mean and deviation `(SIZE,)` of the conditions."""
    answer_scale: tuple[Array, Array]
    """Mean and deviation `(ANSWERS,)` of the poses."""
    weights: tuple[Array, ...]
    """Per layer `(inputs + LATENT, outputs)`; the first has the people among its inputs."""
    biases: tuple[Array, ...]
    manners: tuple[Array, Array]
    """Mean and deviation `(P, LATENT)` of each person's manners."""
    provenance: Mapping[str, Any]
    """JSON-ready: takes with SHA-256 and licence, seed, steps, limits."""

    def poses(self, told: Array, person: int, manner: Array) -> Array:
        """Poses `(T, ANSWERS)`.

        Args:
            told: `(T, SIZE)` from `conditions.conditions`.
            person: one of `people`.
            manner: `(T, LATENT)`.
        """
        who = np.zeros((len(told), len(self.people)))
        who[:, person] = 1.0
        x = np.concatenate([(told - self.scale[0]) / self.scale[1], who], axis=1)
        last = len(self.weights) - 1
        for n, (weight, bias) in enumerate(zip(self.weights, self.biases, strict=True)):
            x = product(np.concatenate([x, manner], axis=1), weight.astype(np.float64)) + bias
            if n < last:
                x = np.where(x > 0.0, x, np.expm1(np.minimum(x, 0.0)))
        return x * self.answer_scale[1] + self.answer_scale[0]


def save_model(path: str | os.PathLike[str], model: MotionModel) -> None:
    """Write a model as `.npz`, its weights in half precision; InputError where it cannot be written."""
    header = {
        "format": FORMAT,
        "schema": SCHEMA,
        "people": list(model.people),
        "hidden": [len(bias) for bias in model.biases[:-1]],
        "provenance": dict(model.provenance),
    }
    arrays: dict[str, Array] = {
        "mean": model.scale[0],
        "deviation": model.scale[1],
        "answer_mean": model.answer_scale[0],
        "answer_deviation": model.answer_scale[1],
        "manner_mean": model.manners[0],
        "manner_deviation": model.manners[1],
    }
    packed: dict[str, Any] = {key: array.astype(np.float32) for key, array in arrays.items()}
    for n, (weight, bias) in enumerate(zip(model.weights, model.biases, strict=True)):
        packed[f"weight_{n}"], packed[f"bias_{n}"] = weight.astype(np.float16), bias.astype(np.float16)
    text = np.frombuffer(to_json(header, sort_keys=True).encode(), dtype=np.uint8)
    write_atomically(path, lambda file: write_npz(file, {"header": text, **packed}, compressed=True))


def read_model(path: str | os.PathLike[str]) -> MotionModel:
    """Read a model written by `save_model`.

    Raises:
        InputError: the file is missing, no motion model, of a newer schema, or damaged; one line says which.
    """
    try:
        with open_npz(path) as arrays:
            return _from_arrays(arrays, f"{path}")
    except FaultError as fault:
        raise _damaged(f"{path}", f"{fault}") from None


def _from_arrays(arrays: Npz, path: str) -> MotionModel:
    header = _header(arrays, path)
    people, hidden = header["people"], header["hidden"]
    widths = [SIZE + len(people), *hidden, ANSWERS]
    pairs = [(inputs + LATENT, outputs) for inputs, outputs in itertools.pairwise(widths)]
    weights = [_array(arrays, f"weight_{n}", pair, path) for n, pair in enumerate(pairs)]
    biases = [_array(arrays, f"bias_{n}", pair[1:], path) for n, pair in enumerate(pairs)]
    if any(np.abs(array).max(initial=0.0) > WEIGHT for array in (*weights, *biases)):
        raise _damaged(path, f"a weight is larger than {WEIGHT:g}")
    scales = [
        (_array(arrays, f"{name}mean", shape, path), _array(arrays, f"{name}deviation", shape, path))
        for name, shape in (
            ("", (SIZE,)),
            ("answer_", (ANSWERS,)),
            ("manner_", (len(people), LATENT)),
        )
    ]
    least, most = INPUT_DEVIATION
    if any(np.abs(m).max() > INPUT_MEAN or d.min() < least or d.max() > most for m, d in scales):
        raise _damaged(path, "a mean or deviation is none of a body's movement")
    return MotionModel(
        people=tuple(people),
        scale=scales[0],
        answer_scale=scales[1],
        weights=tuple(weights),
        biases=tuple(biases),
        manners=scales[2],
        provenance=header["provenance"],
    )


def _header(arrays: Npz, path: str) -> dict[str, Any]:
    try:
        header: Any = parse_json(arrays.read("header", JSON_BYTES).tobytes())
        ours = header["format"] == FORMAT
    except (KeyError, TypeError, FaultError) as error:
        raise InputError(f"{path}: is no motion model of Footwork; install Footwork again") from error
    if not ours:
        raise InputError(f"{path}: is no motion model of Footwork; install Footwork again")
    schema = header.get("schema")
    if not isinstance(schema, int) or schema < 1:
        raise _damaged(path, "its schema number is missing")
    if schema > SCHEMA:
        raise InputError(f"{path}: has schema {schema}, newer than {SCHEMA}; update Footwork to use it")
    people, hidden = header.get("people"), header.get("hidden")
    fine = (
        isinstance(header.get("provenance"), dict)
        and _is_list(people, str, 64)
        and _is_list(hidden, int, 8)
        and all(0 < width <= 4096 for width in cast("list[int]", hidden))
    )
    if not fine:
        raise _damaged(path, "its description is incomplete")
    return header


def _is_list(value: Any, kind: type, most: int) -> bool:
    if not isinstance(value, list):
        return False
    items = cast("list[Any]", value)
    return 0 < len(items) <= most and all(type(item) is kind for item in items)


def _array(arrays: Npz, key: str, shape: tuple[int, ...], path: str) -> Array:
    array = arrays.read(key, int(np.prod(shape))) if key in arrays else None
    if array is None or array.shape != shape or array.dtype.kind != "f":
        raise _damaged(path, f"{key} is missing or not of shape {shape}")
    if not np.all(np.isfinite(array)):
        raise _damaged(path, f"{key} holds numbers that are not finite")
    return array.astype(np.float64)


def _damaged(path: str, what: str) -> InputError:
    return InputError(f"{path}: is damaged, {what}; install Footwork again")

"""What window networks answer: one row of numbers for all parts of a body, turned, mirrored and read as one.

A row holds, part after part, vectors in some axes about the vertical, then the logarithm of each expected deviation.
Which way the axes turn is up to the caller, as for the inputs.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core.maths import quat
from ..core.recording.body_estimate import BodyEstimate, Part

Array = NDArray[np.floating[Any]]

YAW = "yaw"
_SPREAD = (1e-4, 10.0)
"""Bounds of expected deviations: beyond, a network answers to what it has never seen."""


@dataclass(frozen=True, slots=True)
class _Shape:
    """How a part lies in a row."""

    vectors: int
    """How many vectors of three it has."""
    spreads: int
    sides: bool = False
    """Whether the first half of it is of the left, the second of the right."""
    chest: bool = False


SHAPES = {
    "hips": _Shape(1, 1),
    "feet": _Shape(4, 4, sides=True),
    "standing": _Shape(0, 0, sides=True),
    "chest": _Shape(2, 1, chest=True),
    "elbows": _Shape(2, 2, sides=True),
}
"""All parts besides the yaw, in their order. Hips, feet and elbows are vectors as in `BodyEstimate`; standing is two
log-odds; the chest is the first two columns of its rotation."""
ALL = (YAW, *SHAPES)


@dataclass(frozen=True, slots=True, eq=False)
class Outputs:
    """Where each part lies in a row of answers."""

    names: tuple[str, ...]
    """The parts, the yaw first."""
    values: dict[str, slice]
    """Of each part, its vectors."""
    spreads: dict[str, slice]
    """Of each part, the logarithms of its expected deviations."""
    size: int
    """Length of a row."""
    across: NDArray[np.intp]
    """`(V,)` where the X of each vector lies; its Y comes next."""
    order: NDArray[np.intp]
    """`(size,)` where each number of the mirror image comes from."""
    signs: NDArray[np.float32]
    """`(size,)` its sign."""

    def turned(self, rows: Array, yaw: Array) -> Array:
        """Rows `(N, size)` whose vectors are turned about the vertical by `yaw` `(N,)` radians, float64."""
        c, s = np.cos(yaw)[:, None], np.sin(yaw)[:, None]
        out = np.array(rows, dtype=np.float64)
        x, y = out[:, self.across], out[:, self.across + 1]
        out[:, self.across], out[:, self.across + 1] = c * x - s * y, s * x + c * y
        return out

    def mirrored(self, rows: Array) -> Array:
        """The same answers `(N, size)` about the mirror image of a body: left and right change places."""
        return rows[:, self.order] * self.signs


@cache
def outputs_of(names: tuple[str, ...]) -> Outputs:
    """The layout of rows with these parts, the yaw first."""
    values, spreads, across = dict[str, slice](), dict[str, slice](), list[int]()
    order, signs, start = [np.arange(2, dtype=np.intp)], [np.array([-1.0, 1.0])], 2
    values[YAW], spreads[YAW] = slice(0, 2), slice(2, 2)
    across.append(0)
    for name in names[1:]:
        shape = SHAPES[name]
        count = 3 * shape.vectors if shape.vectors else 2
        values[name] = slice(start, start + count)
        spreads[name] = slice(start + count, start + count + shape.spreads)
        across += [start + 3 * i for i in range(shape.vectors)]
        for block in (values[name], spreads[name]):
            index: NDArray[np.intp] = np.arange(block.start, block.stop, dtype=np.intp)
            order.append(np.roll(index, len(index) // 2) if shape.sides else index)
        sign = np.tile([-1.0, 1.0, 1.0], shape.vectors) if shape.vectors else np.ones(count)
        if shape.chest:
            # a rotation R becomes M R M with M = diag(-1, 1, 1): its first column turns about
            sign[:3] *= -1.0
        signs += [sign, np.ones(shape.spreads)]
        start = spreads[name].stop
    return Outputs(
        names,
        values,
        spreads,
        start,
        np.array(across),
        np.concatenate(order),
        np.concatenate(signs).astype(np.float32),
    )


EVERYTHING = outputs_of(ALL)


def are_parts(names: Iterable[str]) -> bool:
    """Whether these are parts that networks may answer, the yaw first, none twice."""
    names = list(names)
    return names[:1] == [YAW] and len(set(names)) == len(names) and all(name in ALL for name in names)


def true_rows(estimate: BodyEstimate) -> Array:
    """Rows `(T, EVERYTHING.size)` of a whole known body in its own axes; spreads are 0.

    Raises:
        ValueError: a part is unknown.
    """
    known = (estimate.hips, estimate.feet, estimate.chest, estimate.elbows)
    frames = len(estimate.yaws)
    if any(part is None for part in known) or estimate.standing is None:
        raise ValueError("parts are missing")
    hips, feet, chest, elbows = (part.mean for part in known if part is not None)
    rows = np.zeros((frames, EVERYTHING.size))
    rows[:, 1] = 1.0
    columns = quat.to_sixd(quat.from_rotation_vector(chest))
    for name, array in (
        ("hips", hips),
        ("feet", feet),
        ("standing", estimate.standing),
        ("chest", columns),
        ("elbows", elbows),
    ):
        rows[:, EVERYTHING.values[name]] = array.reshape(frames, -1)
    return rows


def read_rows(outputs: Outputs, rows: Array, yaws: Array, doubt: Array) -> BodyEstimate:
    """The estimate that rows `(T, size)` in the body's axes stand for.

    Args:
        outputs: their layout.
        rows: in axes turned to `yaws`.
        yaws: `(T,)` world yaws, radians.
        doubt: `(T,)` radians.
    """
    frames = len(rows)

    def part(name: str, *shape: int) -> Part | None:
        if name not in outputs.names:
            return None
        spread = np.clip(np.exp(np.clip(rows[:, outputs.spreads[name]], -20.0, 20.0)), *_SPREAD)
        return Part(
            rows[:, outputs.values[name]].reshape(frames, *shape), spread.reshape(frames, *shape[:-1])
        )

    chest, elbows, standing = part("chest", 6), part("elbows", 2, 3), None
    if chest is not None:
        chest = Part(quat.to_rotation_vector(quat.from_sixd(chest.mean)), chest.spread)
    if elbows is not None:
        length = np.linalg.norm(elbows.mean, axis=-1, keepdims=True)
        elbows = Part(elbows.mean / np.maximum(length, 1e-9), elbows.spread)
    if "standing" in outputs.names:
        standing = 1.0 / (1.0 + np.exp(-np.clip(rows[:, outputs.values["standing"]], -20.0, 20.0)))
    return BodyEstimate(yaws, doubt, part("hips", 3), part("feet", 2, 2, 3), standing, chest, elbows)

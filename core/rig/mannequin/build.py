"""The mannequin of a skeleton: meshes and the weights by which joints carry them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...body.skeleton import SIDES, Skeleton
from . import anatomy
from .anatomy import Landmarks
from .lofts import Loft, intersection, union
from .skin import weights
from .surface import Field, surface

Array = NDArray[np.floating[Any]]

BODY, ACCENT = 0, 1
"""Materials of faces."""
_CELL, _FINE = 0.013, 0.006
"""Cells in metres of a body of usual size: of the whole, and of hands."""
_ACCENT_CELL = 0.0085
_PROUD = 0.0028
"""Metres by which accents stand out from the body."""
_ROUND = 0.008
"""Metres over which their edges are rounded."""
_FAR = 0.15


@dataclass(frozen=True, slots=True, eq=False)
class Mannequin:
    """A skinned body in the skeleton's T-pose, facing +Y, metres."""

    vertices: Array
    """`(V, 3)`."""
    quads: NDArray[np.intp]
    """`(F, 4)` counterclockwise seen from outside."""
    materials: NDArray[np.intp]
    """`(F,)` `BODY` or `ACCENT`."""
    weights: Array
    """`(V, J)` share of each joint in carrying a vertex; rows add up to 1."""


def make_mannequin(skeleton: Skeleton) -> Mannequin:
    """A body of average build around a skeleton.

    Args:
        skeleton: in T-pose, of a person's proportions; its lengths set how large the body is.
    """
    body = anatomy.landmarks(skeleton)
    parts = _parts(body)
    vertices: list[Array] = []
    quads: list[NDArray[np.intp]] = []
    materials: list[NDArray[np.intp]] = []
    count = 0
    for field, (low, high), cell, material in parts:
        points, faces = surface(field, low, high, cell * body.size)
        vertices.append(points)
        quads.append(faces + count)
        materials.append(np.full(len(faces), material, dtype=np.intp))
        count += len(points)
    points = np.concatenate(vertices)
    return Mannequin(
        points, np.concatenate(quads), np.concatenate(materials), weights(points, skeleton, body)
    )


Part = tuple[Field, tuple[Array, Array], float, int]


def _parts(body: Landmarks) -> list[Part]:
    s = body.size
    trunk = anatomy.trunk(body)
    arms = [anatomy.arm(body, side) for side in SIDES]
    legs = [anatomy.leg(body, side) for side in SIDES]
    whole = _Whole(s, trunk, arms, legs)
    made: list[Part] = [(whole, whole.box(), _CELL, BODY)]
    for side in SIDES:
        hand = _Joined(anatomy.fingers(body, side), 0.006 * s)
        made.append((hand, hand.box(), _FINE, BODY))
    made += _accents(body, arms, legs)
    return made


@dataclass(frozen=True, slots=True, eq=False)
class _Joined:
    """Several lofts in one, the grooves between them filled over `blend` metres."""

    lofts: tuple[Loft, ...]
    blend: float

    def __call__(self, points: Array) -> Array:
        return reduce(lambda a, b: union(a, b, self.blend), (_near(loft, points) for loft in self.lofts))

    def box(self) -> tuple[Array, Array]:
        return _box(self.lofts)


@dataclass(frozen=True, slots=True, eq=False)
class _Whole:
    """Trunk, head and limbs up to the wrists."""

    size: float
    trunk: Sequence[Loft]
    arms: Sequence[dict[str, Loft]]
    legs: Sequence[dict[str, Loft]]

    def __call__(self, points: Array) -> Array:
        s = self.size
        torso, neck, cranium, face = (_near(loft, points) for loft in self.trunk)
        head = union(cranium, face, 0.035 * s)
        out = union(union(torso, neck, 0.05 * s), head, 0.015 * s)
        legs: list[Array] = []
        for leg in self.legs:
            thigh, shin, foot = (_near(loft, points) for loft in leg.values())
            # soles are flat
            foot = np.maximum(foot, -points[..., 2])
            legs.append(union(union(thigh, shin, 0.03 * s), foot, 0.035 * s))
        out = union(out, union(legs[0], legs[1], 0.015 * s), 0.04 * s)
        for arm in self.arms:
            inner, upper, fore = (_near(loft, points) for loft in list(arm.values())[:3])
            out = union(out, union(union(upper, fore, 0.025 * s), inner, 0.03 * s), 0.05 * s)
        return out

    def box(self) -> tuple[Array, Array]:
        lofts = [
            *self.trunk,
            *(loft for limb in (*self.arms, *self.legs) for loft in list(limb.values())[:3]),
        ]
        low, high = _box(lofts)
        return np.array([low[0], low[1], -2.0 * _CELL]), high


def _accents(body: Landmarks, arms: Sequence[dict[str, Loft]], legs: Sequence[dict[str, Loft]]) -> list[Part]:
    """Bands round the joints, soles, and a visor that shows where the head looks."""
    s = body.size
    made: list[Part] = []
    for side, arm, leg in zip(SIDES, arms, legs, strict=True):
        upper, fore, hand = (arm[f"{part}.{side}"] for part in ("upper_arm", "forearm", "hand"))
        thigh, shin, foot = leg.values()
        sleeve, hose = _Joined((upper, fore), 0.025 * s), _Joined((thigh, shin), 0.03 * s)
        cuff = _Joined((fore, hand), 0.02 * s)
        made += [
            _band(sleeve, fore.start, _axis(upper) + _axis(fore), 0.024 * s, s),
            _band(cuff, fore.end, _axis(fore), 0.014 * s, s),
            _band(hose, shin.start, _axis(thigh) + _axis(shin), 0.034 * s, s),
            _band(_Joined((shin,), 0.01), shin.end - 0.055 * s * _axis(shin), _axis(shin), 0.014 * s, s),
            _sole(foot, s),
        ]
    _, _, *skull = anatomy.trunk(body)
    made.append(_visor(_Joined(tuple(skull), 0.035 * s), body["head"], s))
    return made


def _band(limb: _Joined, middle: Array, axis: Array, half: float, size: float) -> Part:
    """A ring on a limb, half as wide as `half` on each side of its middle; metres."""
    axis = axis / np.linalg.norm(axis)

    def field(points: Array) -> Array:
        return intersection(
            limb(points) - _PROUD * size, np.abs((points - middle) @ axis) - half, _ROUND * size
        )

    reach = 0.09 * size
    return field, (middle - reach, middle + reach), _ACCENT_CELL, ACCENT


def _sole(foot: Loft, size: float) -> Part:
    def field(points: Array) -> Array:
        height = points[..., 2]
        shoe = intersection(_near(foot, points) - _PROUD * size, height - 0.024 * size, _ROUND * size)
        return np.maximum(shoe, -height)

    low, high = foot.box()
    return (
        field,
        (np.array([*low[:2], -0.01 * size]), np.array([*high[:2], 0.04 * size])),
        _ACCENT_CELL,
        ACCENT,
    )


def _visor(skull: _Joined, head: Array, size: float) -> Part:
    def field(points: Array) -> Array:
        up, ahead = points[..., 2] - head[2] - 0.072 * size, points[..., 1] - head[1]
        front = 0.045 * size - ahead
        shell = intersection(skull(points) - 2.0 * _PROUD * size, np.abs(up) - 0.028 * size, _ROUND * size)
        return intersection(shell, front, _ROUND * size)

    reach = 0.13 * size
    middle = head + np.array([0.0, 0.05, 0.07]) * size
    return field, (middle - reach, middle + reach), _ACCENT_CELL, ACCENT


def _axis(loft: Loft) -> Array:
    return (loft.end - loft.start) / np.linalg.norm(loft.end - loft.start)


def _near(loft: Loft, points: Array) -> Array:
    """The loft's field, worked out only where it matters."""
    low, high = loft.box()
    low, high = low - 0.06, high + 0.06
    near = ((points > low) & (points < high)).all(axis=-1)
    out = np.full(points.shape[:-1], _FAR)
    out[near] = loft(points[near])
    return out


def _box(lofts: Sequence[Loft]) -> tuple[Array, Array]:
    boxes = [loft.box() for loft in lofts]
    return np.min([low for low, _ in boxes], axis=0), np.max([high for _, high in boxes], axis=0)

"""How far the parts of a body estimate are from the true body's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core.maths import angles, quat
from ..core.recording.body_estimate import BodyEstimate, Part

Array = NDArray[np.floating[Any]]

PARTS = {
    "hips_cm": "hips joint from the point under the head",
    "ankles_cm": "ankles from the hips, along the world's axes",
    "standing_wrong": "share of feet that are told to stand and do not, or the other way round",
    "chest_deg": "rotation of the chest in the body's axes",
    "elbows_deg": "direction from hand to elbow in the body's axes",
    "within": "share of hips and ankles within the spread told, in each direction; 0.68 where it is right",
}
"""The figures of a report, and what they are."""


def part_errors(estimate: BodyEstimate, truth: BodyEstimate, head_height: float) -> dict[str, Array]:
    """Single errors `(T, ...)` of the parts that an estimate knows, by the names in `PARTS`.

    Args:
        estimate: of `T` frames.
        truth: with every part.
        head_height: of the head joint when the user stands upright, metres.
    """
    out: dict[str, Array] = {}
    within: list[Array] = []
    centimetres = 100.0 * head_height
    if estimate.hips is not None and truth.hips is not None:
        away = _turned(estimate.hips.mean, estimate.yaws) - _turned(truth.hips.mean, truth.yaws)
        out["hips_cm"] = centimetres * np.linalg.norm(away, axis=-1)
        within.append(_within(away, estimate.hips))
    if estimate.feet is not None and truth.feet is not None:
        mine, theirs = (
            _turned(side.feet.mean[:, :, 0], side.yaws[:, None]) for side in (estimate, truth) if side.feet
        )
        out["ankles_cm"] = centimetres * np.linalg.norm(mine - theirs, axis=-1)
        within.append(_within(mine - theirs, Part(mine, estimate.feet.spread[:, :, 0])))
    if estimate.standing is not None and truth.standing is not None:
        out["standing_wrong"] = ((estimate.standing > 0.5) != (truth.standing > 0.5)).astype(np.float64)
    if estimate.chest is not None and truth.chest is not None:
        turn = quat.multiply(
            quat.from_rotation_vector(estimate.chest.mean),
            quat.conjugate(quat.from_rotation_vector(truth.chest.mean)),
        )
        out["chest_deg"] = np.degrees(np.linalg.norm(quat.to_rotation_vector(turn), axis=-1))
    if estimate.elbows is not None and truth.elbows is not None:
        cosine = np.sum(estimate.elbows.mean * truth.elbows.mean, axis=-1)
        out["elbows_deg"] = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
    if within:
        out["within"] = np.concatenate(within, axis=1)
    return out


def pooled(parts: Sequence[Mapping[str, Array]]) -> dict[str, float | None]:
    """The mean of each figure over several takes; None where none knows the part."""
    out: dict[str, float | None] = {}
    for name in PARTS:
        values = [errors[name].ravel() for errors in parts if name in errors]
        out[name] = float(np.concatenate(values).mean()) if values else None
    return out


def _turned(vectors: Array, yaws: Array) -> Array:
    """Vectors `(..., 3)` of the body's axes along the world's."""
    ground = angles.turn(vectors[..., :2], yaws)
    return np.concatenate([ground, vectors[..., 2:]], axis=-1)


def _within(away: Array, part: Part) -> Array:
    """Whether each direction `(T, N)` of `away` `(T, ..., 3)` is within the part's spread."""
    return (np.abs(away) <= part.spread[..., None]).reshape(len(away), -1).astype(np.float64)

"""How arms and legs lie, as functions of arrays in metres and radians."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..maths.vectors import cross, dot

Array = NDArray[np.floating[Any]]


def bends(hips: Array, knees: Array, ankles: Array) -> Array:
    """Angles `(...)` in radians between thigh and shin, 0 when straight, of points `(..., 3)`."""
    thigh, shin = knees - hips, ankles - knees
    return np.arctan2(np.linalg.norm(cross(thigh, shin), axis=-1), dot(thigh, shin))


def segment_gaps(a: Array, b: Array, c: Array, d: Array) -> Array:
    """Shortest distances `(...)` between the segments from `a` to `b` and from `c` to `d`, all `(..., 3)`.

    Ericson, "Real-Time Collision Detection" (2005), 5.1.9.
    """
    one, two, between = b - a, d - c, a - c
    aa, bb, ab = dot(one, one), dot(two, two), dot(one, two)
    along_one, along_two = dot(one, between), dot(two, between)
    aa, bb = np.maximum(aa, 1e-12), np.maximum(bb, 1e-12)
    across = aa * bb - ab * ab
    parallel = across < 1e-9 * aa * bb
    s = np.clip((ab * along_two - along_one * bb) / np.where(parallel, 1.0, across), 0.0, 1.0)
    s = np.where(parallel, 0.0, s)
    t = (ab * s + along_two) / bb
    s = np.where(t < 0.0, np.clip(-along_one / aa, 0.0, 1.0), s)
    s = np.where(t > 1.0, np.clip((ab - along_one) / aa, 0.0, 1.0), s)
    t = np.clip(t, 0.0, 1.0)
    return np.linalg.norm(between + s[..., None] * one - t[..., None] * two, axis=-1)


def swivel_errors(arm: Array, true_arm: Array, least: float) -> Array:
    """Angles `(...)` in [0, pi] about the line from shoulder to wrist by which the elbow is off the true one's side.

    Args:
        arm: shoulder, elbow and wrist `(..., 3, 3)`, metres.
        true_arm: the same of the user.
        least: metres that both elbows have to be off that line; NaN for straighter arms.
    """
    axis = arm[..., 2, :] - arm[..., 0, :]
    axis = axis / np.maximum(np.linalg.norm(axis, axis=-1, keepdims=True), 1e-9)

    def aside(points: Array) -> Array:
        out = points[..., 1, :] - points[..., 0, :]
        return out - dot(out, axis)[..., None] * axis

    mine, theirs = aside(arm), aside(true_arm)
    bent = np.minimum(*(np.linalg.norm(part, axis=-1) for part in (mine, theirs))) > least
    angle = np.arctan2(np.linalg.norm(cross(mine, theirs), axis=-1), dot(mine, theirs))
    return np.where(bent, angle, np.nan)

"""Angles about the vertical: yaw 0 faces +Y, positive turns left (counter-clockwise seen from above)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.floating[Any]]


def wrap(angle: ArrayLike) -> Array:
    """`angle` in radians brought into [-pi, pi)."""
    return (np.asarray(angle, dtype=np.float64) + np.pi) % (2.0 * np.pi) - np.pi


def direction(yaw: ArrayLike) -> Array:
    """The ground direction `(..., 2)` that a yaw `(...)` in radians faces."""
    yaw = np.asarray(yaw, dtype=np.float64)
    return np.stack([-np.sin(yaw), np.cos(yaw)], axis=-1)


def arctan2(y: ArrayLike, x: ArrayLike) -> Array:
    """numpy's, the same to the last bit wherever its operands lie in memory.

    Of slices numpy works out either the vectorised or the C library's arc tangent, by what their memory is next to.
    """
    return np.arctan2(np.asarray(y, order="C"), np.asarray(x, order="C"))


def yaw_of(vector: Array) -> Array:
    """The yaw in radians `(...)` of ground vectors `(..., 2 or more)`; a zero vector gives 0."""
    return arctan2(-vector[..., 0], vector[..., 1])


def turn(vector: Array, yaw: ArrayLike) -> Array:
    """Ground vectors `(..., 2)` turned about the vertical by `yaw` radians `(...)`."""
    c, s = np.cos(yaw), np.sin(yaw)
    return np.stack(
        [c * vector[..., 0] - s * vector[..., 1], s * vector[..., 0] + c * vector[..., 1]], axis=-1
    )

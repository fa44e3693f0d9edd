"""Vectors `(..., 3)`: products, lengths and planes, by the quickest way numpy has for many short rows."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]


def dot(a: Array, b: Array) -> Array:
    """Dot products `(...)`."""
    return np.einsum("...i,...i->...", a, b)


def norm(vectors: Array) -> Array:
    """Lengths `(...)`."""
    return np.sqrt(dot(vectors, vectors))


def unit(vectors: Array) -> Array:
    """Vectors of length 1; X where there is none."""
    length = norm(vectors)[..., None]
    return np.where(length > 1e-12, vectors / np.maximum(length, 1e-12), np.array([1.0, 0.0, 0.0]))


def across(vectors: Array, axis: Array) -> Array:
    """The part of vectors perpendicular to unit vectors `axis`."""
    return vectors - dot(vectors, axis)[..., None] * axis


def cross(a: Array, b: Array) -> Array:
    """Cross products."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    x = ay * bz - az * by
    out = np.empty((*x.shape, 3), order="F")
    out[..., 0], out[..., 1], out[..., 2] = x, az * bx - ax * bz, ax * by - ay * bx
    return out


def plane(along: Array, side: Array) -> Array:
    """Right-handed axes `(..., 3, 3)` in columns: `along`, the part of `side` across it, their cross
    product."""
    x = unit(along)
    y = across(side, x)
    lost = dot(y, y) < 1e-18
    if lost.any():
        # a side along the line tells no plane: any will do
        least = np.eye(3)[np.argmin(np.abs(x), axis=-1)]
        y = np.where(lost[..., None], across(least, x), y)
    y = unit(y)
    out = np.empty((*y.shape, 3), order="F")
    out[..., 0], out[..., 1], out[..., 2] = x, y, cross(x, y)
    return out


def level(vectors: Array) -> Array:
    """Vectors with their height set to zero."""
    return vectors * np.array([1.0, 1.0, 0.0])

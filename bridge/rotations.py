"""Quaternion tracks as the numbers that Blender keys: quaternion, Euler of any order, axis and angle."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core.maths import quat
from ..core.maths.angles import arctan2, wrap

Array = NDArray[np.floating[Any]]

PROPERTIES = {"QUATERNION": "rotation_quaternion", "AXIS_ANGLE": "rotation_axis_angle"}


def property_of(mode: str) -> str:
    """The pose bone's or object's property that holds a rotation in this `rotation_mode`."""
    return PROPERTIES.get(mode, "rotation_euler")


def channels(rotations: Array, mode: str) -> Array:
    """Values to key `(T, 4)` or, for Euler modes, `(T, 3)` in radians, continuous over time.

    Args:
        rotations: `(T, 4)` unit quaternions.
        mode: Blender's `rotation_mode`: "QUATERNION", "AXIS_ANGLE" or an Euler order such as "XYZ".
    """
    if mode == "QUATERNION":
        return quat.continuous(rotations)
    if mode == "AXIS_ANGLE":
        return axis_angle(rotations)
    return euler(rotations, mode)


def quaternions(values: Array, mode: str) -> Array:
    """The way back from `channels`: `(T, 4)` unit quaternions, continuous over time."""
    if mode == "QUATERNION":
        return quat.continuous(quat.normalize(values))
    if mode == "AXIS_ANGLE":
        axis = values[:, 1:] / np.maximum(np.linalg.norm(values[:, 1:], axis=-1, keepdims=True), 1e-12)
        return quat.continuous(quat.from_rotation_vector(values[:, :1] * axis))
    return quat.continuous(quat.from_euler(values[:, ["XYZ".index(axis) for axis in mode[::-1]]], mode[::-1]))


def euler(rotations: Array, mode: str) -> Array:
    """Blender Euler angles `(T, 3)` as x, y, z, without jumps by whole turns or to the mirrored solution."""
    # Blender's "XYZ" turns about x first, about fixed axes: the reverse order about moving axes
    angles = quat.to_euler(rotations, mode[::-1])
    mirrored = np.stack([angles[:, 0] + np.pi, np.pi - angles[:, 1], angles[:, 2] + np.pi], axis=-1)
    stay = np.abs(wrap(angles[1:] - angles[:-1])).sum(axis=-1)
    swap = np.abs(wrap(mirrored[1:] - angles[:-1])).sum(axis=-1)
    flipped = np.concatenate([[0], np.cumsum(swap < stay) % 2]).astype(bool)
    values = np.unwrap(np.where(flipped[:, None], mirrored, angles), axis=0)
    return values[:, [mode[::-1].index(axis) for axis in "XYZ"]]


def axis_angle(rotations: Array) -> Array:
    """Angle in radians and unit axis `(T, 4)`; the axis keeps its side and, where the angle is 0, its direction."""
    vector = rotations[:, 1:]
    sine = np.linalg.norm(vector, axis=-1)
    turned = sine > 1e-6
    axis: Array = vector / np.maximum(sine, 1e-6)[:, None]
    last = np.maximum.accumulate(np.where(turned, np.arange(len(sine)), -1))
    first = int(np.argmax(turned)) if turned.any() else -1
    axis = np.array([0.0, 1.0, 0.0]) if first < 0 else axis[np.where(last < 0, first, last)]
    axis = np.broadcast_to(axis, vector.shape)
    flips = np.cumsum(np.sum(axis[1:] * axis[:-1], axis=-1) < 0.0) % 2
    axis = axis * np.concatenate([[1.0], 1.0 - 2.0 * flips])[:, None]
    angle = np.unwrap(2.0 * arctan2(np.sum(vector * axis, axis=-1), rotations[:, 0]))
    return np.concatenate([angle[:, None], axis], axis=-1)

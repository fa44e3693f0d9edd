"""The field's measures of full-body animation, as functions of arrays in metres, seconds and radians.

Foot skating has four definitions in the literature; all are here by name. Heights are those of the toes
above where they are in T-pose, so that a joint inside the foot does not count as floating.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..maths import angles, quat

Array = NDArray[np.floating[Any]]
Flags = NDArray[np.bool_]

CM = 100.0
"""Centimetres in a metre."""
NSM_HEIGHT_M = 0.025
"""Height above which a foot does not skate at all (Starke et al. 2019, after Zhang et al. 2018)."""
RATIO_HEIGHT_M = 0.05
RATIO_SPEED_M_S = 0.5
"""A foot lower and faster than these skates: 2.5 cm a frame at 20 per second (Karunratanakul et al. 2023)."""


def summary(values: Array) -> dict[str, float]:
    """Mean, standard deviation, 95th percentile, maximum and number of all values that are not NaN.

    Where nothing was to be measured all are 0, and `count` tells that from a perfect result.
    """
    counted = values[~np.isnan(values)]
    if counted.size == 0:
        return {"mean": 0.0, "std": 0.0, "p95": 0.0, "max": 0.0, "count": 0}
    return {
        "mean": float(counted.mean(dtype=np.float64)),
        "std": float(counted.std(dtype=np.float64)),
        "p95": float(np.percentile(counted, 95)),
        "max": float(counted.max()),
        "count": int(counted.size),
    }


def counted(values: Array, where: Flags) -> Array:
    """`values` with NaN, "does not count", where `where` (of the same shape or fewer trailing axes) is
    False."""
    where = where.reshape(*where.shape, *(1,) * (values.ndim - where.ndim))
    return np.where(where, values, np.nan)


def distances(a: Array, b: Array) -> Array:
    """Distances `(...)` between points `(..., 2 or 3)`."""
    return np.linalg.norm(a - b, axis=-1)


def yaw_errors(a: Array, b: Array) -> Array:
    """Absolute differences `(...)` in [0, pi] between yaws `(...)`."""
    return np.abs(angles.wrap(a - b))


def rotation_errors(a: Array, b: Array) -> Array:
    """Geodesic angles `(...)` in [0, pi] between rotations `(..., 4)`: MPJAE where joints are averaged."""
    return np.linalg.norm(quat.to_rotation_vector(quat.multiply(a, quat.conjugate(b))), axis=-1)


def rotation_vector_errors(a: Array, b: Array) -> Array:
    """Absolute differences `(..., 3)` of rotation vectors' components, wrapped: the field's MPJRE."""
    return np.abs(angles.wrap(quat.to_rotation_vector(a) - quat.to_rotation_vector(b)))


def speeds(points: Array, fps: float) -> Array:
    """Speeds `(T - 1, ...)` in m/s of points `(T, ..., 3)`; of differences of joint positions: MPJVE."""
    return np.linalg.norm(np.diff(points, axis=0), axis=-1) * fps


def jitter(positions: Array, fps: float) -> Array:
    """Third derivatives `(T - 3, J)` in m/s^3 of joint positions `(T, J, 3)`; none for fewer than four
    frames."""
    return np.linalg.norm(np.diff(positions, n=3, axis=0), axis=-1) * fps**3


def ground_steps(toes: Array) -> Array:
    """Horizontal way `(T - 1, 2)` in metres that each toe of `(T, 2, 3)` makes from frame to frame."""
    return np.linalg.norm(np.diff(toes[..., :2], axis=0), axis=-1)


def contact_speeds(toes: Array, contacts: Flags, fps: float) -> Array:
    """Horizontal toe speeds `(T - 1, 2)` in m/s over steps between two frames in contact; NaN for others.

    Args:
        toes: `(T, 2, 3)` metres.
        contacts: `(T, 2)`.
        fps: frames per second.
    """
    return counted(ground_steps(toes) * fps, contacts[1:] & contacts[:-1])


def slides(toes: Array, contacts: Flags) -> Array:
    """Length `(P,)` in metres of the toe's path on the ground over each contact phase of both feet."""
    out: list[Array] = []
    for steps, held in zip(ground_steps(toes).T, contacts.T, strict=True):
        edges = np.diff(np.concatenate([[False], held, [False]]).astype(np.int8))
        starts, stops = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
        way = np.concatenate([[0.0], np.cumsum(steps)])
        out.append(way[stops - 1] - way[starts])
    return np.concatenate(out)


def nsm_skate(toes: Array, heights: Array, fps: float, limit: float = NSM_HEIGHT_M) -> Array:
    """Toe speeds `(T - 1, 2)` in m/s, weighted from 1 on the ground to 0 at `limit`: v (2 - 2^(h / limit)).

    Args:
        toes: `(T, 2, 3)` metres.
        heights: `(T, 2)` metres above the toes' place in T-pose.
        fps: frames per second.
        limit: metres.
    """
    share = np.clip(heights[1:] / limit, 0.0, 1.0)
    return ground_steps(toes) * fps * (2.0 - 2.0**share)


def skating(toes: Array, heights: Array, fps: float, size: float = 1.0) -> Flags:
    """Frames `(T - 1,)` in which a low foot moves fast, about 1 in 20 of true motion; arguments as
    `nsm_skate`, and the size of the body as a share of a usual one."""
    limit = RATIO_HEIGHT_M * size
    low = (heights[1:] < limit) & (heights[:-1] < limit)
    fast = ground_steps(toes) * fps > RATIO_SPEED_M_S * size
    return np.logical_or.reduce(low & fast, axis=-1)

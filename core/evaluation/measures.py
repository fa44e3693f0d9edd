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

NSM_HEIGHT_M = 0.025
"""Height above which a foot does not skate at all (Starke et al. 2019, after Zhang et al. 2018)."""
RATIO_HEIGHT_M = 0.05
RATIO_SPEED_M_S = 0.5
"""A foot lower and faster than these skates: 2.5 cm a frame at 20 per second (Karunratanakul et al. 2023)."""


def summary(values: Array) -> dict[str, float]:
    """Mean, standard deviation, 95th percentile and maximum of all values; zeros where there are none."""
    if values.size == 0:
        return {"mean": 0.0, "std": 0.0, "p95": 0.0, "max": 0.0}
    return {
        "mean": float(values.mean()),
        "std": float(values.std()),
        "p95": float(np.percentile(values, 95)),
        "max": float(values.max()),
    }


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


def jitter(positions: Array, fps: float) -> float:
    """Mean third difference of joint positions `(T, J, 3)` in m/s^3; 0 for fewer than four frames."""
    if len(positions) < 4:
        return 0.0
    return float(np.linalg.norm(np.diff(positions, n=3, axis=0), axis=-1).mean() * fps**3)


def ground_steps(toes: Array) -> Array:
    """Horizontal way `(T - 1, 2)` in metres that each toe of `(T, 2, 3)` makes from frame to frame."""
    return np.linalg.norm(np.diff(toes[..., :2], axis=0), axis=-1)


def contact_speeds(toes: Array, contacts: Flags, fps: float) -> Array:
    """Horizontal toe speeds `(M,)` in m/s over all steps between two frames in contact.

    Args:
        toes: `(T, 2, 3)` metres.
        contacts: `(T, 2)`.
        fps: frames per second.
    """
    return ground_steps(toes)[contacts[1:] & contacts[:-1]] * fps


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


def skating_ratio(toes: Array, heights: Array, fps: float) -> float:
    """Share of frames in which a low foot moves fast, about 0.05 in true motion; arguments as `nsm_skate`."""
    low = (heights[1:] < RATIO_HEIGHT_M) & (heights[:-1] < RATIO_HEIGHT_M)
    skates = low & (ground_steps(toes) * fps > RATIO_SPEED_M_S)
    return float(skates.any(axis=-1).mean()) if len(skates) else 0.0


def transitions_per_s(count: int, frames: int, fps: float) -> float:
    """Transitions per second of a motion of so many frames."""
    return count * fps / max(frames - 1, 1)


def fraction(flags: Flags, among: Flags | None = None) -> float:
    """Share of True in `flags`, all or where `among` is True; 0 where there is nothing to count."""
    counted = flags if among is None else flags[among]
    return float(counted.mean()) if counted.size else 0.0

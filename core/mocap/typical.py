"""The pose that a take shows most, for skeletons whose zero pose tells nothing."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body.skeleton import SIDES
from ..maths import angles, kinematics, quat
from .raw_body import RawBody

Array = NDArray[np.floating[Any]]

_FRAMES = 1000
"""Frames looked at, spread over the take."""
_UPRIGHT = 0.06
"""Frames count as upright whose trunk is no more than this (1 - cosine) off the take's most upright ones."""
_PLANTED = 0.25
"""m/s: a toe slower than this stands."""
_FLAT = 0.01
"""Metres that an ankle over a standing toe may be off the height at which it is most: beyond, the heel is up."""


def typical_pose(body: RawBody, fps: float) -> Array | None:
    """Global rotations `(J, 4)` of the body's mean pose while upright, facing +Y; None for a single frame.

    Each joint has its mean rotation against its parent (chordal mean, Markley et al. 2007), the hips their
    mean tilt. Feet have their mean tilt while they stand flat, pointing forward, and toes their mean on such feet.
    """
    positions = body.positions
    count = len(positions)
    if count < 2:
        return None
    frames = np.unique(np.linspace(0, count - 1, min(count, _FRAMES)).astype(np.intp))
    torso = positions[frames, body.joint("head")] - positions[frames, 0]
    tilt = 1.0 - torso[:, 2] / np.linalg.norm(torso, axis=-1)
    frames = frames[tilt <= np.quantile(tilt, 0.1) + _UPRIGHT]
    right = positions[frames, body.joint("thigh.R")] - positions[frames, body.joint("thigh.L")]
    yaw = angles.arctan2(right[:, 1], right[:, 0])
    out = np.empty((len(body.names), 4))
    out[0] = _mean(quat.multiply(quat.from_yaw(-yaw), body.rotations[frames, 0]))
    feet = {body.joint(f"foot.{side}"): side for side in SIDES}
    toes = {body.roles.index(f"toe.{side}") for side in SIDES if f"toe.{side}" in body.roles}
    planted: dict[int, NDArray[np.intp]] = {}
    for j in range(1, len(out)):
        p = int(body.parents[j])
        chosen = planted.get(p, frames) if j in toes else frames
        out[j] = quat.multiply(out[p], _mean(_local(body.rotations[chosen], p, j)))
        if j in feet and f"toe.{feet[j]}" in body.roles:
            toe = positions[:, body.joint(f"toe.{feet[j]}")]
            planted[j] = _planted(toe, positions[:, j], fps)
            points = toe[planted[j]] - positions[planted[j], j]
            out[j] = _mean(
                quat.multiply(quat.from_yaw(-angles.yaw_of(points)), body.rotations[planted[j], j])
            )
    return out


def _planted(toe: Array, ankle: Array, fps: float) -> NDArray[np.intp]:
    """Frames in which a foot stands flat: the toe `(T, 3)` slow and low, where none is its slowest tenth, and the
    ankle `(T, 3)` over it as high as it is most of that time."""
    speed = np.linalg.norm(kinematics.velocity(toe, fps), axis=-1)
    slow = speed < max(_PLANTED, float(np.quantile(speed, 0.1)))
    low = toe[:, 2] < np.quantile(toe[slow, 2], 0.5) + 0.03
    frames = np.flatnonzero(slow & low)
    rise = ankle[frames, 2] - toe[frames, 2]
    frames = frames[np.abs(rise - _most_common(rise)) <= _FLAT]
    return frames[:: max(1, len(frames) // _FRAMES)]


def _most_common(values: Array) -> float:
    """The mode of values `(N,)`: the middle of the shortest span that holds half of them (Venter 1967)."""
    ordered = np.sort(values)
    half = (len(ordered) + 1) // 2
    spans = ordered[half - 1 :] - ordered[: len(ordered) - half + 1]
    first = int(np.argmin(spans))
    return float(0.5 * (ordered[first] + ordered[first + half - 1]))


def _local(rotations: Array, parent: int, joint: int) -> Array:
    return quat.multiply(quat.conjugate(rotations[:, parent]), rotations[:, joint])


def _mean(rotations: Array) -> Array:
    """The chordal mean `(4,)` of rotations `(T, 4)`: main axis of their outer products."""
    return np.linalg.eigh(rotations.T @ rotations)[1][:, -1]

"""When each foot steps on a way: the contacts that the motion model is told."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.maths import angles, kinematics
from .conditions import Root

Array = NDArray[np.floating[Any]]

# medians measured on the takes that the model learnt from: speeds in m/s, seconds
_SPEEDS = (0.1, 0.4, 0.6, 0.8, 1.0, 1.2, 1.4, 1.7, 2.0, 2.5, 3.0, 3.75)
_APART = (0.67, 0.64, 0.59, 0.60, 0.57, 0.54, 0.50, 0.45, 0.37, 0.33, 0.30, 0.27)
"""From one foot's lift to the other's, of walks and jogs."""
_SWING = (0.30, 0.42, 0.50, 0.53, 0.53, 0.53, 0.53, 0.51, 0.50, 0.50, 0.47, 0.43)
_SIDE_SPEEDS = (0.2, 0.4, 0.65, 1.0, 1.5)
_LEAD_APART, _TRAIL_APART = (0.60, 0.43, 0.42, 0.37, 0.36), (0.80, 0.73, 0.50, 0.30, 0.27)
"""In side-steps the foot that goes ahead is soon followed by the other, which then waits."""
_LEAD_SWING, _TRAIL_SWING = (0.30, 0.34, 0.37, 0.37, 0.40), (0.25, 0.28, 0.32, 0.36, 0.42)
_CROUCH_APART, _CROUCH_SWING = 0.44, 0.40
_SPOT_SWING = 0.32
"""Steps of who stands or turns on the spot."""
_OFF_M, _OFF_RAD = 0.11, np.radians(24.0)
"""A standing foot steps once it is so far from where it would stand best."""
_MOVES = 0.28
"""m/s from which steps alternate."""
_ASIDE = 0.11
"""Metres of a foot beside the body's middle."""


def plan_steps(root: Root, rng: np.random.RandomState, standing_height: float) -> NDArray[np.bool_]:
    """Contacts `(T, 2)`: which feet stand, left and right."""
    fps, count = root.fps, len(root)
    pace = angles.turn(kinematics.velocity(root.places, fps), -root.yaws)
    best = root.places[:, None] + angles.turn(np.array([[[-_ASIDE, 0.0], [_ASIDE, 0.0]]]), root.yaws[:, None])
    contacts = np.ones((count, 2), dtype=bool)
    foot = [_Foot(best[0, side], root.yaws[0]) for side in (0, 1)]
    last, due, follows = 1, 0.0, -10.0
    for t in range(count):
        ahead = min(t + round(0.2 * fps), count - 1)
        speed = float(np.hypot(*pace[ahead]))
        stands = [t >= foot[side].until for side in (0, 1)]
        if speed > _MOVES:
            if t < due:
                continue
            side = 1 - last if t - follows < 1.2 * fps else _first(pace[ahead], best[ahead], foot)
            if t < foot[side].until + 0.1 * fps:
                continue
            apart, swing = _timing(pace[ahead], side, root.heights[ahead] / standing_height, rng)
        else:
            off = [
                max(
                    float(np.hypot(*(best[ahead, side] - foot[side].place))) / (_OFF_M * foot[side].patience),
                    abs(root.yaws[ahead] - foot[side].yaw) / (_OFF_RAD * foot[side].patience),
                )
                for side in (0, 1)
            ]
            side = int(np.argmax(off))
            if off[side] < 1.0 or not all(stands) or t < due:
                continue
            swing = _SPOT_SWING * float(np.exp(0.1 * rng.normal()))
            apart = swing + 0.06
        land = min(t + round(swing * fps), count - 1)
        contacts[t:land, side] = False
        # while walking a foot comes down where the body will be in the middle of its stand
        where = min(land + round(0.2 * fps), count - 1)
        foot[side] = _Foot(best[where, side], root.yaws[where], land, 1.0 + 0.15 * rng.normal())
        last, due, follows = side, t + apart * fps, t
    return contacts


class _Foot:
    def __init__(self, place: Array, yaw: float, until: int = 0, patience: float = 1.0) -> None:
        self.place, self.yaw, self.until, self.patience = place, yaw, until, max(patience, 0.6)


def _timing(pace: Array, side: int, height: float, rng: np.random.RandomState) -> tuple[float, float]:
    """Seconds to the other foot's lift, and in the air."""
    right, ahead = float(pace[0]), float(pace[1])
    speed = float(np.hypot(right, ahead))
    apart, swing = (float(np.interp(speed, _SPEEDS, table)) for table in (_APART, _SWING))
    leads = (right > 0.0) == (side == 1)
    tables = (_LEAD_APART, _LEAD_SWING) if leads else (_TRAIL_APART, _TRAIL_SWING)
    aside = float(np.clip(2.0 * abs(right) / speed - 0.9, 0.0, 1.0))
    low = float(np.clip((0.92 - height) / 0.08, 0.0, 1.0)) * (1.0 - aside)
    for share, (other, swung) in (
        (aside, [float(np.interp(speed, _SIDE_SPEEDS, table)) for table in tables]),
        (low, (min(apart, _CROUCH_APART), min(swing, _CROUCH_SWING))),
    ):
        apart, swing = apart + share * (other - apart), swing + share * (swung - swing)
    jitter = np.exp(0.06 * rng.normal(size=2))
    return apart * float(jitter[0]), swing * float(jitter[1])


def _first(pace: Array, best: Array, foot: list[_Foot]) -> int:
    """The foot that begins: to the side the one on that side, else the one that lags most."""
    if abs(pace[0]) > 0.7 * abs(pace[1]):
        return int(pace[0] > 0.0)
    lag = [float(np.hypot(*(best[side] - foot[side].place))) for side in (0, 1)]
    return int(np.argmax(lag))

"""How well each way of reading a recording fits a person: one number, higher is better.

A point is about a factor e of likelihood; every term is bounded, so that no single one outvotes all others. The weights
are set so that real recordings and their mirrored, swapped and mixed-up variants lie far apart (tests compare).
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from ..raw import DIRECTIONS, Reading
from ..recording import Array
from .plausibility import Figures

COMMON = {
    "RUB": "OpenXR axes",
    "RUF": "Unity axes",
    "RFU": "Blender axes",
    "FRU": "Unreal axes",
    "FLU": "ROS axes",
}
"""Axes that programs use."""
ORDERS = {
    "RUF": ("YXZ", "rotator"),
    "RUB": ("YXZ", "XYZ", "rotator"),
    "RFU": ("ZYX", "XYZ", "pitchx"),
    "FRU": ("ZYX", "rotator"),
    "FLU": ("ZYX", "aviation"),
}
"""Orders of angles that programs with these axes use, the usual first; pitch, yaw and roll last."""
EVERY = tuple(
    "".join(letters)
    for pairs in itertools.permutations(("RL", "UD", "FB"))
    for letters in itertools.product(*pairs)
)
"""All 48."""
_CAMERA = "RUB"
"""Device axes of cameras, which look along -Z with Y up in whatever world."""
UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "ft": 0.3048, "in": 0.0254}
_FIT = 12.0
"""Points for movement that turns explain whole: a tenth more of it is no accident in a few hundred moments."""
_TURN = 30.0
"""Points for turns that are shorter by a factor e: those of the right order of angles are nearly always shortest."""
_LEAST_TURN = 1e-4
"""Radians: less is noise."""
_HEAD_LEVER, _HAND_LEVER = 0.08, 0.3
"""Metres from the neck forward to a headset, from an elbow to a controller."""


@dataclass(frozen=True, slots=True)
class Seen:
    """What a reading makes of a recording, for people and for the score."""

    upright: float
    """Median vertical component of the headset's up axis."""
    ahead: float
    """Share of the time that hands are ahead of the head; NaN without hands."""
    left: float
    """Share of the time that the left hand is left of the right one, or of the head; NaN without hands."""
    below: float
    """Share of the time that hands are below the head; NaN without hands."""
    head_lever: tuple[float, float]
    """Metres that the headset is ahead of and above the point about which the head turns."""
    hand_lever: float
    """Metres that controllers are ahead of the point about which they turn; NaN without hands."""
    walk: float
    """Cosine between the way walked and the headset's forward."""
    pointing: float
    """Median cosine between where hands and headset point; NaN without hands."""
    fit: float
    """How much of the movement turns explain, 0 to 1."""
    height: float
    """Metres of the headset over the origin, most of the time at most."""
    reach: float
    """Share of the time that hands are within reach; NaN without hands."""


@dataclass(frozen=True, slots=True)
class Candidate:
    """One way of reading, what it makes of the recording, and its score."""

    reading: Reading
    seen: Seen
    score: float


@dataclass(frozen=True, slots=True, eq=False)
class Span:
    """Lengths in the file's unit, of one placement of the hands."""

    heights: Array
    """`(3, 2)` 5th and 95th percentile of the headset's coordinates."""
    reaches: Array
    """Distances of hands from the head, `(K,)`; empty without hands."""


def worlds() -> list[tuple[str, str]]:
    """Axes of the world and of devices to try: the same for both, or devices as cameras."""
    return [(axes, "") for axes in EVERY] + [(axes, _CAMERA) for axes in EVERY if axes[2] in "UD"]


def see(figures: Figures, span: Span, reading: Reading) -> Seen:
    """What a reading makes of the figures."""
    world, device = _matrix(reading.axes), _matrix(reading.devices or reading.axes)
    (up, up_sign), (forward, forward_sign) = _axis(world[2]), _axis(device[1])
    own_up, own_sign = _axis(device[2])
    handed = math.copysign(1.0, float(np.linalg.det(world)))
    ahead = _turned(_mean(figures.ahead[up, forward]), forward_sign)
    left = float(figures.left[up, forward])
    if math.isnan(left):
        left = _mean(figures.beside[up, forward] * (1.0, -1.0) + (0.0, 1.0))
    mirrored = handed * up_sign * forward_sign * (-1.0 if reading.swapped else 1.0)
    hands = np.isfinite(figures.lever_spread[1:])
    metres = reading.metres
    high = np.max(span.heights[up] * up_sign)
    return Seen(
        upright=float(figures.upright[up, own_up] * up_sign * own_sign),
        ahead=ahead,
        left=_turned(left, mirrored),
        below=_turned(float(figures.below[up]), up_sign),
        head_lever=(
            float(figures.lever[0, forward] * forward_sign * metres),
            float(figures.lever[0, own_up] * own_sign * metres),
        ),
        hand_lever=float(figures.lever[1:, forward][hands].mean() * forward_sign * metres)
        if hands.any()
        else math.nan,
        walk=float(figures.walk[up, forward] * forward_sign),
        pointing=float(figures.pointing[:, up, forward][hands].mean()) if hands.any() else math.nan,
        fit=float(figures.fit @ (0.5, 1.0, 1.0) / 2.5),
        height=float(high * metres),
        reach=_reach(span, metres),
    )


def score(seen: Seen, figures: Figures, metres: float) -> float:
    """How well what is seen fits a person, without any belief in what a file says."""
    spread = figures.lever_spread * metres
    total = -10.0 * max(0.0, 0.8 - seen.upright)
    total += 5.0 * _centred(seen.ahead) + 4.0 * _centred(seen.left) + 3.0 * _centred(seen.below)
    total += 1.5 * _bounded(seen.head_lever[0] / _HEAD_LEVER, 1.0 + spread[0] / 0.03)
    total += 1.0 * _bounded(seen.head_lever[1] / _HEAD_LEVER, 1.0 + spread[0] / 0.03)
    if not math.isnan(seen.hand_lever):
        total += 3.0 * _bounded(seen.hand_lever / (0.5 * _HAND_LEVER), 1.0)
        total += 1.0 * seen.pointing
    total += _FIT * seen.fit - _TURN * math.log(max(figures.turned, _LEAST_TURN))
    total += 3.0 * seen.walk * min(1.0, figures.walked * metres / 2.0)
    return total + _unit_points(seen.height, seen.reach)


def _unit_points(height: float, reach: float) -> float:
    """How well lengths fit a person's."""
    total = 0.0 if math.isnan(reach) else 8.0 * (reach - 1.0)
    if 0.8 <= height <= 2.3:
        return total + 2.0
    return total if abs(height) < 0.6 else total - 2.0


def up_axis(axes: str) -> tuple[int, float]:
    """Which of a file's axes is vertical, and 1 where it points up, else -1."""
    return _axis(_matrix(axes)[2])


def best_unit(
    span: Span, up: tuple[int, float], stated: float, units: tuple[float, ...], belief: float
) -> float:
    """The unit of length, in metres, that makes the likeliest body.

    Args:
        span: lengths in the file's unit.
        up: of the reading (see `up_axis`).
        stated: the unit that the file states, or the usual one.
        units: to choose from.
        belief: points for `stated`.
    """
    high = float(np.max(span.heights[up[0]] * up[1]))
    far = float(np.percentile(span.reaches, 95)) if span.reaches.size else 0.0

    def rank(metres: float) -> float:
        points = _unit_points(high * metres, _reach(span, metres)) + belief * (metres == stated)
        if far > 0.0:
            # people stretch their arms now and then, and hold hands off their eyes
            return points - 2.0 * abs(math.log(far * metres / 0.65))
        return points - 2.0 * abs(math.log(high * metres / 1.6)) if high > 0.0 else points

    return max(units, key=rank)


def _reach(span: Span, metres: float) -> float:
    """Share of the time that hands are within reach; NaN without hands."""
    if not span.reaches.size:
        return math.nan
    return float(np.mean((span.reaches * metres > 0.05) & (span.reaches * metres < 1.05)))


def _matrix(axes: str) -> Array:
    """Rows: right, forward, up in terms of the file's axes."""
    return np.array([DIRECTIONS[letter] for letter in axes]).T


def _axis(row: Array) -> tuple[int, float]:
    index = int(np.argmax(np.abs(row)))
    return index, float(row[index])


def _mean(values: Array) -> float:
    """Of those that are known; NaN where none is."""
    known = values[np.isfinite(values)]
    return float(known.mean()) if known.size else math.nan


def _turned(share: float, sign: float) -> float:
    return share if sign > 0.0 else 1.0 - share


def _centred(share: float) -> float:
    """-1 for never, 1 for always, 0 where unknown."""
    return 0.0 if math.isnan(share) else 2.0 * share - 1.0


def _bounded(value: float, spread: float) -> float:
    return math.tanh(value / spread) if math.isfinite(spread) else 0.0

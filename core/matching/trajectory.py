"""Where the body shall be, now and in the future that a query asks for (paper, section 5.3).

Two forms. *Causal* uses nothing but the past, as the paper must: smoothed velocity and orientation,
extrapolated. *Look-ahead* reads the recorded future, which an offline bake knows.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..database.motion_database import HORIZONS_S
from ..errors import InputError
from ..maths import filters
from ..settings import BakeSettings

Array = NDArray[np.floating[Any]]

LOOK_AHEAD_SMOOTHING_S = 0.1
"""Standard deviation in seconds of the Gaussian over the look-ahead path: takes out tracker noise, keeps the
steps."""


@dataclass(frozen=True, slots=True, eq=False)
class FeetEvidence:
    """Where the user's ankles are, and which feet stand, over time."""

    ankles: Array
    """`(T, 2, 3)` metres from the hips, along the world's axes, on the databases' body."""
    weights: Array
    """`(T, 2)` of the left and the right foot, 1/m^2."""
    standing: Array | None
    """`(T, 2)` how likely each foot stands, 0 to 1."""


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """Targets and wanted futures for every frame of a recording, in the world."""

    fps: float
    targets: Array
    """`(T, 2)` metres: where the virtual root should be now; alpha is measured from here."""
    yaws: Array
    """`(T,)` radians, without jumps: where the body should face now."""
    velocities: Array
    """`(T, 2)` m/s: the smoothed velocity of the target."""
    future_positions: Array
    """`(T, 3, 2)` metres: where the virtual root should be at each of `HORIZONS_S`."""
    future_yaws: Array
    """`(T, 3)` radians: where the body should face then."""
    feet: FeetEvidence | None = None
    """Where the user's feet are, as far as that is known."""

    def __len__(self) -> int:
        return len(self.yaws)


def make_trajectory(targets: Array, yaws: Array, fps: float, settings: BakeSettings) -> Trajectory:
    """The trajectory in the form that the settings choose.

    Args:
        targets: `(T, 2)` metres, centre of the head projected on the ground, at an even rate.
        yaws: `(T,)` radians, predicted body orientation; may jump by full turns.
        fps: frames per second of both, and of the databases.
        settings: `trajectory`, and for the causal form `smoothing` and `beta`.

    Raises:
        InputError: nothing is recorded, or a value is not finite.
    """
    targets = np.asarray(targets, dtype=np.float64)
    yaws = np.asarray(yaws, dtype=np.float64)
    if len(yaws) == 0:
        raise InputError("recording: it has no frames; give one with at least a second of movement")
    broken = ~(np.isfinite(targets).all(axis=-1) & np.isfinite(yaws))
    if broken.any():
        frame = int(np.argmax(broken))
        raise InputError(
            f"recording: frame {frame}: head position or body orientation is not finite; repair it first"
        )
    yaws = np.unwrap(yaws)
    if settings.trajectory == "look-ahead":
        return look_ahead_trajectory(targets, yaws, fps)
    return causal_trajectory(targets, yaws, fps, settings.beta, spring=settings.smoothing == "spring")


def causal_trajectory(targets: Array, yaws: Array, fps: float, beta: float, *, spring: bool) -> Trajectory:
    """The future extrapolated from the smoothed past.

    Velocity v and direction d follow the measured ones either by the paper's equations (exponential decay,
    Slerp) or by critically damped springs of the same rate beta, which the paper's results used: with x the
    distance to the goal and w its rate, x(t) = e^(-beta t) (x + (w + beta x) t). Positions are p + v/3, p +
    2v/3, p + v, directions the same smoothing run on towards the present prediction. Both use the measurement
    of the frame itself, so nothing lags but the smoothing.

    Args:
        targets: `(T, 2)` metres.
        yaws: `(T,)` radians, without jumps.
        fps: frames per second.
        beta: responsiveness in 1/s; the half-life of the exponential form is ln 2 / beta.
        spring: critically damped springs rather than exponential decay.
    """
    dt = 1.0 / fps
    measured = np.diff(targets, axis=0, prepend=targets[:1]) * fps
    if len(measured) > 1:
        measured[0] = measured[1]
    horizons = np.array(HORIZONS_S)
    if spring:
        velocities = np.stack([_spring(c, beta, dt)[0] for c in measured.T], axis=-1)
        facing, rate = _spring(yaws, beta, dt)
        offset = (facing - yaws)[:, None]
        push = rate[:, None] + beta * offset
        future_yaws = yaws[:, None] + np.exp(-beta * horizons) * (offset + push * horizons)
    else:
        share = min(beta * dt, 1.0)
        velocities = np.stack([_decay(c, share) for c in measured.T], axis=-1)
        offset = (_decay(yaws, share) - yaws)[:, None]
        future_yaws = yaws[:, None] + offset * (1.0 - share) ** np.rint(horizons * fps)
    future_positions = targets[:, None] + velocities[:, None] * horizons[:, None]
    return Trajectory(fps, targets, yaws, velocities, future_positions, future_yaws)


def _decay(goals: Array, share: float) -> Array:
    """Exponential decay towards `goals` `(T,)` by `share` a frame, starting on the first."""
    values: list[float] = []
    value = float(goals[0])
    for goal in goals.tolist():
        value += share * (goal - value)
        values.append(value)
    return np.array(values)


def _spring(goals: Array, rate: float, dt: float) -> tuple[Array, Array]:
    """Values and their rates `(T,)` of a critically damped spring pulled to `goals` `(T,)`, at rest on the
    first."""
    shrink = math.exp(-rate * dt)
    values: list[float] = []
    rates: list[float] = []
    value, speed = float(goals[0]), 0.0
    for goal in goals.tolist():
        away = value - goal
        push = speed + rate * away
        value = goal + shrink * (away + push * dt)
        speed = shrink * (speed - push * rate * dt)
        values.append(value)
        rates.append(speed)
    return np.array(values), np.array(rates)


def look_ahead_trajectory(targets: Array, yaws: Array, fps: float) -> Trajectory:
    """The recorded future, smoothed without lag; past the recording's end the last frame is held.

    Args:
        targets: `(T, 2)` metres.
        yaws: `(T,)` radians, without jumps.
        fps: frames per second.
    """
    path = filters.gaussian(np.column_stack([targets, yaws]), LOOK_AHEAD_SMOOTHING_S * fps)
    steps = np.rint(np.array(HORIZONS_S) * fps).astype(np.intp)
    ahead = path[np.minimum(np.arange(len(path))[:, None] + steps, len(path) - 1)]
    velocities = np.gradient(path[:, :2], axis=0) * fps if len(path) > 1 else np.zeros((1, 2))
    return Trajectory(fps, targets, yaws, velocities, ahead[..., :2], ahead[..., 2])

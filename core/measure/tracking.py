"""Head and hands beside the joints under the devices, where those were tracked."""

from __future__ import annotations

import numpy as np

from . import measures
from .measures import CM, Array, counted
from .metric import Metric
from .subject import Subject


def _away(subject: Subject) -> Array:
    """Distances `(T, 3)` in centimetres."""
    found = subject.body.positions[:, subject.under_devices]
    return counted(measures.distances(found, subject.devices[0]) * CM, subject.tracked)


def _turned(subject: Subject) -> Array:
    """Angles `(T, 3)` in degrees."""
    found = subject.body.rotations[:, subject.under_devices]
    return counted(np.degrees(measures.rotation_errors(found, subject.devices[1])), subject.tracked)


def _in_reach(subject: Subject) -> Array:
    return counted(_away(subject)[:, 1:], ~subject.yardstick.unreachable)


def _unreachable(subject: Subject) -> Array:
    return counted(subject.yardstick.unreachable.astype(np.float64), subject.tracked[:, 1:])


METRICS = (
    Metric(
        "head_position_error_cm",
        "head error",
        "cm",
        "Head joint to where the headset puts it",
        lambda subject: _away(subject)[:, 0],
        group="trackers",
        series=True,
        tables=("summary", "panel"),
        short="Head",
        limit=1.0,
    ),
    Metric(
        "head_rotation_error_deg",
        "head error",
        "°",
        "Head joint to how the headset turns it",
        lambda subject: _turned(subject)[:, 0],
        group="trackers",
        tables=("summary",),
    ),
    Metric(
        "hand_position_error_cm",
        "hand error",
        "cm",
        "Wrists to where the controllers put them",
        lambda subject: _away(subject)[:, 1:],
        group="trackers",
        series=True,
        tables=("summary", "panel"),
        short="Hands",
        limit=1.0,
    ),
    Metric(
        "hand_position_error_in_reach_cm",
        "hand error in reach",
        "cm",
        "The same where the arm is long enough",
        _in_reach,
        group="trackers",
    ),
    Metric(
        "hand_rotation_error_deg",
        "hand error",
        "°",
        "Wrists to how the controllers turn them",
        lambda subject: _turned(subject)[:, 1:],
        group="trackers",
    ),
    Metric(
        "unreachable_fraction",
        "out of reach",
        "",
        "Share of tracked hands farther away than the arm is long",
        _unreachable,
        group="trackers",
        kind="share",
        tables=("panel",),
    ),
)

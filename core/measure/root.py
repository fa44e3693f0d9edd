"""Where the body is and which way it faces, beside what the bake itself aimed at."""

from __future__ import annotations

import numpy as np

from . import measures
from .measures import CM, Array, counted
from .metric import Metric
from .subject import Subject


def _to_target(subject: Subject) -> Array:
    return measures.distances(subject.body.root_positions, subject.targets) * CM


def _to_head(subject: Subject) -> Array:
    away = measures.distances(subject.body.root_positions, subject.devices[0][:, 0, :2]) * CM
    return counted(away, subject.tracked[:, 0])


def _matched_to_target(subject: Subject) -> Array:
    matched = subject.playback.root_positions * subject.yardstick.scale
    return measures.distances(matched, subject.targets) * CM


def _yaw_to_prediction_deg(subject: Subject) -> Array:
    return np.degrees(measures.yaw_errors(subject.body.root_yaws, subject.playback.target_yaws))


def _prediction_to_truth_deg(subject: Subject) -> Array | None:
    if subject.user is None:
        return None
    return np.degrees(measures.yaw_errors(subject.playback.target_yaws, subject.user.root_yaws))


def _doubt_deg(subject: Subject) -> Array | None:
    doubt = subject.yardstick.doubt
    return None if doubt is None else np.degrees(doubt)


METRICS = (
    Metric(
        "root_error_cm",
        "root to its own target",
        "cm",
        "Hips on the ground to the target that the bake set itself, no true place of the hips",
        _to_target,
        group="own",
        floor=True,
        series=True,
        tables=("summary", "panel", "graph"),
        short="Body to its target",
        limit=15.0,
    ),
    Metric(
        "root_to_head_cm",
        "root error to the head",
        "cm",
        "Hips on the ground to the centre of the tracked head on the ground (the paper's target)",
        _to_head,
        group="trackers",
        floor=True,
    ),
    Metric(
        "matched_root_error_cm",
        "root error of the matched motion",
        "cm",
        "The same as the first, before the avatar was put under the headset: what alpha bounds",
        _matched_to_target,
        group="own",
        series=True,
    ),
    Metric(
        "yaw_error_deg",
        "yaw to its own prediction",
        "°",
        "Heading of the hips to the body orientation that was predicted, not to the true one",
        _yaw_to_prediction_deg,
        group="own",
        floor=True,
        series=True,
        tables=("summary", "panel", "graph"),
        short="Turn to its prediction",
        limit=12.0,
    ),
    Metric(
        "orientation_error_deg",
        "orientation error",
        "°",
        "Predicted body orientation to the heading of the true hips",
        _prediction_to_truth_deg,
        group="truth",
        series=True,
    ),
    Metric(
        "orientation_doubt_deg",
        "orientation doubt",
        "°",
        "Deviation that the predictor itself expects of the body orientation",
        _doubt_deg,
        group="own",
        series=True,
        tables=("panel",),
        short="Direction doubt",
        limit=15.0,
        worst=40.0,
    ),
)

"""How far predicted body yaws are from the truth (paper, section 6.4)."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core.database.virtual_root import virtual_root
from ..core.evaluation.true_estimate import true_estimate
from ..core.maths import angles
from ..core.measure.measures import yaw_errors
from ..core.mocap.take import Take
from ..core.recording.body_estimate import HEADSET, BodyEstimate
from ..core.recording.recording import Recording
from ..core.recording.simulate import lose_trackers, simulate_recording
from ..core.recording.targets import joint_targets
from .inputs import headings
from .part_errors import PARTS, part_errors, pooled
from .predictor import head_height, headset_forward, predict
from .weights import Predictor

Array = NDArray[np.floating[Any]]

HEURISTIC = "hands-and-head"
UNTRAINED = (HEADSET, HEURISTIC)
"""Names in reports that no trained predictor may have."""
POOL_RATE = 30.0
"""Errors of a second that count where takes are pooled, whatever their frame rate."""


def hands_and_head(recording: Recording) -> BodyEstimate:
    """A guess without training: half the headset's forward, half square to the line
    of the hands.

    The line counts by its length, up to shoulder width, and only while the hands are on their own sides of
    the view.
    """
    positions, rotations = joint_targets(recording)
    head = angles.direction(headings(rotations))
    line = (positions[:, 2] - positions[:, 1])[:, :2]
    ahead = np.stack([-line[:, 1], line[:, 0]], axis=-1) / np.maximum(
        np.linalg.norm(line, axis=-1, keepdims=True), 0.4
    )
    agrees = np.sum(ahead * head, axis=-1, keepdims=True) > 0.0
    return BodyEstimate(np.unwrap(angles.yaw_of(head + np.where(agrees, ahead, 0.0))))


def summary_deg(errors: Array, fps: float) -> dict[str, Any]:
    """Mean, deviation, 95th percentile, and the mean of each minute, in degrees, of errors `(T,)` in radians.

    The last minute may be a shorter one.
    """
    errors = np.degrees(errors)
    minute = max(1, round(60.0 * fps))
    return {
        "mean": float(np.mean(errors)),
        "std": float(np.std(errors)),
        "p95": float(np.percentile(errors, 95.0)),
        "per_minute": [float(np.mean(errors[i : i + minute])) for i in range(0, len(errors), minute)],
    }


def evaluate_predictors(
    takes: Sequence[Take], predictors: Mapping[str, Predictor], lost: Collection[str] = ()
) -> dict[str, Any]:
    """Errors of each predictor on trackers simulated from takes, beside the headset's forward and a
    heuristic.

    Args:
        takes: each is the user once; a second of any take weighs the same.
        predictors: by name.
        lost: "left", "right" or both: controllers that sleep all the time.

    Returns:
        `{"predictors": {name: {"mean", "std", "p95", "per_minute", "percentiles", "causal", "doubt", "parts"}},
        "takes": [{"take", "seconds", "predictors": {name: {"mean", "std", "p95", "per_minute"}}}]}`,
        degrees, ready for JSON. Under `predictors` the takes follow one another; `percentiles` are the 0th to
        the 100th; `doubt` is the mean deviation that the predictor itself expects, None where it has no notion of it;
        `parts` has the means of the figures in `part_errors.PARTS`, None for parts that it does not know.
    """
    ways: dict[str, Callable[[Recording], BodyEstimate]] = {
        HEADSET: headset_forward,
        HEURISTIC: hands_and_head,
    }
    for name, predictor in predictors.items():
        ways[name] = lambda recording, chosen=predictor: predict(chosen, recording)
    errors: dict[str, list[Array]] = {name: [] for name in ways}
    doubts: dict[str, list[Array]] = {name: [] for name in ways}
    parts: dict[str, list[dict[str, Array]]] = {name: [] for name in ways}
    table: list[dict[str, Any]] = []
    for take in takes:
        motion = take.motion
        recording = lose_trackers(simulate_recording(motion, take.name), lost)
        _, truth = virtual_root(motion)
        size = head_height(recording)
        body = true_estimate(motion, size)
        row: dict[str, Any] = {}
        for name, way in ways.items():
            found = way(recording)
            off = yaw_errors(found.yaws, truth)
            row[name] = summary_deg(off, motion.fps)
            # every take at the same rate, so that a fast camera does not count double
            frames = np.arange(0.0, len(off), motion.fps / POOL_RATE).astype(np.intp)
            errors[name].append(off[frames])
            parts[name].append({key: rows[frames] for key, rows in part_errors(found, body, size).items()})
            if found.doubt is not None:
                doubts[name].append(found.doubt[frames])
        table.append({"take": take.name, "seconds": len(motion) / motion.fps, "predictors": row})
    causal = {name: predictor.causal for name, predictor in predictors.items()}
    overall = {
        name: {
            **_pooled_deg(errors[name], doubts[name]),
            "parts": pooled(parts[name]),
            "causal": causal.get(name, True),
        }
        for name in ways
    }
    return {"predictors": overall, "takes": table}


def _pooled_deg(errors: list[Array], doubts: list[Array]) -> dict[str, Any]:
    """Figures in degrees of takes that follow one another, from errors and doubts `(T,)` in radians of each."""
    pooled = np.concatenate(errors)
    return {
        **summary_deg(pooled, POOL_RATE),
        "percentiles": np.percentile(np.degrees(pooled), np.arange(101)).tolist(),
        "doubt": float(np.degrees(np.mean(np.concatenate(doubts)))) if doubts else None,
    }


def errors_in_words(report: Mapping[str, Any]) -> list[str]:
    """The report of `evaluate_predictors` as a table for people, line by line."""
    lines = [f"{'degrees':24} {'mean':>7} {'std':>7} {'p95':>7} {'doubt':>7}  sees"]
    for name, row in report["predictors"].items():
        sees = "past" if row["causal"] else "past and future"
        doubt = "-" if row["doubt"] is None else f"{row['doubt']:.2f}"
        figures = " ".join(f"{row[key]:7.2f}" for key in ("mean", "std", "p95"))
        lines.append(f"{name:24} {figures} {doubt:>7}  {sees}")
    names = list(report["predictors"])
    lines += _parts_in_words(report["predictors"])
    lines.append("")
    lines.append(f"{'mean by take':40} " + " ".join(f"{name[:14]:>14}" for name in names))
    for take in report["takes"]:
        means = " ".join(f"{take['predictors'][name]['mean']:14.2f}" for name in names)
        lines.append(f"{take['take'][:40]:40} {means}")
    return lines


def _parts_in_words(predictors: Mapping[str, Any]) -> list[str]:
    """What those that know more than the direction make of it, a line each."""
    rows = {
        name: row["parts"]
        for name, row in predictors.items()
        if any(v is not None for v in row["parts"].values())
    }
    if not rows:
        return []
    lines = ["", f"{'parts':24} " + " ".join(f"{name:>14}" for name in PARTS)]
    for name, parts in rows.items():
        cells = ("-" if parts[key] is None else f"{parts[key]:.2f}" for key in PARTS)
        lines.append(f"{name:24} " + " ".join(f"{cell:>14}" for cell in cells))
    return lines

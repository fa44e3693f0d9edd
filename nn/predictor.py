"""The body estimate of a recording: the headset's forward alone, or what a trained predictor makes of it."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core.errors import InputError
from ..core.maths import angles, filters
from ..core.recording.body_estimate import BodyEstimate
from ..core.recording.recording import Recording
from ..core.recording.resample import resample
from ..core.recording.targets import joint_targets
from ..core.recording.windows import FACING, WindowLayout, mirror_inputs, stream, take_windows, window_inputs
from .inputs import (
    RATE,
    TRACKED,
    headings,
    sixd_to_yaw,
    tracker_inputs,
    turn_sixd,
    yaw_to_sixd,
)
from .network import product
from .parts import YAW, read_rows
from .weights import Predictor, read_predictor

Array = NDArray[np.floating[Any]]

SHIPPED = ("causal", "look-ahead", "paper")
"""Names of the predictors that come with Footwork."""
_FOLDER = Path(__file__).parent / "weights"
_CHUNK = 2048
"""Windows worked on at once: bounds memory on recordings of hours."""
_ASKED = 15.0
"""Answers per second of predictors that see the future; bodies turn slowly, so those between are
interpolated."""


def load_predictor(path: str | os.PathLike[str]) -> Predictor:
    """Read a predictor's `.npz`; InputError with one line on any fault of the file."""
    return read_predictor(path)


def shipped_predictor(name: str = "look-ahead") -> Predictor:
    """A predictor that comes with Footwork: "look-ahead" (for bakes), "causal" or "paper"."""
    return read_predictor(_FOLDER / f"{name}.npz")


def shipped_predictors() -> dict[str, Predictor]:
    """All predictors that come with Footwork, by name."""
    return {name: shipped_predictor(name) for name in SHIPPED}


def headset_forward(recording: Recording) -> BodyEstimate:
    """The yaw of the headset's forward projected on the ground, which knows of no doubt."""
    _, rotations = joint_targets(recording)
    return BodyEstimate(np.unwrap(headings(rotations)))


def head_height(recording: Recording) -> float:
    """Height of the head joint when the wearer stands upright, metres."""
    return recording.eye_height - float(recording.mounts.offsets[0, 2])


def predict(predictor: Predictor, recording: Recording) -> BodyEstimate:
    """The body at the frames of an evenly spaced recording: every part that the predictor knows, with its own doubt.

    Raises:
        InputError: its weights make answers that are not finite.
    """
    found = _predict(predictor, recording)
    if not is_finite(found):
        raise InputError(f"predictor {predictor.name}: its answers are not finite; train or copy it again")
    return found


def is_finite(estimate: BodyEstimate) -> bool:
    """Whether all numbers of an estimate are."""
    arrays = [estimate.yaws, estimate.standing]
    for part in (estimate.hips, estimate.feet, estimate.chest, estimate.elbows):
        arrays += [] if part is None else [part.mean, part.spread]
    return all(array is None or bool(np.isfinite(array).all()) for array in arrays)


def _predict(predictor: Predictor, recording: Recording) -> BodyEstimate:
    if predictor.layout is None:
        return _predict_recurrent(predictor, recording)
    positions, rotations = joint_targets(recording)
    rows = stream(positions, rotations, recording.valid, head_height(recording))
    return run_windows(predictor, predictor.layout, rows, recording.fps)


def _predict_recurrent(predictor: Predictor, recording: Recording) -> BodyEstimate:
    even = resample(recording, RATE)
    positions, rotations = joint_targets(even)
    yaws = np.interp(recording.times, even.times, run_recurrent(predictor, positions, rotations))
    # this network has no notion of its certainty: its error on held-out takes stands for it
    expected = float(predictor.provenance.get("held_out_error_deg", 15.0))
    return BodyEstimate(yaws, np.full(len(yaws), np.radians(expected)))


def run_recurrent(
    predictor: Predictor, positions: Array, rotations: Array, start: float | None = None
) -> Array:
    """The paper's loop at `RATE`: each answer is re-expressed in the next frame's axes and fed back.

    Args:
        predictor: with the paper's 42 inputs.
        positions: `(T, 3, 3)` world positions of head, left and right hand, metres.
        rotations: `(T, 3, 4)` their world rotations since T-pose.
        start: world yaw in radians to begin with; the headset's forward where None.

    Returns:
        `(T,)` world yaws in radians, continuous over time.
    """
    network, scaler = predictor.networks[0], predictor.scaler
    head = headings(rotations)
    tracked = (tracker_inputs(positions, rotations, RATE) - scaler.mean[:TRACKED]) / scaler.deviation[
        :TRACKED
    ]
    weight = network.weights[0]
    first = product(tracked.astype(np.float32), weight[:TRACKED]) + network.biases[0]
    mean = scaler.mean[TRACKED:].astype(np.float32)
    deviation = scaler.deviation[TRACKED:].astype(np.float32)
    steps = np.diff(head, prepend=head[0])
    answers = np.empty((len(head), 6), dtype=np.float32)
    answer = yaw_to_sixd(0.0 if start is None else start - head[0]).astype(np.float32)
    for t in range(len(head)):
        previous = turn_sixd(answer, -steps[t])
        answer = network.finish(first[t] + ((previous - mean) / deviation) @ weight[TRACKED:])
        answer = answer * deviation + mean
        answers[t] = answer
    return np.unwrap(head + sixd_to_yaw(answers.astype(np.float64)))


def run_windows(
    predictor: Predictor, layout: WindowLayout, rows: NDArray[np.float32], fps: float
) -> BodyEstimate:
    """A window network's answers for every frame of a stream `(T, 31)` (see `windows.stream`).

    Each answer begins with a vector: its direction the yaw, its length, at most about 1, the certainty. Networks
    vote by their sum, and smoothing in world space lets certain moments carry doubtful ones. The other parts are
    carried between answers in the world's axes, too, and seen from the body's in the end.
    """
    frames = np.arange(len(rows))
    asked = frames if predictor.causal else np.union1d(frames[:: max(1, int(fps / _ASKED))], frames[-1:])
    head = angles.yaw_of(rows[asked, FACING].astype(np.float64))
    answers = [
        answer_windows(
            predictor,
            layout,
            take_windows(rows, asked[low : low + _CHUNK] / fps, fps, layout),
            head[low : low + _CHUNK],
        )
        for low in range(0, len(asked), _CHUNK)
    ]
    found = predictor.outputs.turned(np.concatenate(answers), head)
    vectors = np.stack([np.interp(frames, asked, found[:, axis]) for axis in range(2)], axis=-1)
    if predictor.causal:
        vectors = _lagging(vectors, predictor.smoothing * fps)
    else:
        vectors = filters.gaussian(vectors, predictor.smoothing * fps)
    certainty = np.clip(np.linalg.norm(vectors, axis=-1), 0.05, 0.999)
    # deviation of a wrapped normal distribution whose mean vector has this length
    yaws, doubt = np.unwrap(angles.yaw_of(vectors)), np.sqrt(-2.0 * np.log(certainty))
    if predictor.parts == (YAW,):
        return BodyEstimate(yaws, doubt)
    rows = found if len(asked) == len(frames) else _between(asked, found, frames)
    return read_rows(predictor.outputs, predictor.outputs.turned(rows, -yaws), yaws, doubt)


def _between(asked: NDArray[np.intp], rows: Array, frames: NDArray[np.intp]) -> Array:
    """Rows `(N, D)` at the frames `asked`, carried to all frames by cubic Hermite polynomials.

    Feet swing too fast for straight lines between answers.
    """
    if len(asked) < 3:
        columns: list[Array] = [np.interp(frames, asked, rows[:, n]) for n in range(rows.shape[1])]
        return np.stack(columns, axis=-1)
    slopes = np.gradient(rows, asked, axis=0)
    low = np.minimum(np.searchsorted(asked, frames, side="right") - 1, len(asked) - 2)
    width = (asked[low + 1] - asked[low])[:, None]
    t = (frames - asked[low])[:, None] / width
    first, second = rows[low], rows[low + 1]
    ease = t * t * (3.0 - 2.0 * t)
    bend = t * (1.0 - t) * width
    return first + ease * (second - first) + bend * ((1.0 - t) * slopes[low] - t * slopes[low + 1])


def answer_windows(
    predictor: Predictor, layout: WindowLayout, windows: NDArray[np.float32], frame_yaws: Array
) -> Array:
    """The mean answer `(N, D)` in axes turned to `frame_yaws`, of the predictor's networks (see `parts.Outputs`).

    Each is asked twice, about the window and about its mirror image, so that none prefers a side.
    """
    inputs = window_inputs(windows, frame_yaws, layout)
    pair = [predictor.scaler.apply(x).astype(np.float32) for x in (inputs, mirror_inputs(inputs, layout))]
    mirrored = predictor.outputs.mirrored
    answers = [
        network.forward(pair[0]) + mirrored(network.forward(pair[1])) for network in predictor.networks
    ]
    return 0.5 * np.mean(answers, axis=0)


def _lagging(vectors: Array, frames: float) -> Array:
    """Exponential smoothing over `frames` that starts settled."""
    if frames <= 0.0:
        return vectors
    keep = np.exp(-1.0 / frames)
    out = np.array(vectors)
    for t in range(1, len(out)):
        out[t] = keep * out[t - 1] + (1.0 - keep) * vectors[t]
    return out

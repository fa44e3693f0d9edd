"""What was played from the databases, and how smooth it came out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..database.motion_database import POSE, MotionDatabase
from ..matching.playback import Playback
from . import measures
from .measures import Array
from .metric import Metric
from .subject import Subject


def _jitter(subject: Subject) -> Array:
    return measures.jitter(subject.body.positions, subject.body.fps)


def _transitions(subject: Subject) -> Array:
    changes = np.zeros(max(len(subject.playback) - 1, 1))
    changes[subject.playback.transitions - 1] = subject.body.fps
    return changes


def _jumps(subject: Subject) -> Array:
    return pose_jumps(subject.playback, subject.yardstick.databases)


def pose_jumps(playback: Playback, databases: Sequence[MotionDatabase]) -> Array:
    """How far each transition's pose features are from those that would have followed: `(K,)`, normalised.

    Both are measured by the new frame's database, in which every group of features has the deviation 1.
    """
    out = np.empty(len(playback.transitions))
    for i, at in enumerate(playback.transitions.tolist()):
        new = databases[int(playback.database[at])].features
        old = databases[int(playback.database[at - 1])].features
        left = old.values[playback.frame[at - 1] + 1] * old.deviation + old.mean
        jump = new.values[playback.frame[at]] - (left - new.mean) / new.deviation
        out[i] = np.linalg.norm(jump[POSE])
    return out


def _poses(subject: Subject) -> Array:
    """Database and frame `(N, 2)`, each that was played once."""
    played = np.stack([subject.playback.database, subject.playback.frame], axis=-1)
    return np.unique(played, axis=0).astype(np.float64)


def _clamped(subject: Subject) -> Array:
    return subject.playback.clamped.astype(np.float64)


METRICS = (
    Metric(
        "jitter", "jitter", "m/s³", "Third derivative of joint positions", _jitter, kind="number", floor=True
    ),
    Metric(
        "transitions_per_s",
        "transitions",
        "1/s",
        "Changes of place in the databases per second",
        _transitions,
        group="played",
        kind="number",
        series=True,
        tables=("panel",),
    ),
    Metric(
        "pose_jump",
        "pose jump",
        "",
        "Pose features of a transition against what would have followed, normalised",
        _jumps,
        group="played",
    ),
    Metric(
        "poses_used",
        "poses used",
        "",
        "Different frames of the databases",
        _poses,
        group="played",
        kind="count",
        better="",
        tables=("panel",),
    ),
    Metric(
        "clamped_fraction",
        "held at alpha",
        "",
        "Share of frames in which the root was held at alpha",
        _clamped,
        group="played",
        kind="share",
        series=True,
        tables=("panel",),
        short="At distance limit",
    ),
)

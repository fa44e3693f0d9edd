"""Legs: when they step, how they bend, how near and how smooth they are; beside the user's where those are known."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from ..body.skeleton import SIDES
from ..database.contacts import find_contacts
from . import gait, limbs, measures
from .measures import Array, Flags
from .metric import Metric
from .subject import CONTACT_M_S, Body, Subject

SHINS_M = 0.09
"""Shins that are nearer than this lie in each other: a calf is about as thick."""


def joints(body: Body, parts: Sequence[str]) -> Array:
    """Positions `(T, 2, P, 3)` of these parts of the left and the right limb, metres."""
    indices = [[body.skeleton.joint(f"{part}.{side}") for part in parts] for side in SIDES]
    return body.positions[:, indices]


def ankles(body: Body) -> Array:
    """Ankles `(T, 2, 3)`, left and right, metres."""
    return joints(body, ("foot",))[:, :, 0]


def knee_bends(body: Body) -> Array:
    """Angle `(T, 2)` in radians between thigh and shin of the left and the right leg, 0 when straight."""
    leg = joints(body, ("thigh", "shin", "foot"))
    return limbs.bends(leg[:, :, 0], leg[:, :, 1], leg[:, :, 2])


def plants(subject: Subject) -> Flags:
    """Frames `(T, 2)` at which this body's feet come to stand after a step, by its toes alone."""
    body = subject.body
    stands = find_contacts(subject.toes, body.fps, CONTACT_M_S * body.size)
    return gait.plants(subject.toes, stands, gait.PLANT_M * body.size)


def _in_phase(subject: Subject) -> Array | None:
    user = subject.user
    if user is None:
        return None
    found = gait.phase_correlations(
        ankles(subject.body), ankles(user), user.root_positions, user.root_yaws, user.fps, user.size
    )
    return gait.agreeing(found)


def _knees_deg(subject: Subject, signed: bool) -> Array | None:
    if subject.user is None:
        return None
    apart = np.degrees(knee_bends(subject.body) - knee_bends(subject.user))
    return apart if signed else np.abs(apart)


def _crossed(subject: Subject) -> Array:
    shin = joints(subject.body, ("shin", "foot"))
    gaps = limbs.segment_gaps(shin[:, 0, 0], shin[:, 0, 1], shin[:, 1, 0], shin[:, 1, 1])
    return (gaps < SHINS_M * subject.body.size).astype(np.float64)


def _shin_jerk(subject: Subject) -> Array:
    points = joints(subject.body, ("shin", "foot")).reshape(len(subject.body), 4, 3)
    return measures.jitter(points, subject.body.fps)


def _invented(subject: Subject) -> Array | None:
    if subject.true is None:
        return None
    tolerance = round(gait.PLANT_TOLERANCE_S * subject.body.fps)
    return _per_minute(gait.unmatched(plants(subject), plants(subject.true), tolerance), subject.body.fps)


def _while_resting(subject: Subject) -> Array:
    heads = subject.devices[0][:, 0, :2]
    rests = gait.resting(heads, subject.body.fps, subject.body.size) & subject.tracked[:, 0]
    return measures.counted(_per_minute(plants(subject), subject.body.fps), rests)


def _per_minute(events: Flags, fps: float) -> Array:
    """Values `(T,)` whose mean is how many of the events `(T, 2)` there are in a minute."""
    return events.sum(axis=1) * (60.0 * fps)


METRICS = (
    Metric(
        "phase_agreement",
        "steps in phase",
        "",
        "Share of the windows of 0.8 s in which the user walks whose ankles correlate above 0.5 with the true ones",
        _in_phase,
        group="truth",
        kind="share",
        better="higher",
        tables=("summary", "panel"),
        limit=0.7,
    ),
    Metric(
        "invented_steps_per_min",
        "invented steps",
        "1/min",
        "Plants of a foot that the user's same foot does not make within 0.25 s",
        _invented,
        group="truth",
        kind="number",
        series=True,
        tables=("summary",),
    ),
    Metric(
        "knee_error_deg",
        "knee bend error",
        "°",
        "Angle between thigh and shin to the true one",
        partial(_knees_deg, signed=False),
        group="truth",
    ),
    Metric(
        "knee_bias_deg",
        "knee bend bias",
        "°",
        "Angle between thigh and shin minus the true one: above 0 the knees are bent more than the user's",
        partial(_knees_deg, signed=True),
        group="truth",
        better="zero",
        tables=("summary",),
    ),
    Metric(
        "crossed_shins_frames",
        "crossed shins",
        "frames",
        "Frames in which the shins are nearer to each other than 9 cm (of a body with legs of 0.85 m)",
        _crossed,
        kind="total",
        floor=True,
        tables=("summary", "panel"),
        limit=0.0,
    ),
    Metric(
        "shin_jerk_m_s3",
        "jerk of the shins",
        "m/s³",
        "Third derivative of the positions of knees and ankles",
        _shin_jerk,
        floor=True,
        series=True,
        tables=("summary", "panel", "graph"),
        short="Leg jerk",
        limit=500.0,
        worst=2000.0,
        near_truth=True,
    ),
    Metric(
        "resting_steps_per_min",
        "steps while the head rests",
        "1/min",
        "Plants in frames in which the head gets on by less than 0.15 m/s over the second around, per minute of these",
        _while_resting,
        kind="number",
        floor=True,
        tables=("summary", "panel"),
        short="Steps at rest",
        limit=10.0,
    ),
)

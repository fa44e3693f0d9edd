"""Skating by its four definitions, floating, sinking, and depth below the floor."""

from __future__ import annotations

import numpy as np

from ..body.toes import toe_places
from . import measures
from .measures import CM, Array, counted
from .metric import Metric
from .subject import Subject


def _skate(subject: Subject) -> Array:
    return measures.contact_speeds(subject.toes, subject.contacts, subject.body.fps) * CM


def _in_true_contacts(subject: Subject) -> Array | None:
    true = subject.true or (subject if subject.is_true else None)
    return None if true is None else _in_contacts(subject, true)


def _in_contacts(subject: Subject, true: Subject) -> Array:
    return measures.contact_speeds(subject.toes, true.contacts, subject.body.fps) * CM


def _nsm_skate(subject: Subject) -> Array:
    limit = measures.NSM_HEIGHT_M * subject.body.size
    return measures.nsm_skate(subject.toes, subject.toe_heights, subject.body.fps, limit) * CM


def _skating(subject: Subject) -> Array:
    body = subject.body
    return measures.skating(subject.toes, subject.toe_heights, body.fps, body.size).astype(np.float64)


def _slides(subject: Subject) -> Array:
    return measures.slides(subject.toes, subject.contacts) * CM


def _floating(subject: Subject) -> Array:
    return counted(np.maximum(subject.toe_heights, 0.0) * CM, subject.contacts)


def _sinking(subject: Subject) -> Array:
    return counted(np.maximum(-subject.toe_heights, 0.0) * CM, subject.contacts)


def _penetration(subject: Subject) -> Array:
    skeleton = subject.body.skeleton
    joints, offsets = toe_places(skeleton)
    rest = skeleton.tpose_positions()[joints]
    # a point below the floor in T-pose, inside the shoe's sole, is measured from there
    depths = [
        np.minimum((rest + ends)[:, 2], 0.0) - subject.heights(subject.body.points(joints, ends))
        for ends in (offsets, skeleton.tips[joints])
    ]
    return np.maximum(np.maximum(*depths), 0.0) * CM


METRICS = (
    Metric(
        "true_contact_skate_cm_s",
        "foot skate in the true contacts",
        "cm/s",
        "Horizontal speed of toes while the user's own toe stands",
        _in_true_contacts,
        group="truth",
        floor=True,
        series=True,
        tables=("summary",),
        near_truth=True,
    ),
    Metric(
        "nsm_skate_cm_s",
        "foot skate by height",
        "cm/s",
        "v (2 - 2^(h / 2.5 cm)) of both toes over all frames, 0 above 2.5 cm",
        _nsm_skate,
        floor=True,
        series=True,
        tables=("summary", "panel", "graph"),
        short="Foot skate",
        limit=20.0,
        worst=60.0,
        near_truth=True,
    ),
    Metric(
        "skating_ratio",
        "skating ratio",
        "",
        "Share of frames in which a toe below 5 cm is faster than 50 cm/s",
        _skating,
        kind="share",
        floor=True,
    ),
    Metric(
        "foot_skate_cm_s",
        "foot skate in its own contacts",
        "cm/s",
        "Horizontal speed of toes while the matched motion says that they stand, whether or not the user does",
        _skate,
        group="own",
        floor=True,
        series=True,
        tables=("summary",),
        limit=3.0,
    ),
    Metric(
        "slide_per_contact_cm",
        "slide in a contact",
        "cm",
        "Way of the toe over the ground from the start of a contact to its end",
        _slides,
        group="own",
        floor=True,
    ),
    Metric(
        "floating_cm",
        "floating",
        "cm",
        "Height of toes in contact above where they are in T-pose",
        _floating,
        group="own",
        floor=True,
    ),
    Metric(
        "sinking_cm",
        "sinking",
        "cm",
        "Depth of toes in contact below where they are in T-pose",
        _sinking,
        group="own",
        floor=True,
    ),
    Metric(
        "penetration_cm",
        "below the floor",
        "cm",
        "Depth of the lower of toe and toe tip, all frames",
        _penetration,
        floor=True,
        series=True,
        tables=("summary", "panel"),
        limit=0.5,
    ),
)

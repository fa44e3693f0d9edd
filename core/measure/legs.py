"""The legs beside the user's: whether they step when the user does."""

from __future__ import annotations

from ..body.skeleton import SIDES
from . import gait
from .measures import Array
from .metric import Metric
from .subject import Body, Subject


def ankles(body: Body) -> Array:
    """Ankles `(T, 2, 3)`, left and right, metres."""
    return body.positions[:, [body.skeleton.joint(f"foot.{side}") for side in SIDES]]


def _in_phase(subject: Subject) -> Array | None:
    user = subject.user
    if user is None:
        return None
    found = gait.phase_correlations(
        ankles(subject.body), ankles(user), user.root_positions, user.root_yaws, user.fps, user.size
    )
    return gait.agreeing(found)


METRICS = (
    Metric(
        "phase_agreement",
        "steps in phase",
        "",
        "Share of the windows of 0.8 s in which the user walks whose ankles correlate above 0.5 with the true ones",
        _in_phase,
        kind="share",
        better="higher",
    ),
)

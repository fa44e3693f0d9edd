"""Which stretches of a take are fit to learn body orientation from.

Inertial suits drift: head and hips headings part slowly, as no person's do. Splices, single-frame glitches
and the T-pose that many files start with are no motion either. What is left out is said, one line each.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core.maths import angles, quat
from ..core.mocap.skeleton import Motion, Take
from ..core.recording.recording import TRACKER_ROLES

Array = NDArray[np.floating[Any]]

DRIFT = np.radians(30.0)
"""A sixth of a take whose median head-to-hips heading is beyond this has drifted; of sound takes none is
beyond 22."""
DRIFT_SPAN_S = 45.0
"""Takes shorter than this have no time to drift; their sixths are single gestures."""
SIXTHS = 6
SHORTEST_S = 2.0
SPEED = 15.0
"""Metres per second that neither hips, head nor hands of a person reach."""
SPIN = np.radians(1800.0)
"""Radians per second that neither hips nor head reach."""
START_S = 0.1
"""What comes before a jump this early is the T-pose that many files start with."""


@dataclass(frozen=True, slots=True)
class Curated:
    """The fit stretches of a take and what was cut."""

    stretches: tuple[tuple[int, int], ...]
    """First frame and the frame past the last of each."""
    notes: tuple[str, ...]


def curate(take: Take) -> Curated:
    """Find the stretches of a take that a predictor may learn from."""
    motion = take.motion
    good = np.ones(len(motion), dtype=bool)
    notes: list[str] = []
    jumps = find_jumps(motion)
    good[jumps] = False
    early = jumps[jumps <= START_S * motion.fps]
    if len(early):
        good[: early[-1] + 1] = False
        notes.append(
            f"{take.name}: the first {early[-1] + 1} frame(s) are cut, the take jumps away from them"
        )
    if len(jumps) > len(early):
        first = jumps[len(early)]
        notes.append(
            f"{take.name}: cut at {len(jumps) - len(early)} glitch or splice frame(s), the first is {first}"
        )
    drift = find_drift(motion)
    if drift is not None:
        good[drift[0] :] = False
        notes.append(
            f"{take.name}: left out from frame {drift[0]} on, "
            f"head and hips headings drift apart to {np.degrees(drift[1]):.0f} degrees"
        )
    edges = np.flatnonzero(np.diff(np.concatenate([[False], good, [False]]).astype(np.int8)))
    stretches = [
        (int(a), int(b))
        for a, b in zip(edges[::2], edges[1::2], strict=True)
        if b - a >= SHORTEST_S * motion.fps
    ]
    return Curated(tuple(stretches), tuple(notes))


def find_jumps(motion: Motion) -> NDArray[np.intp]:
    """Frames after which the hips, the head or a hand are somewhere else at once."""
    positions, rotations = motion.forward()
    joints = [0, *(motion.skeleton.joint(role) for role in TRACKER_ROLES)]
    dot = np.abs(np.sum(rotations[1:, joints[:2]] * rotations[:-1, joints[:2]], axis=-1))
    turn = np.max(2.0 * np.arccos(np.clip(dot, 0.0, 1.0)), axis=-1)
    step = np.max(np.linalg.norm(np.diff(positions[:, joints], axis=0), axis=-1), axis=-1)
    # a splice is one frame long at any rate, so fast capture does not lower the bar in full
    seconds = max(1.0 / motion.fps, 1.0 / 60.0)
    return np.flatnonzero((step > SPEED * seconds) | (turn > SPIN * seconds))


def head_to_hips(motion: Motion) -> Array:
    """Heading of the head over that of the hips, `(T,)` radians in [-pi, pi)."""
    _, rotations = motion.forward()
    head = motion.skeleton.joint("head")
    return angles.wrap(quat.heading(rotations[:, head]) - quat.heading(rotations[:, 0]))


def find_drift(motion: Motion) -> tuple[int, float] | None:
    """The first frame of the first drifted sixth and the worst median angle in radians, or None.

    Drift does not heal by itself: what follows is not to be trusted either.
    """
    if len(motion) < DRIFT_SPAN_S * motion.fps:
        return None
    parting = head_to_hips(motion)
    borders = np.linspace(0, len(motion), SIXTHS + 1).astype(int)
    medians = np.array([circular_median(parting[a:b]) for a, b in itertools.pairwise(borders)])
    beyond = np.flatnonzero(np.abs(medians) > DRIFT)
    if len(beyond) == 0:
        return None
    return int(borders[beyond[0]]), float(medians[np.argmax(np.abs(medians))])


def circular_median(angle: Array) -> float:
    """The median of angles in radians about their mean direction."""
    mean = np.arctan2(np.mean(np.sin(angle)), np.mean(np.cos(angle)))
    return float(angles.wrap(mean + np.median(angles.wrap(angle - mean))))

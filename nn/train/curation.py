"""Which stretches of a take are fit to learn body orientation from.

Inertial suits drift: head and hips headings part slowly, as no person's do. Splices and single-frame glitches
are no motion either. What is left out is said, one line each.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from ...core.body.motion import Motion
from ...core.mocap import checks
from ...core.mocap.take import Take

SHORTEST_S = 2.0
"""Shorter stretches teach nothing about time."""


@dataclass(frozen=True, slots=True)
class Curated:
    """The fit stretches of a take and what was cut."""

    stretches: tuple[tuple[int, int], ...]
    """First frame and the frame past the last of each."""
    notes: tuple[str, ...]


def curate(take: Take) -> Curated:
    """Find the stretches of a take that a predictor may learn from."""
    motion = take.motion
    notes: list[str] = []
    last = len(motion)
    drift = find_drift(motion)
    if drift is not None:
        last, worst = drift
        notes.append(
            f"{take.name}: left out from frame {last} on, "
            f"head and hips headings drift apart to {np.degrees(worst):.0f} degrees"
        )
    jumps = np.union1d(checks.arm_jumps(motion), checks.hips_jumps(motion))
    jumps = jumps[jumps < last]
    if len(jumps):
        notes.append(f"{take.name}: cut at {len(jumps)} jump(s), the first to frame {jumps[0]}")
    borders = [0, *(int(jump) for jump in jumps), last]
    stretches = [(a, b) for a, b in itertools.pairwise(borders) if b - a >= SHORTEST_S * motion.fps]
    return Curated(tuple(stretches), tuple(notes))


def find_drift(motion: Motion) -> tuple[int, float] | None:
    """The frame from which a take has drifted and the worst parting of its sixths in radians, or None.

    Drift does not heal by itself: what follows the first drifted sixth is not to be trusted either.
    """
    parts = checks.heading_parts(motion)
    if parts is None:
        return None
    beyond = np.flatnonzero(checks.drifted(parts))
    if len(beyond) == 0:
        return None
    starts = np.cumsum([0, *(len(part) for part in np.array_split(np.arange(len(motion)), len(parts)))])
    return int(starts[beyond[0]]), float(parts[np.argmax(np.abs(parts))])

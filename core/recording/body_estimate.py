"""What the trackers tell of the whole body, and how sure that is.

All parts but the yaw are seen in the body's own axes: X right, Y forward, Z up, turned by the yaw. Lengths are shares
of the head joint's height when the wearer stands upright, so that they hold for bodies of any size.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .recording import Array

HEADSET = "headset"
"""What reports and options call the headset's forward, taken for where the body faces."""
DOUBTFUL = np.radians(25.0)
"""Expected deviation from which on an answer is to be looked at; with both controllers lost it is 25 to 28 degrees,
with one 13 to 21, with all there 10 to 16."""
_SHORTEST_S = 1.0
"""Seconds in doubt that are worth a word."""


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """What is known of one part of the body over time."""

    mean: Array
    """`(T, ..., n)` the most likely vectors."""
    spread: Array
    """`(T, ...)` expected deviation from them, in the same unit for each of the `n` directions."""


@dataclass(frozen=True, slots=True, eq=False)
class BodyEstimate:
    """Where the body faces, and what else a predictor knows of it; parts that it does not know are None."""

    yaws: Array
    """`(T,)` world yaw in radians, continuous over time."""
    doubt: Array | None = None
    """`(T,)` radians: the deviation that the predictor itself expects of its yaws; None where it has no notion
    of that."""
    hips: Part | None = None
    """`(T, 3)` from the point on the floor under the head joint to the hips, so the third is their height."""
    feet: Part | None = None
    """`(T, 2, 2, 3)` from the hips to ankle and toe of the left and the right foot."""
    standing: Array | None = None
    """`(T, 2)` how likely the left and the right foot stand on the floor, 0 to 1."""
    chest: Part | None = None
    """`(T, 3)` rotation vectors of the chest since T-pose in the body's axes, radians."""
    elbows: Part | None = None
    """`(T, 2, 3)` unit vectors from the left and the right hand joint to the elbow."""


def estimate_doubts(estimate: BodyEstimate, fps: float) -> tuple[str, ...]:
    """One line where the body's direction is doubtful for a second or longer, else none."""
    if estimate.doubt is None:
        return ()
    doubtful: NDArray[np.intp] = np.flatnonzero(estimate.doubt > DOUBTFUL)
    if len(doubtful) < _SHORTEST_S * fps:
        return ()
    return (
        f"body direction doubtful for {len(doubtful) / fps:.1f} of {len(estimate.yaws) / fps:.1f} s, first at "
        f"{doubtful[0] / fps:.1f} s: the predictor expects to be {np.degrees(DOUBTFUL):.0f} degrees off or more there",
    )

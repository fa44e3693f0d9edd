"""Where the body of a recording faces, and how sure that is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .recording import Array

HEADSET = "headset"
"""What reports and options call the headset's forward, taken for where the body faces."""
DOUBTFUL = np.radians(25.0)
"""Expected deviation from which on an answer is to be looked at; with both controllers lost it is 27 to 31 degrees,
with one 15, with all there 10."""
_SHORTEST_S = 1.0
"""Seconds in doubt that are worth a word."""


@dataclass(frozen=True, slots=True, eq=False)
class Orientation:
    """Where the body faces and how sure that is."""

    yaws: Array
    """`(T,)` world yaw in radians, continuous over time."""
    doubt: Array | None
    """`(T,)` radians: the deviation that the predictor itself expects of its answer; None where it has no notion
    of that."""


def orientation_doubts(orientation: Orientation, fps: float) -> tuple[str, ...]:
    """One line where the body's direction is doubtful for a second or longer, else none."""
    if orientation.doubt is None:
        return ()
    doubtful: NDArray[np.intp] = np.flatnonzero(orientation.doubt > DOUBTFUL)
    if len(doubtful) < _SHORTEST_S * fps:
        return ()
    return (
        f"body direction doubtful for {len(doubtful) / fps:.1f} of {len(orientation.yaws) / fps:.1f} s, first at "
        f"{doubtful[0] / fps:.1f} s: the predictor expects to be {np.degrees(DOUBTFUL):.0f} degrees off or more there",
    )

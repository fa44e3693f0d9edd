"""What is known of a body beside the motion that was matched for it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """Parts are None where nothing is known of them; there the motion has its way."""

    roots: Array | None = None
    """`(T, 2)` where on the ground the hips should be, metres."""
    chest: Array | None = None
    """`(T, 4)` rotation of the chest since T-pose in the world."""
    elbows: Array | None = None
    """`(T, 2, 3)` unit vectors from the left and the right hand joint to the elbow in the world."""
    soles: Array | None = None
    """`(T, 2)` pitch in radians at which the motion's left and right foot stand flat."""

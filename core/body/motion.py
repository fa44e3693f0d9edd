"""A skeleton's movement over time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import forward_kinematics as fk
from .skeleton import Skeleton

Array = NDArray[np.floating[Any]]


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """A skeleton's movement at a fixed rate."""

    skeleton: Skeleton
    fps: float
    positions: Array
    """`(T, 3)` hips in the world, metres."""
    rotations: Array
    """`(T, J, 4)` local rotations since T-pose; the hips' is global; sign-continuous over time."""

    def __len__(self) -> int:
        return len(self.positions)

    def forward(self) -> tuple[Array, Array]:
        """World joint positions `(T, J, 3)` in metres and rotations since T-pose `(T, J, 4)`."""
        return fk.forward(self.positions, self.rotations, self.skeleton.offsets, self.skeleton.parents)

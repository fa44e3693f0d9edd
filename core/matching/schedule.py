"""What a search decides: which frames play from when on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Frames = NDArray[np.intp]


@dataclass(frozen=True, slots=True, eq=False)
class Schedule:
    """What is played from when on: the database at each time is the wanted one."""

    times: Frames
    """`(K,)` frames of the recording at which was searched, ascending, the first 0."""
    frames: Frames
    """`(K,)` frames of the database played from there; up to the next time what follows must stay in one clip."""
    changes: NDArray[np.bool_]
    """`(K,)` whether something else plays than what would have followed."""

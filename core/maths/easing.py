"""Curves from 0 to 1 that start and end smoothly."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]


def smoothstep(t: Array) -> Array:
    """3 t^2 - 2 t^3 for `t` `(...)` in [0, 1]: no velocity at the ends."""
    return t * t * (3.0 - 2.0 * t)


def smootherstep(t: Array) -> Array:
    """6 t^5 - 15 t^4 + 10 t^3 for `t` `(...)` in [0, 1]: no velocity and no acceleration at the ends (Perlin 2002)."""
    return t**3 * (10.0 - 15.0 * t + 6.0 * t**2)

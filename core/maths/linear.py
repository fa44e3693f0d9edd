"""Linear equations whose solution is the same to the last bit on any number of threads."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]


def solve(matrix: Array, right: Array) -> Array:
    """Solution `(n, m)` of `matrix @ x = right` by elimination without pivots.

    `numpy.linalg.solve` shares large matrices out among threads, and then rounds by their number.

    Args:
        matrix: `(n, n)` symmetric and positive definite.
        right: `(n, m)`.
    """
    size = len(matrix)
    rows: Array = np.concatenate([matrix, right], axis=1)
    for n in range(size):
        rows[n] /= rows[n, n]
        others = rows[:, n].copy()
        others[n] = 0.0
        rows[:, n:] -= others[:, None] * rows[n, n:]
    return rows[:, size:]

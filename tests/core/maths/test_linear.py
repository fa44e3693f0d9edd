from __future__ import annotations

import numpy as np
import pytest
from footwork.core.maths.linear import solve


@pytest.mark.parametrize("size", [1, 2, 37, 150])
def test_it_solves_as_numpy_does(size):
    rng = np.random.default_rng(size)
    rows = rng.normal(size=(3 * size, size)) * np.logspace(0, -2, size)
    matrix = rows.T @ rows / len(rows) + 1e-6 * np.eye(size)
    right = rng.normal(size=(size, 2))
    given = matrix.copy()
    np.testing.assert_allclose(solve(matrix, right), np.linalg.solve(matrix, right), rtol=1e-7, atol=1e-9)
    np.testing.assert_array_equal(matrix, given)

"""The same numbers give the same bits wherever they lie in memory."""

from __future__ import annotations

import numpy as np
import pytest
from footwork.core.maths import angles, filters, quat

COUNT = 700
WALKS = [
    pytest.param(lambda w: angles.arctan2(w[:, 2], w[:, 1]), id="arctan2"),
    pytest.param(angles.yaw_of, id="yaw_of"),
    pytest.param(lambda w: filters.gaussian(w, 3.0), id="gaussian"),
    pytest.param(lambda w: filters.gaussian(w[:, 0], 3.0), id="gaussian of one column"),
    pytest.param(lambda w: filters.savitzky_golay(w, 9), id="savitzky_golay"),
    pytest.param(
        lambda w: quat.to_rotation_vector(quat.normalize(np.insert(w, 0, 0.4, 1))), id="quaternions"
    ),
]


@pytest.mark.parametrize("made", WALKS)
def test_the_place_in_memory_does_not_change_a_bit(made) -> None:
    rng = np.random.default_rng(6)
    numbers = rng.standard_normal((COUNT, 3))
    once = made(numbers)
    kept = []
    for _ in range(60):
        # pushes the arrays that are made next to other places
        kept.append([np.empty(int(size)) for size in rng.integers(1, 9000, 5)])
        del kept[: int(rng.integers(0, 2))]
        room = np.empty(numbers.nbytes + 256, dtype=np.uint8)
        start = 8 * int(rng.integers(0, 16))
        moved = room[start : start + numbers.nbytes].view(np.float64).reshape(numbers.shape)
        moved[:] = numbers
        np.testing.assert_array_equal(made(moved), once)


def test_arctan2_is_numpys() -> None:
    y, x = np.random.default_rng(7).standard_normal((2, 40, 3))
    np.testing.assert_allclose(angles.arctan2(y[:, 1], x[:, 2]), np.arctan2(y[:, 1], x[:, 2]), rtol=1e-15)
    assert angles.arctan2(1.0, -1.0) == pytest.approx(0.75 * np.pi) and np.ndim(angles.arctan2(1.0, 2.0)) == 0
    np.testing.assert_array_equal(angles.arctan2([0.0, -0.0], -1.0), [np.pi, -np.pi])

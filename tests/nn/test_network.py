from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest
from footwork.nn.network import product

SCRIPT = """
import hashlib
import numpy as np
from footwork.nn.predictor import shipped_predictors
rng = np.random.default_rng(3)
for name, predictor in shipped_predictors().items():
    network = predictor.networks[0]
    for rows in (3, 64, 1357):
        x = rng.standard_normal((rows, network.sizes[0])).astype(np.float32)
        print(name, rows, hashlib.sha256(network.forward(x).tobytes()).hexdigest())
"""


@pytest.mark.parametrize(
    "shape", [(7,), (1, 7), (5, 7), (900, 471), (65, 129), (3, 4, 7), (0, 7), (6, 7_000)]
)
def test_a_product_is_what_it_says(shape: tuple[int, ...]) -> None:
    rng = np.random.default_rng(4)
    x, weight = rng.standard_normal(shape), rng.standard_normal((shape[-1], 11))
    found = product(x, weight)
    assert found.shape == (*shape[:-1], 11)
    np.testing.assert_allclose(found, np.einsum("...i,io->...o", x, weight), atol=1e-9)
    single = product(x.astype(np.float32), weight.astype(np.float32))
    assert single.dtype == np.float32


def test_networks_answer_the_same_on_any_number_of_threads() -> None:
    def answers(threads: int) -> str:
        names = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
        environment = {**os.environ, **dict.fromkeys(names, str(threads))}
        return subprocess.run(
            [sys.executable, "-c", SCRIPT],
            env=environment,
            capture_output=True,
            text=True,
            timeout=120,
            check=True,
        ).stdout

    one = answers(1)
    assert len(one.splitlines()) >= 6
    assert answers(2) == one == answers(4)

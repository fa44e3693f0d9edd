"""Feed-forward networks with real ReLUs between their layers, run in numpy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]

_TILE = (32, 128, 64)
"""Rows, inputs and outputs of one product: OpenBLAS leaves 2^18 multiplications to a single thread."""


@dataclass(frozen=True, slots=True, eq=False)
class Network:
    """A multilayer perceptron."""

    weights: tuple[Array, ...]
    """Per layer `(inputs, outputs)`, float32."""
    biases: tuple[Array, ...]
    """Per layer `(outputs,)`, float32."""

    @property
    def sizes(self) -> tuple[int, ...]:
        """Width of the input, of each hidden layer and of the output."""
        return (len(self.weights[0]), *(len(bias) for bias in self.biases))

    @property
    def parameters(self) -> int:
        """How many numbers training has to find."""
        return sum(w.size + b.size for w, b in zip(self.weights, self.biases, strict=True))

    def forward(self, x: Array) -> Array:
        """Outputs `(..., sizes[-1])` of inputs `(..., sizes[0])`, float32 as they come."""
        return self.finish(product(x, self.weights[0]) + self.biases[0])

    def finish(self, first: Array) -> Array:
        """Outputs from the first layer's sums `(..., sizes[1])`, for callers that compute those piecewise."""
        x = first
        for weight, bias in zip(self.weights[1:], self.biases[1:], strict=True):
            x = product(np.maximum(x, 0.0), weight) + bias
        return x


def product(x: Array, weight: Array) -> Array:
    """`x @ weight`, the same to the last bit on any number of threads.

    Threads share a large product in ways that round differently, so it is made of small ones.
    """
    if x.ndim < 2:
        return x @ weight
    (height, deep, wide), (inputs, outputs) = _TILE, weight.shape
    flat = x.reshape(-1, inputs)
    tiles = np.zeros((-(-len(flat) // height), height, inputs), dtype=x.dtype)
    tiles.reshape(-1, inputs)[: len(flat)] = flat
    made = np.zeros((len(tiles), height, outputs), dtype=np.result_type(x, weight))
    for j in range(0, outputs, wide):
        for i in range(0, inputs, deep):
            made[..., j : j + wide] += tiles[..., i : i + deep] @ weight[i : i + deep, j : j + wide]
    return made.reshape(-1, outputs)[: len(flat)].reshape(*x.shape[:-1], outputs)

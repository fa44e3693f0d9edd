"""Networks between numpy and torch."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch
from torch import nn

from .network import Network


def build_mlp(inputs: int, hidden: Sequence[int], outputs: int, dropout: float = 0.0) -> nn.Sequential:
    """A multilayer perceptron with ReLUs after each hidden layer."""
    layers: list[nn.Module] = []
    for width in hidden:
        layers += [nn.Linear(inputs, width), nn.ReLU()]
        if dropout > 0.0:
            layers.append(nn.Dropout(dropout))
        inputs = width
    return nn.Sequential(*layers, nn.Linear(inputs, outputs))


def linear_layers(model: nn.Sequential) -> list[nn.Linear]:
    """The layers that have weights, in order."""
    return [layer for layer in model if isinstance(layer, nn.Linear)]


def from_torch(model: nn.Sequential) -> Network:
    """A copy of the model for numpy."""
    layers = linear_layers(model)
    return Network(
        tuple(np.ascontiguousarray(layer.weight.detach().numpy().T).copy() for layer in layers),
        tuple(layer.bias.detach().numpy().copy() for layer in layers),
    )


def load_weights(model: nn.Sequential, network: Network) -> None:
    """Give the model a network's weights; both must have the same sizes."""
    with torch.no_grad():
        for layer, weight, bias in zip(linear_layers(model), network.weights, network.biases, strict=True):
            layer.weight.copy_(torch.from_numpy(weight.T.copy()))
            layer.bias.copy_(torch.from_numpy(bias))

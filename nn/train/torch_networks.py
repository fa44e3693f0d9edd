"""Networks between numpy and torch, and the state of their training."""

# torch tells only part of its types, and types are checked without it, too
# pyright: basic, reportMissingImports=false

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence

import numpy as np
import torch
from torch import nn

from ...core.json_text import parse_json
from ..network import Network


def build_mlp(inputs: int, hidden: Sequence[int], outputs: int) -> nn.Sequential:
    """A multilayer perceptron with ReLUs after each hidden layer."""
    layers: list[nn.Module] = []
    for width in hidden:
        layers += [nn.Linear(inputs, width), nn.ReLU()]
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


def training_state(
    optimiser: torch.optim.Optimizer,
    schedule: torch.optim.lr_scheduler.LRScheduler,
    rng: np.random.Generator,
) -> dict[str, np.ndarray]:
    """Arrays of all that steps change besides the weights: AdamW's moments, the schedule, both random states.

    Before the first step the moments are zeros, as AdamW takes them.
    """
    (group,) = optimiser.param_groups
    arrays = {
        "rate": np.array(group["lr"], dtype=np.float64),
        "schedule": np.array(schedule.last_epoch, dtype=np.int64),
        "numpy": np.array(json.dumps(rng.bit_generator.state)),
        "torch": torch.get_rng_state().numpy(),
    }
    for n, parameter in enumerate(group["params"]):
        moments = optimiser.state.get(parameter, {})
        blank = torch.zeros_like(parameter)
        arrays[f"step_{n}"] = np.array(float(moments.get("step", 0.0)), dtype=np.float32)
        for key in ("exp_avg", "exp_avg_sq"):
            arrays[f"{key}_{n}"] = moments.get(key, blank).detach().numpy().copy()
    return arrays


def restore_training(
    state: Mapping[str, np.ndarray],
    optimiser: torch.optim.Optimizer,
    schedule: torch.optim.lr_scheduler.LRScheduler,
    rng: np.random.Generator,
) -> None:
    """Take over a `training_state`; ValueError, KeyError, TypeError or RuntimeError where it does not fit."""
    for key, mine in training_state(optimiser, schedule, rng).items():
        theirs = state[key]
        # the text of numpy's state has no fixed length
        if theirs.shape != mine.shape or theirs.dtype.kind != mine.dtype.kind:
            raise ValueError(key)
    whole = optimiser.state_dict()
    (group,) = whole["param_groups"]
    rate, steps = float(state["rate"]), int(state["schedule"])
    group["lr"] = rate
    whole["state"] = {
        n: {key: torch.from_numpy(state[f"{key}_{n}"].copy()) for key in ("step", "exp_avg", "exp_avg_sq")}
        for n in range(len(group["params"]))
    }
    optimiser.load_state_dict(whole)
    # a count of 1 makes torch warn of a schedule that runs before its optimiser
    schedule.load_state_dict(
        schedule.state_dict() | {"last_epoch": steps, "_step_count": steps + 2, "_last_lr": [rate]}
    )
    rng.bit_generator.state = parse_json(str(state["numpy"]).encode())
    torch.set_rng_state(torch.from_numpy(state["torch"].copy()))

"""Training of window networks in torch: many altered windows of the takes, each with its true body."""

# torch tells only part of its types, and types are checked without it, too
# pyright: basic, reportMissingImports=false

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import torch

from ...core.maths import angles
from ...core.recording.windows import FACING, WindowLayout, mirror_inputs, stream, window_inputs
from ..inputs import RATE, Scaler, group_scaler
from ..network import Network
from ..parts import ALL, EVERYTHING, SHAPES, YAW
from ..weights import Predictor
from .augment import Augmentation, augment, mix_hands
from .samples import Sample
from .torch_networks import (
    build_mlp,
    from_torch,
    linear_layers,
    load_weights,
    restore_training,
    training_state,
)

SMOOTHING = 0.1
"""Seconds, for windows that see the future; smoothing the past costs more in lag than it gains."""
AUGMENTATION = Augmentation()
UNITS = {YAW: 1.0, "hips": 2.0**-5, "feet": 2.0**-4, "standing": 1.0, "chest": 0.25, "elbows": 0.25}
"""What the network answers in, about as far as good answers are off: powers of two, which change no digit."""
IMPORTANCE = {YAW: 4.0, "hips": 1.0, "feet": 2.0, "standing": 0.5, "chest": 1.0, "elbows": 1.0}
"""What a squared unit counts in training."""
SPREAD_IMPORTANCE = 0.1
DIRECTIONS = {"hips": 3.0, "feet": 3.0, "chest": 4.0, "elbows": 3.0}
"""Squared deviations in so many directions lie in a part's squared distance; a turn by an angle moves both columns
of a rotation, so that twice its square lies in six numbers."""


class WindowLearner:
    """Fits one network; `step` is one batch, `predictor` what has been learnt so far."""

    def __init__(
        self,
        samples: Sequence[Sample],
        layout: WindowLayout,
        *,
        batch: int,
        learning_rate: float,
        decay: float,
        steps: int,
        seed: int,
        hidden: Sequence[int],
        augmentation: Augmentation = AUGMENTATION,
        start: Predictor | None = None,
        scaler: Scaler | None = None,
    ) -> None:
        torch.manual_seed(seed)
        self.rng = np.random.default_rng(seed)
        self.layout, self.batch, self.augmentation = layout, batch, augmentation
        self.smoothing = 0.0 if layout.causal else SMOOTHING
        tracked = [np.ones((len(sample), 3), dtype=bool) for sample in samples]
        rows = [
            stream(s.positions, s.rotations, t, s.head_height) for s, t in zip(samples, tracked, strict=True)
        ]
        lengths = np.array([len(sample) for sample in samples])
        ends = np.cumsum(lengths)
        self.rows = np.concatenate(rows)
        self.yaws = np.concatenate([sample.yaws for sample in samples])
        self.bodies = np.concatenate([sample.truth for sample in samples])
        self.first = np.repeat(ends - lengths, lengths)
        self.last = np.repeat(ends - 1, lengths)
        self.scaler = start.scaler if start is not None else scaler or self._scaler()
        self.model = build_mlp(layout.inputs, hidden, EVERYTHING.size)
        self.units = np.ones(EVERYTHING.size, dtype=np.float32)
        for name, unit in UNITS.items():
            self.units[EVERYTHING.values[name]] = unit
        if start is not None:
            load_weights(self.model, _scaled(start.networks[0], 1.0 / self.units))
        else:
            self._doubt_first()
        self.optimiser = torch.optim.AdamW(self.model.parameters(), lr=learning_rate, weight_decay=decay)
        self.schedule = torch.optim.lr_scheduler.LambdaLR(
            self.optimiser,
            lambda n: min(1.0, (n + 1) / 200) * 0.5 * (1.0 + math.cos(math.pi * min(1.0, n / steps))),
        )

    def _scaler(self) -> Scaler:
        """Measured on altered windows, which are what the network will see."""
        inputs, _ = self._draw(4096)
        return group_scaler(inputs.astype(np.float64), self.layout.groups)

    def _doubt_first(self) -> None:
        """Begin with deviations of one unit."""
        bias = linear_layers(self.model)[-1].bias
        with torch.no_grad():
            for name in SHAPES:
                bias[EVERYTHING.spreads[name]] = math.log(UNITS[name])

    def _draw(self, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Input vectors `(2 count, D)` before scaling and true answers `(2 count, EVERYTHING.size)` in their
        axes."""
        frames = self.rng.integers(0, len(self.rows), count)
        speed = np.exp(self.rng.uniform(-1.0, 1.0, (count, 1)) * np.log1p(self.augmentation.stretch))
        places = np.round(frames[:, None] + self.layout.offsets * speed * RATE).astype(np.intp)
        # a window ends where its take does
        places = np.clip(places, self.first[frames][:, None], self.last[frames][:, None])
        windows, source = mix_hands(self.rows[places], self.yaws[places], self.augmentation, self.rng)
        windows, size, moved = augment(windows, self.layout.offsets, self.augmentation, self.rng)
        frame = angles.yaw_of(windows[:, self.layout.centre, FACING].astype(np.float64))
        near = self.rng.normal(self.yaws[frames], self.augmentation.frame)
        frame = np.where(self.rng.random(count) < 0.5, near, frame)
        inputs = window_inputs(windows, frame, self.layout)
        truth = EVERYTHING.turned(self._bodies(frames, source, size), self.yaws[frames] - frame)
        truth[:, EVERYTHING.values["hips"]][:, :2] -= angles.turn(moved[:, :2], -frame)
        mirrored = mirror_inputs(inputs, self.layout)
        return np.concatenate([inputs, mirrored]), np.concatenate([truth, EVERYTHING.mirrored(truth)])

    def _bodies(self, frames: np.ndarray, source: np.ndarray, size: np.ndarray) -> np.ndarray:
        """True rows of altered bodies in their own axes: larger, and with the hands of others."""
        rows = self.bodies[frames].copy()
        for name in ("hips", "feet"):
            rows[:, EVERYTHING.values[name]] *= size[:, None]
        elbows = EVERYTHING.values["elbows"].start
        for hand in range(2):
            place = slice(elbows + 3 * hand, elbows + 3 * hand + 3)
            rows[:, place] = self.bodies[frames[source[:, hand]], place]
        return rows

    def step(self) -> float:
        """One optimisation step; returns the batch's loss."""
        inputs, truth = self._draw(self.batch // 2)
        x = torch.from_numpy(self.scaler.apply(inputs).astype(np.float32))
        y = torch.from_numpy(truth.astype(np.float32))
        self.model.train()
        self.optimiser.zero_grad(set_to_none=True)
        loss = self._loss(self.model(x), y)
        loss.backward()
        self.optimiser.step()
        self.schedule.step()
        return float(loss.detach())

    def _loss(self, answer: torch.Tensor, truth: torch.Tensor) -> torch.Tensor:
        """What is to become small.

        The squared distance makes the best answer to a doubtful window the mean of all bodies that it may stand
        for: the less sure of the yaw, the shorter its vector. Deviations are fitted to what the distances
        turn out to be, as those of a normal distribution (its negative log-likelihood), without pulling at the answers.
        """
        yaw, standing = EVERYTHING.values[YAW], EVERYTHING.values["standing"]
        loss = IMPORTANCE[YAW] * ((answer[:, yaw] - truth[:, yaw]) ** 2).sum(dim=1).mean()
        loss = loss + IMPORTANCE["standing"] * torch.nn.functional.binary_cross_entropy_with_logits(
            answer[:, standing], truth[:, standing]
        )
        for name, directions in DIRECTIONS.items():
            block, spread, unit = EVERYTHING.values[name], answer[:, EVERYTHING.spreads[name]], UNITS[name]
            off = (answer[:, block] - truth[:, block] / unit).unflatten(1, (spread.shape[1], -1))
            squared = (off**2).sum(dim=2)
            loss = loss + IMPORTANCE[name] * squared.mean() / off.shape[2]
            normal = (squared.detach() / directions) * torch.exp(2.0 * (math.log(unit) - spread))
            loss = loss + SPREAD_IMPORTANCE * (0.5 * normal + spread).mean()
        return loss

    def network(self) -> Network:
        """The network as it is now, for numpy."""
        return _scaled(from_torch(self.model), self.units)

    def predictor(self) -> Predictor:
        """What has been learnt so far."""
        return Predictor("", (self.network(),), self.scaler, self.layout, self.smoothing, {}, ALL)

    def state(self) -> dict[str, np.ndarray]:
        """All that steps change besides the weights."""
        return training_state(self.optimiser, self.schedule, self.rng)

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Take over a `state`; ValueError, KeyError, TypeError or RuntimeError where it does not fit."""
        restore_training(state, self.optimiser, self.schedule, self.rng)


def _scaled(network: Network, units: np.ndarray) -> Network:
    """The network with answers `units` times as large."""
    return Network(
        (*network.weights[:-1], network.weights[-1] * units),
        (*network.biases[:-1], network.biases[-1] * units),
    )

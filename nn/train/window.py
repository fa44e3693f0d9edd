"""Training of window networks in torch: many altered windows of the takes, each with its true body
direction."""

# torch tells only part of its types, and types are checked without it, too
# pyright: basic, reportMissingImports=false

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import torch

from ...core.maths import angles
from ..inputs import RATE, Scaler, group_scaler
from ..network import Network
from ..weights import Predictor
from ..windows import FACING, WindowLayout, mirror_inputs, stream, window_inputs
from .augment import Augmentation, augment, mix_hands
from .samples import Sample
from .torch_networks import build_mlp, from_torch, load_weights, restore_training, training_state

SMOOTHING = 0.1
"""Seconds, for windows that see the future; smoothing the past costs more in lag than it gains."""
AUGMENTATION = Augmentation()


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
        self.first = np.repeat(ends - lengths, lengths)
        self.last = np.repeat(ends - 1, lengths)
        self.scaler = start.scaler if start is not None else scaler or self._scaler()
        self.model = build_mlp(layout.inputs, hidden, 2)
        if start is not None:
            load_weights(self.model, start.networks[0])
        self.optimiser = torch.optim.AdamW(self.model.parameters(), lr=learning_rate, weight_decay=decay)
        self.schedule = torch.optim.lr_scheduler.LambdaLR(
            self.optimiser,
            lambda n: min(1.0, (n + 1) / 200) * 0.5 * (1.0 + math.cos(math.pi * min(1.0, n / steps))),
        )

    def _scaler(self) -> Scaler:
        """Measured on altered windows, which are what the network will see."""
        inputs, _ = self._draw(4096)
        return group_scaler(inputs.astype(np.float64), self.layout.groups)

    def _draw(self, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Input vectors `(2 count, D)` before scaling and true ground directions `(2 count, 2)` in their
        axes."""
        frames = self.rng.integers(0, len(self.rows), count)
        speed = np.exp(self.rng.uniform(-1.0, 1.0, (count, 1)) * np.log1p(self.augmentation.stretch))
        places = np.round(frames[:, None] + self.layout.offsets * speed * RATE).astype(np.intp)
        # a window ends where its take does
        places = np.clip(places, self.first[frames][:, None], self.last[frames][:, None])
        windows = mix_hands(self.rows[places], self.yaws[places], self.augmentation, self.rng)
        windows = augment(windows, self.layout.offsets, self.augmentation, self.rng)
        frame = angles.yaw_of(windows[:, self.layout.centre, FACING].astype(np.float64))
        near = self.rng.normal(self.yaws[frames], self.augmentation.frame)
        frame = np.where(self.rng.random(count) < 0.5, near, frame)
        inputs = window_inputs(windows, frame, self.layout)
        truth = angles.direction(self.yaws[frames] - frame)
        mirrored = mirror_inputs(inputs, self.layout)
        return np.concatenate([inputs, mirrored]), np.concatenate([truth, truth * [-1.0, 1.0]])

    def step(self) -> float:
        """One optimisation step; returns the batch's loss.

        The squared distance makes the best answer to a doubtful window the mean of all directions that it may
        stand for: the less sure, the shorter.
        """
        inputs, truth = self._draw(self.batch // 2)
        x = torch.from_numpy(self.scaler.apply(inputs).astype(np.float32))
        y = torch.from_numpy(truth.astype(np.float32))
        self.model.train()
        self.optimiser.zero_grad(set_to_none=True)
        loss = ((self.model(x) - y) ** 2).sum(dim=1).mean()
        loss.backward()
        self.optimiser.step()
        self.schedule.step()
        return float(loss.detach())

    def network(self) -> Network:
        """The network as it is now, for numpy."""
        return from_torch(self.model)

    def predictor(self) -> Predictor:
        """What has been learnt so far."""
        return Predictor("", (self.network(),), self.scaler, self.layout, self.smoothing, {})

    def state(self) -> dict[str, np.ndarray]:
        """All that steps change besides the weights."""
        return training_state(self.optimiser, self.schedule, self.rng)

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Take over a `state`; ValueError, KeyError, TypeError or RuntimeError where it does not fit."""
        restore_training(state, self.optimiser, self.schedule, self.rng)

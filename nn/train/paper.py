"""The paper's training (algorithm 1): predict r times from the truth, compare only the last answer."""

# torch tells only part of its types, and types are checked without it, too
# pyright: basic, reportMissingImports=false

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import numpy as np
import torch

from ...core.maths import angles
from ..inputs import GROUPS, RATE, TRACKED, group_scaler, headings, tracker_inputs, yaw_to_sixd
from ..network import Network
from ..weights import Predictor
from .samples import Sample
from .torch_networks import (
    build_mlp,
    from_torch,
    linear_layers,
    load_weights,
    restore_training,
    training_state,
)


class RecurrentLearner:
    """Fits the paper's network; `step` is one batch of r predictions, `predictor` what has been learnt so
    far.

    As in its reference set-up: AdamW, the learning rate falls by a twentieth per epoch, gradients run
    through all r predictions. Otherwise than there, no stretch of r frames crosses from one take into
    another, and the fed-back answer is re-expressed in the axes of the frame it is fed to.
    """

    def __init__(
        self,
        samples: Sequence[Sample],
        *,
        iterations: int,
        hidden: Sequence[int],
        batch: int,
        learning_rate: float,
        decay: float,
        seed: int,
        start: Predictor | None = None,
    ) -> None:
        torch.manual_seed(seed)
        self.rng = np.random.default_rng(seed)
        self.iterations, self.batch = iterations, batch
        tracked = [tracker_inputs(s.positions, s.rotations, RATE) for s in samples]
        head = [headings(s.rotations) for s in samples]
        truth = np.concatenate([yaw_to_sixd(s.yaws - h) for s, h in zip(samples, head, strict=True)])
        steps = np.concatenate([angles.wrap(np.diff(h, prepend=h[0])) for h in head])
        inputs = np.concatenate([np.concatenate(tracked), truth], axis=1)
        self.scaler = start.scaler if start is not None else group_scaler(inputs, GROUPS)
        scaled = self.scaler.apply(inputs).astype(np.float32)
        self.tracked = torch.from_numpy(scaled[:, :TRACKED].copy())
        self.truth = torch.from_numpy(scaled[:, TRACKED:].copy())
        self._prepare_turns(steps)
        self.starts = self._starts([len(s) for s in samples])
        self.model = build_mlp(self.tracked.shape[1] + 6, hidden, 6)
        if start is not None:
            load_weights(self.model, start.networks[0])
        self.optimiser = torch.optim.AdamW(self.model.parameters(), lr=learning_rate, weight_decay=decay)
        self.schedule = torch.optim.lr_scheduler.ExponentialLR(self.optimiser, gamma=0.95)
        self.order = self.rng.permutation(self.starts)
        self.place = 0

    @property
    def steps_per_epoch(self) -> int:
        """Batches until every start has been used once."""
        return max(1, len(self.starts) // self.batch)

    def _starts(self, lengths: Sequence[int]) -> np.ndarray:
        """First predicted frames whose predecessor and r-th prediction lie in the same take."""
        borders = np.cumsum([0, *lengths])
        spans = [np.arange(a + 1, b - self.iterations + 1) for a, b in itertools.pairwise(borders)]
        return np.concatenate(spans)

    def step(self) -> float:
        """One optimisation step; returns the batch's loss, the squared error of normalised six numbers."""
        if self.place + self.batch > len(self.order) and self.place > 0:
            self.order, self.place = self.rng.permutation(self.starts), 0
            self.schedule.step()
        chosen = torch.from_numpy(self.order[self.place : self.place + self.batch])
        self.place += self.batch
        self.optimiser.zero_grad(set_to_none=True)
        answer = self.unroll(chosen, self.truth[chosen - 1])
        loss = torch.nn.functional.mse_loss(answer, self.truth[chosen + self.iterations - 1])
        loss.backward()
        self.optimiser.step()
        return float(loss.detach())

    def unroll(self, first: torch.Tensor, answer: torch.Tensor) -> torch.Tensor:
        """The r-th normalised answer `(B, 6)`, from normalised ones at the frames before `first` `(B,)`."""
        layers = linear_layers(self.model)
        weight = layers[0].weight
        frames = first[:, None] + torch.arange(self.iterations)
        # all the tracked part at once: only the fed-back six numbers have to wait for each other
        sums = torch.cat([self.tracked[frames], self.shift[frames]], dim=-1) @ weight.T + layers[0].bias
        sums, along, across = (x.unbind(1) for x in (sums, self.along[frames], self.across[frames]))
        fed_back = weight[:, TRACKED:].T
        for j in range(self.iterations):
            previous = answer * along[j] + (answer @ self.quarter) * across[j]
            answer = torch.addmm(sums[j], previous, fed_back)
            for layer in layers[1:]:
                answer = layer(torch.relu(answer))
        return answer

    def _prepare_turns(self, steps: np.ndarray) -> None:
        """What re-expresses a normalised answer in the next frame's axes: `x along + (x quarter) across +
        shift`.

        The axes turn by `steps` `(N,)` radians, so the answer turns by the opposite. Its six numbers share
        one deviation, which therefore stays outside; the mean gives the shift.
        """
        c, s = np.cos(steps), -np.sin(steps)
        one = np.ones_like(c)
        along = np.stack([c, c, one, c, c, one], axis=-1)
        quarter = np.zeros((6, 6))
        quarter[[0, 1, 3, 4], [1, 0, 4, 3]] = [1.0, -1.0, 1.0, -1.0]
        mean = self.scaler.mean[TRACKED:]
        shift = mean * along + (mean @ quarter) * s[:, None] - mean
        shift = shift / self.scaler.deviation[TRACKED:]
        self.along, self.across = _tensor(along), _tensor(np.repeat(s[:, None], 6, axis=1))
        self.quarter, self.shift = _tensor(quarter), _tensor(shift)

    def network(self) -> Network:
        """The network as it is now, for numpy."""
        return from_torch(self.model)

    def predictor(self) -> Predictor:
        """What has been learnt so far."""
        return Predictor("", (self.network(),), self.scaler, None, 0.0, {})

    def state(self) -> dict[str, np.ndarray]:
        """All that steps change besides the weights."""
        turn = {"order": self.order, "place": np.array(self.place, dtype=np.int64)}
        return turn | training_state(self.optimiser, self.schedule, self.rng)

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Take over a `state`; ValueError, KeyError, TypeError or RuntimeError where it does not fit."""
        order, place = state["order"], int(state["place"])
        if order.dtype != self.order.dtype or not np.array_equal(np.sort(order), self.starts) or place < 0:
            raise ValueError("order")
        restore_training(state, self.optimiser, self.schedule, self.rng)
        self.order, self.place = order, place


def _tensor(values: np.ndarray) -> torch.Tensor:
    return torch.from_numpy(values.astype(np.float32))

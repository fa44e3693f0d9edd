"""Training of the motion model: a decoder of poses with an encoder that finds the manners, in torch."""

# torch tells only part of its types, and types are checked without it, too
# pyright: basic, reportMissingImports=false

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

from ...core.body.skeleton import LEG, SIDES, Skeleton
from ..motion.body import starter_skeleton
from ..motion.conditions import SIZE
from ..motion.decoder import ANSWERS, HIDDEN, LATENT, MotionModel

Array = NDArray[np.floating[Any]]

_SEEN = (-8, 0, 8)
"""Frames around a moment that the encoder sees."""
_APART = 12
"""It looks up to so many frames away from the pose to be answered, so that it can tell slow things alone."""
_KL, _FREE = 0.004, 0.02


class Decoder(nn.Module):
    """Poses of conditions, people and manners, all normalised."""

    def __init__(self, people: int) -> None:
        super().__init__()
        widths = [SIZE + people, *HIDDEN, ANSWERS]
        self.layers = nn.ModuleList(
            nn.Linear(widths[n] + LATENT, widths[n + 1]) for n in range(len(widths) - 1)
        )

    def forward(self, x: torch.Tensor, z: torch.Tensor) -> torch.Tensor:
        """`(..., ANSWERS)` of `(..., SIZE + people)` and `(..., LATENT)`."""
        for layer in self.layers[:-1]:
            x = nn.functional.elu(layer(torch.cat([x, z], dim=-1)))
        return self.layers[-1](torch.cat([x, z], dim=-1))


class Body:
    """Forward kinematics of world rotations in torch."""

    def __init__(self, skeleton: Skeleton) -> None:
        count = len(skeleton)
        above = np.zeros((count, count), dtype=np.float32)
        for j in range(count):
            at = j
            while at > 0:
                above[j, at] = 1.0
                at = int(skeleton.parents[at])
        self.chain = torch.from_numpy(above)
        self.parents = torch.from_numpy(np.maximum(skeleton.parents, 0))
        self.offsets = torch.from_numpy(skeleton.offsets.astype(np.float32))
        self.knees = [(skeleton.joint(f"thigh.{s}"), skeleton.joint(f"shin.{s}")) for s in SIDES]
        self.toes = [skeleton.joint(f"toe.{s}") for s in SIDES]
        legs = [skeleton.joint(f"{part}.{s}") for part in LEG for s in SIDES]
        weight = torch.ones(count)
        weight[[0, *legs]] = 3.0
        self.weight = weight / weight.mean()

    def rotations(self, sixd: torch.Tensor) -> torch.Tensor:
        """Matrices `(..., J, 3, 3)` of `(..., 6 J)`."""
        a = sixd.reshape(*sixd.shape[:-1], -1, 6)
        x = nn.functional.normalize(a[..., :3], dim=-1)
        y = a[..., 3:] - (x * a[..., 3:]).sum(-1, keepdim=True) * x
        y = nn.functional.normalize(y, dim=-1)
        return torch.stack([x, y, torch.cross(x, y, dim=-1)], dim=-1)

    def positions(self, hips: torch.Tensor, turned: torch.Tensor) -> torch.Tensor:
        """Joints `(..., J, 3)`."""
        bones = (turned[..., self.parents, :, :] @ self.offsets[:, :, None])[..., 0]
        return hips[..., None, :] + self.chain @ bones


def train_motion(
    arrays: Mapping[str, Array],
    people: tuple[str, ...],
    provenance: Mapping[str, Any],
    *,
    steps: int,
    seed: int = 0,
    batch: int = 384,
    told: Callable[[int, float, MotionModel], None] = lambda step, loss, model: None,
) -> MotionModel:
    """Train a motion model; `told` hears of every 1000 steps.

    Args:
        arrays: of all frames: "x" `(T, SIZE)` conditions, "y" `(T, ANSWERS)` poses, "w" `(T,)` how often each is
            shown (0 within 21 frames of a stretch's end), "person" `(T,)`, "place" `(T, 3)` and "yaw" `(T,)` of the
            root, "contact" `(T, 2)`; at 30 frames per second.
        people: names, in the order of "person".
        provenance: kept in the model as it is.
        steps: of AdamW.
        seed: of all randomness.
        batch: pairs of frames per step.
    """
    torch.manual_seed(seed)
    rng = np.random.RandomState(seed)
    data = _Data(arrays, len(people))
    decoder = Decoder(len(people))
    encoder = nn.Sequential(
        nn.Linear(ANSWERS * len(_SEEN) + len(people), 256), nn.ELU(), nn.Linear(256, 2 * LATENT)
    )
    body = Body(starter_skeleton())
    optimiser = torch.optim.AdamW([*decoder.parameters(), *encoder.parameters()], lr=1e-3, weight_decay=1e-4)
    schedule = torch.optim.lr_scheduler.LambdaLR(
        optimiser, lambda n: min(1.0, (n + 1) / 200) * 0.5 * (1.01 + math.cos(math.pi * n / steps))
    )
    total = 0.0
    for step in range(1, steps + 1):
        loss = _loss(data, decoder, encoder, body, rng, batch)
        optimiser.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_([*decoder.parameters(), *encoder.parameters()], 1.0)
        optimiser.step()
        schedule.step()
        total += float(loss.detach())
        if step % 1000 == 0:
            told(step, total / 1000, _model(data, decoder, encoder, people, provenance))
            total = 0.0
    return _model(data, decoder, encoder, people, provenance)


class _Data:
    """All frames as normalised tensors."""

    def __init__(self, arrays: Mapping[str, Array], people: int) -> None:
        shown = arrays["w"] > 0.0
        x, y = arrays["x"], arrays["y"]
        self.scale = x[shown].mean(axis=0), np.maximum(x[shown].std(axis=0), 1e-3)
        self.answer_scale = y[shown].mean(axis=0), np.maximum(y[shown].std(axis=0), 1e-3)
        self.x = _tensor((x - self.scale[0]) / self.scale[1])
        self.y, self.seen = _tensor(y), _tensor((y - self.answer_scale[0]) / self.answer_scale[1])
        self.mean, self.deviation = map(_tensor, self.answer_scale)
        self.person = arrays["person"].astype(np.intp)
        self.who = nn.functional.one_hot(torch.from_numpy(self.person), people).float()
        self.contact = _tensor(arrays["contact"])
        step = np.diff(arrays["place"], axis=0, append=arrays["place"][-1:])
        yaw = arrays["yaw"]
        cos, sin = np.cos(yaw), np.sin(yaw)
        ahead = np.stack(
            [cos * step[:, 0] + sin * step[:, 1], cos * step[:, 1] - sin * step[:, 0], step[:, 2]], 1
        )
        self.step, self.turn = _tensor(ahead), _tensor(np.diff(yaw, append=yaw[-1:]))
        self.cumulated = np.cumsum(arrays["w"])
        self.frames = np.flatnonzero(shown)

    def looked_at(self, frames: NDArray[np.intp]) -> torch.Tensor:
        """What the encoder sees around frames."""
        near = [self.seen[frames + d] for d in _SEEN]
        return torch.cat([*near, self.who[frames]], dim=-1)


def _tensor(array: Array) -> torch.Tensor:
    return torch.from_numpy(np.ascontiguousarray(array, dtype=np.float32))


def _loss(
    data: _Data, decoder: Decoder, encoder: nn.Module, body: Body, rng: np.random.RandomState, batch: int
) -> torch.Tensor:
    at = np.searchsorted(data.cumulated, rng.uniform(0.0, data.cumulated[-1], batch), side="right")
    mu, spread = encoder(data.looked_at(at + rng.randint(-_APART, _APART + 1, batch))).chunk(2, dim=-1)
    spread = spread.clamp(-8.0, 4.0)
    z = mu + torch.exp(0.5 * spread) * torch.randn_like(mu)
    kl = 0.5 * (mu**2 + spread.exp() - spread - 1.0).mean(dim=0).clamp_min(_FREE).sum()
    pair = np.stack([at, at + 1])
    made = decoder(torch.cat([data.x[pair], data.who[pair]], dim=-1), z.expand(2, -1, -1))
    made = made * data.deviation + data.mean
    return _pose_loss(made, data.y[pair], data, at, body) + _KL * kl


def _pose_loss(
    made: torch.Tensor, wanted: torch.Tensor, data: _Data, at: NDArray[np.intp], body: Body
) -> torch.Tensor:
    """Of pairs of frames `(2, B, ANSWERS)`, mean absolute errors: see the docs."""
    turned = [body.rotations(poses[..., 3:]) for poses in (made, wanted)]
    places = [body.positions(poses[..., :3], r) for poses, r in zip((made, wanted), turned, strict=True)]
    weight = body.weight
    sixd = ((made - wanted)[..., 3:].reshape(*made.shape[:-1], -1, 6).abs().mean(-1) * weight).mean()
    place = ((places[0] - places[1]).abs().mean(-1) * weight).mean()
    offset = (made - wanted)[..., :3].abs().mean()
    knees = torch.stack(
        [(_local(turned[0], a, b) - _local(turned[1], a, b)).abs().mean() for a, b in body.knees]
    ).mean()
    toes = [p[..., body.toes, :] for p in places]
    lift = (toes[0] - toes[1])[..., 2].abs().mean()
    speeds = [_velocity(p, data.step[at], data.turn[at]) for p in places]
    speed = ((speeds[0] - speeds[1]).abs().mean(-1) * weight).mean()
    stands = data.contact[at] * data.contact[at + 1]
    slip = (speeds[0][:, body.toes].norm(dim=-1) * stands).sum() / stands.sum().clamp_min(1.0)
    return sixd + 10.0 * place + 20.0 * offset + 2.0 * knees + 10.0 * lift + 0.15 * speed + 0.2 * slip


def _local(turned: torch.Tensor, above: int, below: int) -> torch.Tensor:
    return turned[..., above, :, :].transpose(-1, -2) @ turned[..., below, :, :]


def _velocity(places: torch.Tensor, step: torch.Tensor, turn: torch.Tensor) -> torch.Tensor:
    """World velocities `(B, J, 3)` in the first frame's axes of joints `(2, B, J, 3)` in each frame's own."""
    cos, sin = torch.cos(turn)[:, None], torch.sin(turn)[:, None]
    x, y, z = places[1].unbind(-1)
    after = torch.stack([cos * x - sin * y, sin * x + cos * y, z], dim=-1) + step[:, None]
    return (after - places[0]) * 30.0


def _model(
    data: _Data,
    decoder: Decoder,
    encoder: nn.Module,
    people: tuple[str, ...],
    provenance: Mapping[str, Any],
) -> MotionModel:
    with torch.no_grad():
        mu = encoder(data.looked_at(data.frames))[:, :LATENT].numpy().astype(np.float64)
    person = data.person[data.frames]
    groups = [mu[person == n] for n in range(len(people))]
    return MotionModel(
        people=people,
        scale=data.scale,
        answer_scale=data.answer_scale,
        weights=tuple(layer.weight.detach().numpy().T.astype(np.float64) for layer in decoder.layers),
        biases=tuple(layer.bias.detach().numpy().astype(np.float64) for layer in decoder.layers),
        manners=(
            np.stack([group.mean(axis=0) for group in groups]),
            np.stack([np.maximum(group.std(axis=0), 1e-3) for group in groups]),
        ),
        provenance=provenance,
    )

"""What the motion model answers, made exact: feet that stand do not slide, legs reach, feet keep apart."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from ...core.body import forward_kinematics as fk
from ...core.body.motion import Motion
from ...core.body.skeleton import SIDES, Skeleton
from ...core.maths import angles, filters, quat
from .body import TOE_HEIGHT, ankle_of, put_ankles, starter_skeleton
from .conditions import Root, soft_contacts

Array = NDArray[np.floating[Any]]

_NEAREST = 0.112
"""Metres that feet keep apart."""
_RAISED = 0.12
"""A network answers with means, which lift toes less than people do; by this share, up to 1 cm."""
_DIGITS = 5
"""Of metres and quaternions that are kept: machines differ in the last bits."""


def clean(hips: Array, world: Array, root: Root, contacts: NDArray[np.bool_]) -> Motion:
    """The motion of hips `(T, 3)` and world rotations `(T, J, 4)` whose feet stand where `contacts` `(T, 2)` say."""
    body = starter_skeleton()
    places = fk.joint_positions(hips, world, body.offsets, body.parents)
    lengths = _leg_lengths(body, places)
    toes = np.stack([places[:, body.joint(f"toe.{s}")] for s in SIDES], axis=1)
    world = np.array(world)
    for side, letter in enumerate(SIDES):
        foot, toe = body.joint(f"foot.{letter}"), body.joint(f"toe.{letter}")
        yaw = np.unwrap(quat.heading(world[:, foot]))
        turn = quat.from_yaw(_eased(yaw[:, None], contacts[:, side])[:, 0] - yaw)
        world[:, foot], world[:, toe] = (
            quat.multiply(turn, world[:, foot]),
            quat.multiply(turn, world[:, toe]),
        )
        toes[:, side] = _eased(toes[:, side], contacts[:, side])
    toes[..., 2] += _RAISED * np.clip(toes[..., 2] - TOE_HEIGHT, 0.0, 0.08)
    toes = _apart(toes, root, contacts)
    for side in (0, 1):
        flat = np.array(toes[:, side])
        flat[contacts[:, side], 2] = TOE_HEIGHT
        toes[:, side, 2] = np.maximum(_follow(toes[:, side], flat, contacts[:, side])[:, 2], TOE_HEIGHT)
    ankles = np.stack(
        [ankle_of(body, s, toes[:, i], world[:, body.joint(f"foot.{s}")]) for i, s in enumerate(SIDES)],
        axis=1,
    )
    places = (
        places + (0.0, 0.0, 1.0) * _lift(body, places, ankles, lengths, contacts, root.fps)[:, None, None]
    )
    world = put_ankles(body, places, world, ankles)
    local = np.round(fk.local_rotations(quat.continuous(world), body.parents), _DIGITS)
    return Motion(body, root.fps, np.round(places[:, 0], _DIGITS), quat.normalize(local))


def _leg_lengths(body: Skeleton, places: Array) -> Array:
    """`(T, 2)` from thigh to ankle."""
    return np.stack(
        [
            np.linalg.norm(places[:, body.joint(f"foot.{s}")] - places[:, body.joint(f"thigh.{s}")], axis=-1)
            for s in SIDES
        ],
        axis=1,
    )


def _runs(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(np.int8), [0]])))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def _eased(values: Array, stands: NDArray[np.bool_]) -> Array:
    """`values` `(T, D)`, held at their mean while the foot stands."""
    held = np.array(values)
    for start, stop in _runs(stands):
        held[start:stop] = np.median(values[start:stop], axis=0)
    return _follow(values, held, stands)


def _follow(values: Array, held: Array, stands: NDArray[np.bool_]) -> Array:
    """`held` where the foot stands; between, `values` with the difference eased from one stand to the next."""
    if not stands.any():
        return values
    at = np.arange(len(values))
    known = np.flatnonzero(stands)
    after = np.searchsorted(known, at)
    a, b = known[np.maximum(after - 1, 0)], known[np.minimum(after, len(known) - 1)]
    t = np.clip((at - a) / np.maximum(b - a, 1), 0.0, 1.0)
    t = (t * t * (3.0 - 2.0 * t))[:, None]
    off = held - values
    return np.where(stands[:, None], held, values + off[a] + t * (off[b] - off[a]))


def _apart(toes: Array, root: Root, contacts: NDArray[np.bool_]) -> Array:
    """Toes `(T, 2, 3)` that keep the feet's distance and do not cross.

    A foot that swings makes way for one that stands; stands move as wholes.
    """
    out = np.array(toes)
    right = angles.turn(np.array([1.0, 0.0]), root.yaws)
    alike = contacts[:, 0] == contacts[:, 1]
    for _ in range(8):
        apart = angles.turn(out[:, 1, :2] - out[:, 0, :2], -root.yaws)
        lack = 1.1 * np.maximum(np.sqrt(np.maximum(_NEAREST**2 - apart[:, 1] ** 2, 0.0)) - apart[:, 0], 0.0)
        if not lack.any():
            break
        for side, sign in ((0, -1.0), (1, 1.0)):
            own = lack * np.where(alike, 0.5, np.where(contacts[:, side], 0.0, 1.0))
            push = sign * filters.gaussian(_widest(own, round(0.05 * root.fps)), 0.03 * root.fps)
            moved = np.array(out[:, side])
            moved[:, :2] += push[:, None] * right
            held = np.array(moved)
            for start, stop in _runs(contacts[:, side]):
                worst = start + int(np.argmax(own[start:stop]))
                held[start:stop, :2] = out[start:stop, side, :2] + sign * own[worst] * right[worst]
            out[:, side] = _follow(moved, held, contacts[:, side])
    return out


def _widest(values: Array, half: int) -> Array:
    """The running maximum over `half` frames to either side."""
    return np.max(sliding_window_view(np.pad(values, half, mode="edge"), 2 * half + 1), axis=-1)


def _lift(
    body: Skeleton, places: Array, ankles: Array, lengths: Array, contacts: NDArray[np.bool_], fps: float
) -> Array:
    """Metres `(T,)` to raise the hips so that legs that stand are as long as the model has them, and all legs reach."""
    thighs = np.stack([places[:, body.joint(f"thigh.{s}")] for s in SIDES], axis=1)
    flat = np.sum((ankles - thighs)[..., :2] ** 2, axis=-1)

    def heights(length: Array | float) -> Array:
        return ankles[..., 2] + np.sqrt(np.maximum(length**2 - flat, 0.05)) - thighs[..., 2]

    weight = soft_contacts(contacts, fps) + 0.02
    wanted = np.sum(weight * heights(lengths), axis=1) / weight.sum(axis=1)
    wanted = filters.gaussian(wanted, 0.04 * fps)
    over = np.maximum(wanted - heights(0.998 * body.leg_length()).min(axis=1), 0.0)
    return wanted - filters.gaussian(_widest(over, round(0.08 * fps)), 0.04 * fps)

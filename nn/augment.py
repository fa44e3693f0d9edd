"""Other people and other rigs from the takes there are: windows altered so that their true body yaw stays
known.

What a predictor must not depend on is made random here: the side a thing happens on, the person's size, how
a headset sits and a controller is held, where the eyes wander, tracker noise, and hands that lose tracking.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core.maths import quat
from .windows import FACING, POSITIONS, ROTATIONS, TRACKED

Array = NDArray[np.floating[Any]]
Float = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Augmentation:
    """How far things are varied; 0 leaves them alone."""

    stretch: float = 0.2
    """Time runs up to this share faster or slower."""
    size: float = 0.05
    """Deviation of the head height's error, share."""
    headset: float = 0.02
    """Deviation of the place of the head joint in the headset, head heights."""
    headset_turn: float = 0.08
    """Deviation of the headset's tilt, radians."""
    grip: float = 0.02
    """Deviation of the place of the hand joint in the controller, head heights."""
    grip_turn: float = 0.2
    """Deviation of the controller's turn in the hand, radians."""
    look: float = 0.3
    """Deviation of the extra angles that the head looks aside by, radians."""
    noise: float = 0.002
    """Deviation of each position, head heights."""
    noise_turn: float = 0.01
    """Deviation of each rotation, radians."""
    lost: float = 0.06
    """Probability for each hand that it is lost: for all of the window, or from or to a random moment."""


def augment(windows: Float, offsets: Array, how: Augmentation, rng: np.random.Generator) -> Float:
    """Altered copies of windows `(N, S, 31)`; the body's true yaw stays what it was.

    Args:
        windows: `(N, S, 31)` rows as from `windows.take_windows`.
        offsets: `(S,)` seconds of the samples, for what changes within a window.
        how: the strengths.
        rng: the source of chance.
    """
    windows = windows.copy()
    count, samples = windows.shape[:2]
    windows[..., POSITIONS] *= rng.normal(1.0, how.size, (count, 1, 1)).astype(np.float32)
    windows[..., POSITIONS] += np.float32(how.noise) * _normal((count, samples, 9), rng)
    matrices = _matrices(windows)
    _look_aside(windows, matrices, offsets, how.look, rng)
    matrices = _remount(windows, matrices, how, rng)
    windows[..., ROTATIONS] = np.moveaxis(matrices[..., :2], (1, 4), (2, 3)).reshape(count, samples, 18)
    windows[..., ROTATIONS] += np.float32(how.noise_turn) * _normal((count, samples, 18), rng)
    _lose(windows, offsets, how.lost, rng)
    return windows


def _normal(shape: tuple[int, ...], rng: np.random.Generator) -> Float:
    """Normal noise that repeats itself every few thousand numbers, which is as good here and much faster."""
    size = int(np.prod(shape))
    return np.resize(rng.standard_normal(4999, np.float32), size).reshape(shape)


def _matrices(windows: Float) -> Float:
    """Rotation matrices `(N, 3, S, 3, 3)` of the three trackers."""
    columns = np.moveaxis(windows[..., ROTATIONS].reshape(*windows.shape[:2], 3, 2, 3), (2, 3), (1, 4))
    x, y = columns[..., 0], columns[..., 1]
    out = np.empty((*x.shape, 3), dtype=np.float32)
    out[..., :2] = columns
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        out[..., i, 2] = x[..., j] * y[..., k] - x[..., k] * y[..., j]
    return out


def _remount(windows: Float, matrices: Float, how: Augmentation, rng: np.random.Generator) -> Float:
    """Fix the devices a little otherwise to head and hands, one way for the whole of each window."""
    count, _, samples = matrices.shape[:3]
    turn = np.array([how.headset_turn, how.grip_turn, how.grip_turn])[:, None]
    place = np.array([how.headset, how.grip, how.grip])[:, None]
    turns = quat.to_matrix(quat.from_rotation_vector(rng.normal(0.0, 1.0, (count, 3, 3)) * turn))
    offsets = rng.normal(0.0, 1.0, (count, 3, 3)) * place
    fixture = np.concatenate([turns, offsets[..., None]], axis=-1).astype(np.float32)
    # one product for all samples of a window: they share the fixture
    moved = (matrices.reshape(count, 3, samples * 3, 3) @ fixture).reshape(count, 3, samples, 3, 4)
    windows[..., POSITIONS] += np.swapaxes(moved[..., 3], 1, 2).reshape(count, samples, 9)
    forward = moved[:, 0, :, :2, 1]
    length = np.linalg.norm(forward, axis=-1, keepdims=True)
    # where the headset looks straight up or down its projected forward says nothing: keep what the heading
    # said
    windows[..., FACING] = np.where(length > 0.15, forward / np.maximum(length, 0.15), windows[..., FACING])
    return moved[..., :3]


def _look_aside(
    windows: Float, matrices: Float, offsets: Array, angle: float, rng: np.random.Generator
) -> None:
    """Turn the head about the vertical by a constant angle and by one that comes or goes in the window."""
    count = len(windows)
    first, second = rng.normal(0.0, angle, (2, count, 1))
    middle = rng.uniform(offsets[0], offsets[-1], (count, 1))
    seconds = rng.uniform(0.05, 0.3, (count, 1))
    yaw = first + second * np.tanh((offsets - middle) / seconds)
    c, s = np.cos(yaw).astype(np.float32), np.sin(yaw).astype(np.float32)
    x, y = windows[..., 27].copy(), windows[..., 28].copy()
    windows[..., 27], windows[..., 28] = c * x - s * y, s * x + c * y
    c, s = c[..., None], s[..., None]
    x, y = matrices[:, 0, :, 0].copy(), matrices[:, 0, :, 1].copy()
    matrices[:, 0, :, 0], matrices[:, 0, :, 1] = c * x - s * y, s * x + c * y


def _lose(windows: Float, offsets: Array, probability: float, rng: np.random.Generator) -> None:
    """Mark hands as lost, in place."""
    shape = (len(windows), 1, 2)
    lost = rng.random(shape) < probability
    whole = rng.random(shape) < 0.6
    edge = rng.uniform(offsets[0], offsets[-1], shape)
    before = rng.random(shape) < 0.5
    moments = offsets[None, :, None]
    part = np.where(before, moments < edge, moments > edge)
    windows[..., TRACKED] *= (~(lost & (whole | part))).astype(np.float32)

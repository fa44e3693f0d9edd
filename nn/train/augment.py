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

from ...core.maths import angles, quat
from ...core.recording.windows import FACING, POSITIONS, ROTATIONS, TRACKED

Array = NDArray[np.floating[Any]]
Float = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Augmentation:
    """How far things are varied; 0 leaves them alone."""

    stretch: float = 0.2
    """Time runs up to this share faster or slower."""
    mix: float = 0.3
    """Probability for each hand that it does what it did in another window."""
    size: float = 0.05
    """Deviation of the head height's error, share."""
    headset: float = 0.02
    """Deviation of the place of the head joint in the headset, head heights."""
    headset_turn: float = 0.08
    """Deviation of the headset's tilt, radians."""
    grip: float = 0.02
    """Deviation of the place of the hand joint in the controller, head heights."""
    grip_turn: float = 0.4
    """Deviation of the controller's turn in the hand, radians."""
    turn: float = 0.7
    """Deviation of the speed at which the path is bent, rad/s."""
    look: float = 0.3
    """Deviation of the extra angles that the head looks aside by, radians."""
    frame: float = 0.25
    """Half the windows are seen not in the headset's axes but in some this near to the body's, radians."""
    noise: float = 0.002
    """Deviation of each position, head heights."""
    noise_turn: float = 0.01
    """Deviation of each rotation, radians."""
    lost: float = 0.06
    """Probability for each hand that it is lost: for all of the window, or from or to a random moment."""


def mix_hands(
    windows: Float, yaws: Array, how: Augmentation, rng: np.random.Generator
) -> tuple[Float, NDArray[np.intp]]:
    """Windows `(N, S, 31)` in which some hands do what that hand did in another window.

    A hand is moved with the body: from the head, in the axes of the body's true yaws `(N, S)` in radians. So
    a hand that waves says nothing of where the other one is.

    Returns:
        The windows, and from which one each hand comes `(N, 2)`.
    """
    count, samples = windows.shape[:2]
    out = windows.copy()
    other: NDArray[np.intp] = rng.permutation(count)
    turn = yaws - yaws[other]
    places = windows[..., POSITIONS].reshape(count, samples, 3, 3)
    columns = windows[..., ROTATIONS].reshape(count, samples, 3, 2, 3)
    source: NDArray[np.intp] = np.repeat(np.arange(count, dtype=np.intp)[:, None], 2, axis=1)
    for hand in (1, 2):
        chosen = rng.random((count,)) < how.mix
        to = np.flatnonzero(chosen)
        source[to, hand - 1] = other[to]
        reach = (places[:, :, hand] - places[:, :, 0])[:, :, None]
        vectors = np.concatenate([reach, columns[:, :, hand]], axis=2)[other[to]]
        vectors[..., :2] = angles.turn(vectors[..., :2], turn[to][..., None])
        out[to, :, 3 * hand : 3 * hand + 3] = places[to, :, 0] + vectors[:, :, 0]
        out[to, :, 9 + 6 * hand : 15 + 6 * hand] = vectors[:, :, 1:].reshape(len(to), samples, 6)
    return out, source


def augment(
    windows: Float, offsets: Array, how: Augmentation, rng: np.random.Generator
) -> tuple[Float, Float, Float]:
    """Altered copies of windows `(N, S, 31)`; the body's true yaw stays what it was.

    Args:
        windows: `(N, S, 31)` rows as from `windows.take_windows`.
        offsets: `(S,)` seconds of the samples, for what changes within a window.
        how: the strengths.
        rng: the source of chance.

    Returns:
        The windows; how much larger each body is `(N,)`; how far the point taken for its head joint lies from that
        joint at the moment itself `(N, 3)`, in the world's axes.
    """
    windows = windows.copy()
    count, samples = windows.shape[:2]
    size = rng.normal(1.0, how.size, (count, 1, 1)).astype(np.float32)
    windows[..., POSITIONS] *= size
    windows[..., POSITIONS] += np.float32(how.noise) * _normal((count, samples, 9), rng)
    matrices = _matrices(windows)
    _turn(windows, matrices, offsets, how, rng)
    matrices, moved = _remount(windows, matrices, how, rng)
    windows[..., ROTATIONS] = np.moveaxis(matrices[..., :2], (1, 4), (2, 3)).reshape(count, samples, 18)
    windows[..., ROTATIONS] += np.float32(how.noise_turn) * _normal((count, samples, 18), rng)
    _lose(windows, offsets, how.lost, rng)
    return windows, size[:, 0, 0], moved[:, int(np.argmin(np.abs(offsets)))]


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


def _remount(
    windows: Float, matrices: Float, how: Augmentation, rng: np.random.Generator
) -> tuple[Float, Float]:
    """Fix the devices a little otherwise to head and hands, one way for the whole of each window.

    Returns the new rotations, and how far the head's point moved `(N, S, 3)`.
    """
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
    return moved[..., :3], moved[:, 0, ..., 3]


def _turn(
    windows: Float, matrices: Float, offsets: Array, how: Augmentation, rng: np.random.Generator
) -> None:
    """Bend the path and look elsewhere, in place.

    The whole body turns as if the ground turned under it, by nothing in the middle of the window, where the
    truth is known; steps are made in the turned direction. The head turns on its own besides.
    """
    count = len(windows)
    bend = how.turn * (
        rng.normal(0.0, 1.0, (count, 1)) * offsets
        + 0.5 * rng.normal(0.0, 1.0, (count, 1)) * offsets * np.abs(offsets)
    )
    _bend(windows, offsets, bend)
    yaw = np.repeat(bend[:, None], 3, axis=1)
    yaw[:, 0] += _look(offsets, how.look, count, rng)
    c, s = np.cos(yaw).astype(np.float32), np.sin(yaw).astype(np.float32)
    x, y = windows[..., 27].copy(), windows[..., 28].copy()
    windows[..., 27], windows[..., 28] = c[:, 0] * x - s[:, 0] * y, s[:, 0] * x + c[:, 0] * y
    c, s = c[..., None], s[..., None]
    x, y = matrices[..., 0, :].copy(), matrices[..., 1, :].copy()
    matrices[..., 0, :], matrices[..., 1, :] = c * x - s * y, s * x + c * y


def _look(offsets: Array, angle: float, count: int, rng: np.random.Generator) -> Array:
    """Yaws `(N, S)` of a head that looks aside: one stays, a second comes or goes within the window."""
    first, second = rng.normal(0.0, angle, (2, count, 1))
    middle = rng.uniform(offsets[0], offsets[-1], (count, 1))
    return first + second * np.tanh((offsets - middle) / rng.uniform(0.05, 0.3, (count, 1)))


def _bend(windows: Float, offsets: Array, bend: Array) -> None:
    """Walk the head's path in directions turned by `bend` `(N, S)` radians, hands with it, in place."""
    places = windows[..., POSITIONS].reshape(*windows.shape[:2], 3, 3)
    head = places[:, :, 0, :2].copy()
    hands = places[:, :, 1:, :2] - head[:, :, None]
    steps = angles.turn(np.diff(head, axis=1), 0.5 * (bend[:, 1:] + bend[:, :-1]))
    path = np.concatenate([np.zeros((len(head), 1, 2)), np.cumsum(steps, axis=1)], axis=1)
    centre = int(np.argmin(np.abs(offsets)))
    path += head[:, centre : centre + 1] - path[:, centre : centre + 1]
    places[:, :, 0, :2] = path
    places[:, :, 1:, :2] = path[:, :, None] + angles.turn(hands, bend[..., None])
    windows[..., POSITIONS] = places.reshape(*windows.shape[:2], 9)


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

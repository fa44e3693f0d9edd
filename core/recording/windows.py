"""What a window of time shows: where head and hands were, and in a bake will be, around one moment.

Positions are shares of the standing head height, horizontally relative to the head's place at that moment,
in axes turned to a given yaw. So neither where someone stands, nor which way, nor how tall they are can
matter.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..maths import quat

Array = NDArray[np.floating[Any]]

POSITIONS, ROTATIONS, FACING, TRACKED = slice(0, 9), slice(9, 27), slice(27, 29), slice(29, 31)


@dataclass(frozen=True, slots=True, eq=False)
class WindowLayout:
    """When around the moment in question the window looks."""

    offsets: Array
    """`(S,)` seconds, increasing, with a 0 among them; none above 0 for a causal predictor."""
    rotations_every: int
    """Every n-th sample, counted from the moment outwards, carries the full rotations."""

    @property
    def causal(self) -> bool:
        """Whether the window needs nothing of the future."""
        return bool(self.offsets[-1] <= 0.0)

    @property
    def centre(self) -> int:
        """Index of the moment itself among the samples."""
        return int(np.argmin(np.abs(self.offsets)))

    @property
    def turning(self) -> NDArray[np.intp]:
        """Indices of the samples that carry rotations."""
        samples = np.arange(len(self.offsets))
        return samples[(samples - self.centre) % self.rotations_every == 0]

    @property
    def inputs(self) -> int:
        """Length of the input vector."""
        return 13 * len(self.offsets) + 18 * len(self.turning)

    @property
    def groups(self) -> tuple[slice, ...]:
        """Inputs that share one deviation: head positions, hand positions, facing, rotations, tracked
        flags."""
        s, r = len(self.offsets), len(self.turning)
        ends = np.cumsum([0, 3 * s, 6 * s, 2 * s, 2 * s, 18 * r])
        return tuple(slice(int(a), int(b)) for a, b in itertools.pairwise(ends))


LOOK_AHEAD = WindowLayout(np.round(np.arange(-10, 11) * 0.1, 3), 2)
"""One second to both sides in steps of 0.1 s, rotations every 0.2 s."""
CAUSAL = WindowLayout(
    -np.array(
        [3.0, 2.5, 2.1, 1.8, 1.5, 1.25, 1.05, 0.9, 0.75, 0.6, 0.5, 0.4, 0.3, 0.2, 0.15, 0.1, 0.05, 0.0]
    ),
    2,
)
"""The last three seconds, denser towards the moment itself."""


def stream(
    positions: Array, rotations: Array, valid: NDArray[np.bool_], head_height: float
) -> NDArray[np.float32]:
    """All that a window may need of each frame, in one row: `(T, 31)`.

    Nine positions over head height, eighteen numbers of rotation (two matrix columns of each), the two of
    the direction the headset faces on the ground, and for each hand 1 where it was tracked.

    Args:
        positions: `(T, 3, 3)` world positions of head, left and right hand, metres.
        rotations: `(T, 3, 4)` their world rotations since T-pose.
        valid: `(T, 3)` whether each was tracked.
        head_height: of the head joint when the wearer stands upright, metres.
    """
    frames = len(positions)
    yaw = quat.heading(rotations[:, 0])
    parts = (
        (positions / head_height).reshape(frames, 9),
        quat.to_sixd(rotations).reshape(frames, 18),
        np.stack([-np.sin(yaw), np.cos(yaw)], axis=-1),
        valid[:, 1:],
    )
    return np.concatenate(parts, axis=-1).astype(np.float32)


def take_windows(
    stream: NDArray[np.float32], times: Array, fps: float, layout: WindowLayout
) -> NDArray[np.float32]:
    """Rows `(N, S, 31)` at `times + offsets`, linear between frames and held at both ends.

    Args:
        stream: `(T, 31)`.
        times: `(N,)` seconds from the first frame.
        fps: rate of the stream.
        layout: the window.
    """
    place = np.clip((times[:, None] + layout.offsets) * fps, 0.0, len(stream) - 1.0)
    # a hair off a frame is on it: no rounding noise, and a causal window stays causal
    nearest = np.round(place)
    place = np.where(np.abs(place - nearest) < 1e-6, nearest, place)
    low = np.floor(place).astype(np.intp)
    high = np.minimum(low + 1, len(stream) - 1)
    share = (place - low)[..., None].astype(np.float32)
    if not np.any(share):
        return stream[low]
    return (stream[low] + (stream[high] - stream[low]) * share).astype(np.float32, copy=False)


def window_inputs(windows: Array, frame_yaws: Array, layout: WindowLayout) -> NDArray[np.float32]:
    """Input vectors `(N, layout.inputs)` of windows `(N, S, 31)` in axes turned to `frame_yaws` `(N,)`
    radians."""
    count, samples = windows.shape[:2]
    c = np.cos(frame_yaws).astype(np.float32)[:, None]
    s = np.sin(frame_yaws).astype(np.float32)[:, None]
    vectors = windows[..., :27].reshape(count, samples, 9, 3)
    places, turns = vectors[:, :, :3], vectors[:, layout.turning, 3:]
    tracked = windows[..., TRACKED]
    head = places[:, :, 0].copy()
    head[..., :2] -= head[:, layout.centre : layout.centre + 1, :2]
    head[..., 2] -= 1.0
    hands = (places[:, :, 1:] - places[:, :, :1]) * tracked[..., None]
    weight = np.ones((count, turns.shape[1], 6, 1), dtype=np.float32)
    weight[:, :, 2:] = np.repeat(tracked[:, layout.turning], 2, axis=-1)[..., None]
    parts = (
        _turned(head, c, s),
        _turned(hands, c[..., None], s[..., None]),
        _turned(windows[..., FACING], c, s),
        tracked,
        _turned(turns * weight, c[..., None], s[..., None]),
    )
    return np.concatenate([part.reshape(count, -1) for part in parts], axis=-1)


def mirror_inputs(inputs: Array, layout: WindowLayout) -> Array:
    """Input vectors `(N, layout.inputs)` of the mirror images of the same windows: left and right change
    places."""
    order, signs = _mirror_map(layout)
    return inputs[:, order] * signs


def _mirror_map(layout: WindowLayout) -> tuple[NDArray[np.intp], NDArray[np.float32]]:
    """Where each mirrored input comes from, and its sign."""
    samples, turns = len(layout.offsets), len(layout.turning)
    across = np.array([-1.0, 1.0, 1.0])
    # a rotation R becomes M R M with M = diag(-1, 1, 1): its first column turns about, then both are mirrored
    columns = np.broadcast_to(np.stack([-across, across]), (turns, 3, 2, 3))
    shapes = ((samples, 1, 3), (samples, 2, 3), (samples, 1, 2), (samples, 2, 1), (turns, 3, 2, 3))
    parts = (across, across, across[:2], np.ones(1), columns)
    order, signs, start = list[NDArray[np.intp]](), list[Array](), 0
    for shape, sign in zip(shapes, parts, strict=True):
        index = start + np.arange(np.prod(shape)).reshape(shape)
        swap = [0, 2, 1] if shape[1] == 3 else np.arange(shape[1])[::-1]
        order.append(index[:, swap].reshape(-1))
        signs.append(np.broadcast_to(sign, shape).reshape(-1))
        start += int(np.prod(shape))
    return np.concatenate(order), np.concatenate(signs).astype(np.float32)


def _turned(vectors: Array, c: Array, s: Array) -> Array:
    """Vectors `(..., 2 or 3)` seen from axes turned by the angle of cosine `c` and sine `s` `(...)`."""
    x, y = vectors[..., 0], vectors[..., 1]
    out = vectors.copy()
    out[..., 0], out[..., 1] = c * x + s * y, c * y - s * x
    return out

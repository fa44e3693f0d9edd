"""When each foot stands: one plant for a contact, or several with steps between where one cannot hold it.

The whole recording is known. A contact of the matched motion whose toe drifts farther than a foot may be from
it gets as few steps as possible, where they cost least: when the foot is near the motion's before and after,
while the other foot stands and bears the weight. Beside a step of the motion's own the foot may also come a
little later or leave a little earlier.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]
Flags = NDArray[np.bool_]
Spans = NDArray[np.intp]
"""`(N, 2)` first frames and ends, in order."""
_Known = dict[tuple[int, bytes], Spans]
"""Plants by the contact's first frame and the other foot's flags in it."""

SHORTEST_S = 0.1
"""A contact shorter than this holds no foot, a gap shorter than this lets none go."""
_STEP_S = 0.35
"""Time that a step is planned with."""
_GRID_S = 0.05
"""Where one plant cannot hold a contact, plants begin and end at multiples of this."""
_LONGEST_S = 120.0
"""They are no longer than this, lest the time to plan goes with the square of the contact's."""
# What a plan costs. Each second with the foot at the unlock distance costs 1.
_STEP = 4.0
_LATE_S = 0.15
"""Coming so much later or leaving so much earlier than the motion's foot, or stepping so much longer, costs 1;
twice as much 4."""
_ALONE = 4.0
"""A step with the other foot in the air."""
_LOADED = 1.0
"""A step with the whole weight on the foot."""


def plan_plants(
    paths: Sequence[Array], contacts: Flags, loads: Array, unlock_distance: float, fps: float
) -> list[Spans]:
    """When the left and the right foot stand.

    Args:
        paths: of both feet `(T, 3)`: the toe in the motion, metres.
        contacts: `(T, 2)` whether it is on the ground.
        loads: `(T, 2)` share of the weight on each foot.
        unlock_distance: metres a plant may be away from the toe.
        fps: frames per second.
    """
    spans = [_contacts(contacts[:, side], fps) for side in range(2)]
    plants = list(spans)
    known: list[_Known] = [{}, {}]
    # the second foot knows the first one's steps, which knew only its contacts: so the first once more
    for side in (0, 1, 0):
        other = _flags(plants[1 - side], len(contacts))
        plants[side] = _foot(
            paths[side], spans[side], other, loads[:, side], unlock_distance, fps, known[side]
        )
    return plants


def _contacts(flags: Flags, fps: float) -> Spans:
    """The contacts of one foot without flicker."""
    shortest = max(2, round(SHORTEST_S * fps))
    edges = np.flatnonzero(np.diff(flags, prepend=False, append=False))
    if len(edges) > 2:
        short = np.flatnonzero(edges[2::2] - edges[1:-1:2] < shortest)
        edges = np.delete(edges, np.concatenate([2 * short + 1, 2 * short + 2]))
    spans = edges.reshape(-1, 2)
    return spans[spans[:, 1] - spans[:, 0] >= shortest]


def _flags(spans: Spans, frames: int) -> Flags:
    edges = np.zeros(frames + 1, np.intp)
    edges[spans[:, 0]] = 1
    edges[spans[:, 1]] -= 1
    return np.cumsum(edges[:-1]) > 0


def frames_of(spans: Spans) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """All frames of spans one after the other, and where each span begins among them."""
    counts = spans[:, 1] - spans[:, 0]
    starts = np.cumsum(counts) - counts
    return np.repeat(spans[:, 0] - starts, counts) + np.arange(int(counts.sum())), starts


def _foot(
    path: Array, spans: Spans, other: Flags, load: Array, unlock_distance: float, fps: float, known: _Known
) -> Spans:
    """The plants of one foot; the `other` one stands in some frames `(T,)`."""
    if len(spans) == 0:
        return spans
    frames, starts = frames_of(spans)
    size = np.maximum.reduceat(path[frames], starts) - np.minimum.reduceat(path[frames], starts)
    out = list(spans[:, None])
    for i in np.flatnonzero(_beyond(size, unlock_distance)).tolist():
        first, stop = spans[i].tolist()
        cut = slice(first, stop)
        key = first, other[cut].tobytes()
        if key not in known:
            contact = _Contact(path[cut], ~other[cut], load[cut], unlock_distance, fps)
            known[key] = first + contact.divide(first == 0, stop == len(path))
        out[i] = known[key]
    return np.concatenate(out)


def _beyond(size: Array, unlock_distance: float) -> Flags:
    """Whether boxes of some size `(N, 3)` reach farther from their middle than a plant may be from the toe."""
    return np.linalg.norm(0.5 * size, axis=-1) > unlock_distance


class _Contact:
    """A contact that one plant cannot hold, to be divided at the least cost by dynamic programming.

    Plants begin and end at marks, evenly apart but for the last one.
    """

    def __init__(self, path: Array, alone: Flags, load: Array, unlock_distance: float, fps: float) -> None:
        stride = max(1, round(_GRID_S * fps))
        self.marks = np.append(np.arange(0, len(path), stride), len(path))
        self.stride = stride
        self.low = np.minimum.reduceat(path, self.marks[:-1])
        self.high = np.maximum.reduceat(path, self.marks[:-1])
        level = (path - path.mean(axis=0))[:, :2] / (max(unlock_distance, 1e-3) * np.sqrt(fps))
        self.x, self.y = self._sums(level[:, 0]), self._sums(level[:, 1])
        self.squares = self._sums(np.sum(level**2, axis=-1))
        self.alone, self.load = self._sums(alone.astype(np.float64)), self._sums(load)
        self.unlock_distance = unlock_distance
        self.fps = fps

    def _sums(self, values: Array) -> Array:
        """Sums `(M,)` over all frames before each mark of values `(N,)`."""
        return np.append(0.0, np.cumsum(values))[self.marks]

    def divide(self, at_start: bool, at_end: bool) -> Spans:
        """The plants.

        Args:
            at_start: the recording starts with this contact: to come late to it costs a step.
            at_end: it ends with it.
        """
        count = len(self.marks)
        longest = round(_LONGEST_S * self.fps) // self.stride
        farthest = np.minimum(self._farthest(), np.arange(count - 1) + longest)
        shortest, quickest = (
            max(2, round(SHORTEST_S * self.fps)),
            -(-round(_STEP_S * self.fps) // self.stride),
        )
        before, steps = self._steps(quickest, 2 * quickest)
        # the least cost up to a plant that ends at a mark, where that begins, and where the one before it ends
        ends, begin_of, end_before = np.full(count, np.inf), np.zeros(count, int), np.full(count, -1)
        begins = self._lateness(self.marks)
        begins[1:] += _STEP * at_start
        # a step takes so many blocks: as many beginnings depend on earlier ends alone
        for first in range(0, count - 1, quickest):
            i = np.arange(first, min(first + quickest, count - 1))
            costs = ends[before[i]] + steps[i]
            best = costs.argmin(axis=1)
            cost = costs[i - first, best]
            end_before[i] = np.where(cost < begins[i], before[i, best], -1)
            j = np.arange(first + 1, int(farthest[i].max()) + 1)
            costs = np.minimum(cost, begins[i])[:, None] + self._distance(i[:, None], j)
            short = self.marks[j] - self.marks[i, None] < shortest
            costs[short | (j > farthest[i, None])] = np.inf
            best = costs.argmin(axis=0)
            cost = costs[best, j - first - 1]
            begin_of[j] = np.where(cost < ends[j], i[best], begin_of[j])
            ends[j] = np.minimum(cost, ends[j])
        ends += self._lateness(self.marks[-1] - self.marks)
        ends[:-1] += _STEP * at_end
        out: list[list[int]] = []
        j = int(ends.argmin())
        while j >= 0 and np.isfinite(ends[j]):
            out.append([int(self.marks[begin_of[j]]), int(self.marks[j])])
            j = int(end_before[begin_of[j]])
        return np.array(out[::-1], np.intp).reshape(-1, 2)

    def _lateness(self, frames: NDArray[np.intp]) -> Array:
        return (frames / (_LATE_S * self.fps)) ** 2

    def _distance(self, i: NDArray[np.intp], j: NDArray[np.intp]) -> Array:
        """Costs of plants from marks i to marks j: squared distances of the toe from its mean."""
        x, y = self.x[j] - self.x[i], self.y[j] - self.y[i]
        frames = np.maximum(self.marks[j] - self.marks[i], 1)
        return self.squares[j] - self.squares[i] - (x * x + y * y) / frames

    def _steps(self, quickest: int, slowest: int) -> tuple[NDArray[np.intp], Array]:
        """Marks `slowest` to `quickest` blocks before each mark, and what steps from them cost."""
        to = np.arange(len(self.marks))[:, None]
        start = to - np.arange(slowest, quickest - 1, -1)
        outside, start = start < 0, np.maximum(start, 0)
        frames = np.maximum(self.marks[to] - self.marks[start], 1)
        alone, load = ((sums[to] - sums[start]) / frames for sums in (self.alone, self.load))
        slow = self._lateness(frames - round(_STEP_S * self.fps))
        return start, np.where(outside, np.inf, _STEP + slow + _ALONE * alone + _LOADED * load)

    def _farthest(self) -> NDArray[np.intp]:
        """The last mark to which a plant from each mark can hold the toe."""
        # boxes of 1, 2, 4 ... blocks; each mark goes on by the largest that fit
        boxes = [(self.low, self.high)]
        while 1 << len(boxes) <= len(self.low):
            (low, high), half = boxes[-1], 1 << (len(boxes) - 1)
            boxes.append((np.minimum(low[:-half], low[half:]), np.maximum(high[:-half], high[half:])))
        end = np.arange(len(self.low))
        low, high = np.full_like(self.low, np.inf), np.full_like(self.high, -np.inf)
        for k, (lows, highs) in reversed(list(enumerate(boxes))):
            at = np.minimum(end, len(lows) - 1)
            lower, higher = np.minimum(low, lows[at]), np.maximum(high, highs[at])
            fits = (end < len(lows)) & ~_beyond(higher - lower, self.unlock_distance)
            low, high = np.where(fits[:, None], lower, low), np.where(fits[:, None], higher, high)
            end += fits << k
        return end

"""Nearest feature vectors, exactly (paper, section 5.3): by matrix product or by a two-layer hierarchy of
boxes.

The cost of a frame is sum_j w_j (z_j - q_j)^2 over the normalised features, in double precision. Both ways
first rule frames out in single precision with a bound on its rounding, then compare what is left exactly, so
they return the same frame, the lowest of those that tie.
"""

from __future__ import annotations

import math
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..database.motion_database import FEATURE_COUNT, FEATURE_GROUPS, POSE, FeatureDatabase
from ..settings import BakeSettings

Array = NDArray[np.floating[Any]]
Rows = NDArray[np.intp]

MANY_FRAMES = 120_000
"""From this many frames on the hierarchy is the faster one; measured, see docs/matching.md."""

_SMALL, _LARGE = 16, 64
_FAN = _LARGE // _SMALL
_PROBES = 32
"""Large boxes that are looked into first, and as many small ones of theirs, for a bound on the cost."""
_ROUNDING = 40.0 * 2.0**-24
"""Times (|z| + |q|)^2: more than single precision can be off in any of the sums below (28 terms and their
inputs)."""


def feature_weights(settings: BakeSettings) -> Array:
    """The weight `(27,)` of each feature on its squared difference."""
    weights = np.empty(FEATURE_COUNT)
    for group, columns in FEATURE_GROUPS.items():
        if group == "trajectory_positions":
            weights[columns] = settings.weight_trajectory_positions
        elif group == "trajectory_directions":
            weights[columns] = settings.weight_trajectory_directions
        elif group == "hips_velocity":
            weights[columns] = settings.weight_hips
        else:
            weights[columns] = settings.weight_feet
    return weights


def trajectory_only(weights: Array) -> Array:
    """`weights` `(27,)` without the pose: for the first pose, which follows on none."""
    out = weights.copy()
    out[POSE] = 0.0
    return out


class Search(Protocol):
    """Finds frames of one feature database under fixed weights."""

    def nearest(self, query: Array, limit: float = np.inf) -> tuple[int, float]:
        """The frame of least cost and its cost; -1 where none costs less than `limit`.

        Args:
            query: `(27,)` normalised as the database is.
            limit: cost that has to be beaten, strictly.
        """
        ...

    def cost(self, query: Array, frame: int) -> float:
        """The cost of any frame, one that is never found included."""
        ...


def make_search(features: FeatureDatabase, weights: Array) -> Search:
    """The faster way for this many frames."""
    many = int(np.count_nonzero(features.trajectory_valid)) >= MANY_FRAMES
    return (BoxSearch if many else MatrixSearch)(features, weights)


class _Exact:
    """Costs in double precision, shared by both ways."""

    def __init__(self, features: FeatureDatabase, weights: Array) -> None:
        self._values = features.values
        self._weights = weights
        self._scale = np.sqrt(weights)
        self._frames: Rows = np.flatnonzero(features.trajectory_valid)

    def _scaled_rows(self) -> Array:
        """The frames that may be found, `(M, 27)` in single precision, each dimension times the root of its
        weight."""
        rows = (self._values[self._frames] * self._scale).astype(np.float32)
        self._radius = float(np.sqrt(np.max(np.einsum("ij,ij->i", rows, rows))))
        return rows

    def cost(self, query: Array, frame: int) -> float:
        """The cost of any frame, one that is never found included."""
        away = self._values[frame] - query
        return float(np.add.reduce(self._weights * (away * away)))

    def _costs(self, query: Array, frames: Rows) -> Array:
        away = self._values[frames] - query
        return np.add.reduce(self._weights * (away * away), axis=-1)

    def _best(self, query: Array, rows: Rows, limit: float) -> tuple[int, float]:
        """The cheapest of the ascending valid `rows`; -1 where none is below `limit`."""
        if len(rows) == 1:
            frame = int(self._frames[rows[0]])
            cost = self.cost(query, frame)
            return (frame, cost) if cost < limit else (-1, cost)
        frames = self._frames[rows]
        costs = self._costs(query, frames)
        best = int(costs.argmin())
        cost = float(costs[best])
        return (int(frames[best]), cost) if cost < limit else (-1, cost)

    def _slack(self, scaled: Array) -> float:
        return _ROUNDING * (self._radius + math.sqrt(scaled @ scaled)) ** 2


class PlainSearch(_Exact):
    """All costs in double precision: nothing to prepare, for a search that is done once."""

    def nearest(self, query: Array, limit: float = np.inf) -> tuple[int, float]:
        """The frame of least cost and its cost; -1 where none costs less than `limit`."""
        return self._best(query, np.arange(len(self._frames)), limit)


class MatrixSearch(_Exact):
    """|z|^2 - 2 z.q of all frames by one matrix product."""

    def __init__(self, features: FeatureDatabase, weights: Array) -> None:
        super().__init__(features, weights)
        rows = self._scaled_rows().astype(np.float64)
        self._columns = np.empty((FEATURE_COUNT + 1, len(rows)), dtype=np.float32)
        self._columns[:-1] = -2.0 * rows.T
        self._columns[-1] = np.einsum("ij,ij->i", rows, rows)
        self._query = np.ones(FEATURE_COUNT + 1, dtype=np.float32)
        self._scores = np.empty(len(rows), dtype=np.float32)

    def nearest(self, query: Array, limit: float = np.inf) -> tuple[int, float]:
        """The frame of least cost and its cost; -1 where none costs less than `limit`."""
        scaled = query * self._scale
        self._query[:-1] = scaled
        scores = np.dot(self._query, self._columns, out=self._scores)
        near = scores[scores.argmin()] + np.float32(2.0 * self._slack(scaled))
        return self._best(query, (scores <= near).nonzero()[0], limit)


class BoxSearch(_Exact):
    """Bounding boxes round 64 and round 16 frames that follow each other (Holden et al. 2020), in whole
    arrays.

    The distance to a box is never more than to a frame in it: boxes of 64 farther than the limit or than the
    best frame of the nearest boxes drop out, of the rest the boxes of 16, and the frames of what remains are
    compared.
    """

    def __init__(self, features: FeatureDatabase, weights: Array) -> None:
        super().__init__(features, weights)
        rows = self._scaled_rows()
        count = -(-len(rows) // _LARGE) * _LARGE
        # the last row fills the last box: a tie with itself, which the lower index wins
        self._order: Rows = np.minimum(np.arange(count), len(rows) - 1)
        rows = rows[self._order]
        small = rows.reshape(-1, _FAN, _SMALL, FEATURE_COUNT)
        self._low, self._high = small.min(axis=2), small.max(axis=2)
        # one row a dimension: numpy's inner loops then run along the boxes
        self._large_low = np.ascontiguousarray(self._low.min(axis=1).T)
        self._large_high = np.ascontiguousarray(self._high.max(axis=1).T)
        self._blocks = rows.reshape(-1, _SMALL, FEATURE_COUNT)

    def nearest(self, query: Array, limit: float = np.inf) -> tuple[int, float]:
        """The frame of least cost and its cost; -1 where none costs less than `limit`."""
        scaled = query * self._scale
        slack = 2.0 * self._slack(scaled)
        point = scaled.astype(np.float32)
        column = point[:, None]
        gap = np.maximum(self._large_low - column, column - self._large_high)
        np.maximum(gap, 0.0, out=gap)
        bounds = np.einsum("ij,ij->j", gap, gap)

        bound = limit + slack
        large = (bounds <= bound).nonzero()[0]
        if len(large) > _PROBES:
            probes, small = self._small_bounds(
                large[np.argpartition(bounds[large], _PROBES)[:_PROBES]], point
            )
            probes = probes[np.argpartition(small, _PROBES)[:_PROBES]]
            bound = min(bound, float(self._distances(probes, point).min()) + slack)
            large = large[bounds[large] <= bound]
        blocks, small = self._small_bounds(large, point)
        blocks = blocks[small <= bound]
        if len(blocks) == 0:
            return -1, np.inf
        distances = self._distances(blocks, point)
        near = (distances.ravel() <= float(distances.min()) + slack).nonzero()[0]
        rows = blocks[near // _SMALL] * _SMALL + near % _SMALL
        return self._best(query, self._order[rows], limit)

    def _small_bounds(self, large: Rows, point: Array) -> tuple[Rows, Array]:
        """The boxes of 16 within boxes of 64, ascending where those are, and their squared distances."""
        gap = np.maximum(self._low[large] - point, point - self._high[large])
        np.maximum(gap, 0.0, out=gap)
        blocks = (large[:, None] * _FAN + np.arange(_FAN)).ravel()
        return blocks, np.einsum("ijk,ijk->ij", gap, gap).ravel()

    def _distances(self, blocks: Rows, point: Array) -> Array:
        """Squared distances `(B, 16)` of the frames in boxes of 16."""
        away = self._blocks[blocks] - point
        return np.einsum("ijk,ijk->ij", away, away)

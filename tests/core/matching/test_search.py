from __future__ import annotations

import numpy as np
import pytest
from footwork.core.database.motion_database import FEATURE_GROUPS, FeatureDatabase
from footwork.core.matching.search import BoxSearch, MatrixSearch, feature_weights, trajectory_only
from footwork.core.settings import BakeSettings
from hypothesis import given, settings
from hypothesis import strategies as st


def features(values: np.ndarray, valid: np.ndarray) -> FeatureDatabase:
    return FeatureDatabase(values.astype(np.float32), np.zeros(27), np.ones(27), valid)


def brute_force(
    db: FeatureDatabase, weights: np.ndarray, query: np.ndarray, limit: float
) -> tuple[int, float]:
    """The definition, one frame after the other in exact sums."""
    best, least = -1, limit
    for frame in np.flatnonzero(db.trajectory_valid):
        cost = float(np.sum(weights * (db.values[frame].astype(np.float64) - query) ** 2))
        if cost < least:
            best, least = int(frame), cost
    return best, least


@st.composite
def cases(draw: st.DrawFn) -> tuple[FeatureDatabase, np.ndarray, np.ndarray, float]:
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    count = draw(st.integers(1, 400))
    kind = draw(st.sampled_from(["smooth", "noise", "ties", "constant"]))
    if kind == "smooth":
        values = np.cumsum(rng.normal(0, 0.1, (count, 27)), axis=0)
    elif kind == "noise":
        values = rng.normal(0, 1, (count, 27))
    elif kind == "ties":
        values = rng.integers(0, 2, (count, 27)) * np.r_[np.ones(2), np.zeros(25)]
    else:
        values = np.full((count, 27), 0.1)
    valid = rng.random(count) < draw(st.sampled_from([0.2, 1.0]))
    valid[rng.integers(count)] = True
    weights = rng.choice([0.0, 0.5, 1.0, 7.0], 27)
    scale = draw(st.sampled_from([0.0, 0.3, 1e4]))
    query = values[rng.integers(count)].astype(np.float32) + scale * rng.normal(0, 1, 27)
    limit = np.inf
    if draw(st.booleans()):
        limit = float(np.sum(weights * (values[rng.integers(count)].astype(np.float32) - query) ** 2))
    return features(values, valid), weights, query, limit


@given(cases())
@settings(max_examples=300, deadline=None)
def test_both_ways_find_what_brute_force_finds(case):
    db, weights, query, limit = case
    frame, cost = brute_force(db, weights, query, limit)
    for way in (MatrixSearch, BoxSearch):
        found, found_cost = way(db, weights).nearest(query, limit)
        assert found == frame, way
        if frame >= 0:
            assert found_cost == pytest.approx(cost, rel=1e-12)
            assert way(db, weights).cost(query, frame) == found_cost


def test_rounding_does_not_choose():
    # far from the query, single precision cannot tell these rows apart; one of them is nearer by a hair
    values = np.full((500, 27), 100.0, dtype=np.float32)
    values[137, 0] = np.nextafter(np.float32(100.0), np.float32(0.0))
    db = features(values, np.ones(500, dtype=bool))
    for way in (MatrixSearch, BoxSearch):
        assert way(db, np.ones(27)).nearest(np.full(27, -300.0))[0] == 137
        assert way(db, np.ones(27)).nearest(np.full(27, 100.0))[0] == 0


def test_frames_without_a_future_are_never_found():
    values = np.zeros((100, 27))
    values[50] = 3.0
    valid = np.arange(100) != 50
    for way in (MatrixSearch, BoxSearch):
        search = way(features(values, valid), np.ones(27))
        assert search.nearest(np.full(27, 3.0))[0] == 0
        assert search.cost(np.full(27, 3.0), 50) == 0.0


def test_weights_come_by_group():
    weights = feature_weights(
        BakeSettings(
            weight_trajectory_positions=2,
            weight_trajectory_directions=3,
            weight_feet=4,
            weight_hips=5,
        )
    )
    expected = {"trajectory_positions": 2, "trajectory_directions": 3, "hips_velocity": 5}
    for group, columns in FEATURE_GROUPS.items():
        assert set(weights[columns]) == {expected.get(group, 4)}
    assert (trajectory_only(weights) > 0).sum() == 12

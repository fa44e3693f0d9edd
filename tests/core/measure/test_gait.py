"""Figures of steps against motions whose answer is known in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from footwork.core.measure import gait

FPS = 60.0


def walk(
    seconds: float, phase: float, yaw: float, speed: float = 1.2, swing: float = 0.35, period: float = 1.1
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Two pendulums in antiphase under a root that goes straight on: ankles, roots, yaws."""
    t = np.arange(round(seconds * FPS)) / FPS
    forward, left = np.array([-np.sin(yaw), np.cos(yaw)]), np.array([-np.cos(yaw), -np.sin(yaw)])
    roots = np.array([0.7, -2.0]) + speed * t[:, None] * forward
    ankles = np.zeros((len(t), 2, 3))
    for i, sign in enumerate((1.0, -1.0)):
        out = sign * swing * np.sin(2.0 * np.pi * t / period + phase)
        ankles[:, i, :2] = roots + out[:, None] * forward + sign * 0.1 * left
        ankles[:, i, 2] = 0.08
    return ankles, roots, np.full(len(t), yaw)


def agreement(phase: float, **more: float) -> float:
    """Of a walk with this lag beside the true one, in a direction of its own."""
    truth = walk(20.0, 0.3, 0.8, **more)
    mine = walk(20.0, 0.3 + phase, 0.8, speed=more.get("speed", 1.2), swing=0.2)
    return gait.phase_agreement(mine[0], *truth, FPS)


@pytest.mark.parametrize(("lag", "share"), [(0.0, 1.0), (0.4, 1.0), (-0.4, 1.0), (2.4, 0.0), (np.pi, 0.0)])
def test_two_pendulums_agree_as_their_lag_says(lag: float, share: float) -> None:
    assert agreement(lag) == share


def test_over_whole_periods_the_correlation_is_the_cosine_of_the_lag() -> None:
    for lag in (0.0, 0.7, 1.3, 2.0, np.pi):
        truth = walk(8.0, 0.0, -2.1, period=gait.PHASE_WINDOW_S)
        mine = walk(8.0, lag, -2.1, period=gait.PHASE_WINDOW_S, swing=0.1)
        found = gait.phase_correlations(mine[0], *truth, FPS)
        assert len(found) == (480 - 48) // 6 + 1
        np.testing.assert_allclose(found, np.cos(lag), atol=1e-6)


def test_only_windows_in_which_the_user_walks_count() -> None:
    assert np.isnan(agreement(0.0, speed=0.29))
    assert agreement(0.0, speed=0.31) == 1.0
    truth, half = walk(10.0, 0.0, 0.3, speed=0.4), walk(10.0, 0.0, 0.3, speed=0.2)
    assert gait.phase_agreement(truth[0], *truth, FPS, size=0.5) == 1.0
    assert np.isnan(gait.phase_agreement(truth[0], *truth, FPS, size=1.4))
    assert gait.phase_agreement(half[0], *half, FPS, size=0.5) == 1.0


def test_frozen_legs_agree_with_nothing() -> None:
    ankles, roots, yaws = walk(10.0, 0.0, 1.0)
    frozen = ankles.copy()
    frozen[..., :2] = roots[:, None] + np.array([[0.1, 0.3], [-0.1, 0.2]])
    assert gait.phase_agreement(frozen, ankles, roots, yaws, FPS) == 0.0


def test_legs_of_another_rhythm_reach_about_a_third() -> None:
    truth, mine = walk(300.0, 0.0, 0.4), walk(300.0, 0.0, 0.4, period=0.97)
    assert 0.25 < gait.phase_agreement(mine[0], *truth, FPS) < 0.42


def test_too_short_a_motion_has_no_windows() -> None:
    assert np.isnan(
        gait.phase_agreement(*(part[:40] for part in (walk(1.0, 0.0, 0.0)[0], *walk(1.0, 0.0, 0.0))), FPS)
    )


def test_a_step_is_a_foot_that_was_away_and_stands_again() -> None:
    standing = np.ones((300, 2), dtype=bool)
    toes = np.zeros((300, 2, 3))
    # left: a step of 0.4 m, a shuffle of 4 cm, a lift of 10 cm that comes down where it was
    for start, stop, way, lift in ((40, 60, 0.4, 0.05), (100, 110, 0.04, 0.0), (200, 221, 0.0, 0.1)):
        standing[start:stop, 0] = False
        share = np.linspace(0.0, 1.0, stop - start)
        toes[start:stop, 0, 0] += way * share
        toes[start:stop, 0, 2] += lift * np.sin(np.pi * share)
        toes[stop:, 0, 0] += way
    found = gait.plants(toes, standing)
    assert np.flatnonzero(found[:, 0]).tolist() == [60, 221] and not found[:, 1].any()
    assert np.flatnonzero(gait.plants(toes, standing, 0.03)[:, 0]).tolist() == [60, 110, 221]
    # in the air at either end it makes none
    standing[:5], standing[-5:] = False, False
    assert gait.plants(toes, standing).sum() == 2


def test_each_step_has_one_partner_of_its_own_foot_at_most() -> None:
    mine, true = np.zeros((2, 100, 2), dtype=bool)
    mine[[10, 14, 50, 90], 0] = True
    true[[12, 58, 91], 0], true[50, 1] = True, True
    left = gait.unmatched(mine, true, 5)
    assert np.flatnonzero(left[:, 0]).tolist() == [14, 50] and not left[:, 1].any()
    assert not gait.unmatched(true, true, 0).any()


def test_a_head_that_gets_nowhere_rests_however_it_nods() -> None:
    t = np.arange(600) / FPS
    heads = np.stack([0.04 * np.sin(2.0 * np.pi * t), np.maximum(t - 5.0, 0.0) * 0.8], axis=-1)
    rests = gait.resting(heads, FPS)
    assert rests[:260].all() and not rests[320:].any()
    assert not gait.resting(heads, FPS, 0.1)[320:].any() and gait.resting(heads, FPS, 6.0).all()

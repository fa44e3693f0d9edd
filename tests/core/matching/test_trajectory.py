from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.errors import InputError
from footwork.core.matching.trajectory import (
    causal_trajectory,
    look_ahead_trajectory,
    make_trajectory,
)
from footwork.core.settings import BakeSettings
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation, Slerp

FPS = 60.0


def walk(seed: int, count: int = 240) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    path = np.cumsum(np.cumsum(rng.normal(0, 0.002, (count, 2)), axis=0), axis=0)
    return path, np.cumsum(rng.normal(0, 0.05, count))


def test_exponential_velocity_is_the_papers_recurrence():
    path, yaws = walk(1)
    beta = 4.6
    plan = causal_trajectory(path, yaws, FPS, beta, spring=False)
    measured = np.diff(path, axis=0) * FPS
    measured = np.concatenate([measured[:1], measured])
    share = beta / FPS
    # v_{n+1} = v_n + beta (v^_n - v_n) dt from rest on the first measurement
    expected, _ = lfilter([share], [1, share - 1], measured, axis=0, zi=(1 - share) * measured[:1])
    np.testing.assert_allclose(plan.velocities, expected, atol=1e-12)


def test_positions_are_extrapolated_by_thirds_of_a_second():
    path, yaws = walk(2)
    plan = causal_trajectory(path, yaws, FPS, 4.6, spring=True)
    for k in range(3):
        np.testing.assert_allclose(
            plan.future_positions[:, k], path + plan.velocities * (k + 1) / 3, atol=1e-12
        )


def test_exponential_directions_are_repeated_slerps():
    yaws = np.array([0.0, 2.5, 2.5, 1.0])
    share = 4.6 / FPS
    plan = causal_trajectory(np.zeros((4, 2)), yaws, FPS, 4.6, spring=False)

    def slerp(start: float, goal: float) -> float:
        pair = Rotation.from_rotvec([[0, 0, start], [0, 0, goal]])
        return float(Slerp([0, 1], pair)(share).as_rotvec()[2])

    facing = 0.0
    for n, goal in enumerate(yaws):
        facing = slerp(facing, goal)
        ahead = facing
        for k in range(3):
            for _ in range(20):
                ahead = slerp(ahead, goal)
            assert plan.future_yaws[n, k] == pytest.approx(ahead, abs=1e-9)


def test_springs_solve_their_differential_equation():
    beta, count = 5.0, 40
    path, yaws = walk(3, count)
    plan = causal_trajectory(path, yaws, FPS, beta, spring=True)
    measured = np.diff(path[:, 0]) * FPS
    measured = np.concatenate([measured[:1], measured])

    def integrate(goals: np.ndarray, state: list[float], seconds: float) -> tuple[np.ndarray, np.ndarray]:
        states = []
        for goal in goals:
            move = solve_ivp(
                lambda _, s, goal=goal: [s[1], -2 * beta * s[1] - beta**2 * (s[0] - goal)],
                (0, seconds),
                state,
                rtol=1e-9,
                atol=1e-11,
            )
            state = move.y[:, -1].tolist()
            states.append(state)
        return np.array(states).T

    speed, _ = integrate(measured, [measured[0], 0], 1 / FPS)
    np.testing.assert_allclose(plan.velocities[:, 0], speed, atol=1e-7)
    facing, rate = integrate(yaws, [yaws[0], 0], 1 / FPS)
    for n in (1, 17, count - 1):
        for k in range(3):
            ahead, _ = integrate(yaws[n : n + 1], [facing[n], rate[n]], (k + 1) / 3)
            assert plan.future_yaws[n, k] == pytest.approx(ahead[0], abs=1e-6)


def test_steady_walk_predicts_its_own_future():
    times = np.arange(600) / FPS
    path = times[:, None] * np.array([0.3, -1.2])
    for spring in (True, False):
        plan = causal_trajectory(path, np.full(600, 0.5), FPS, 4.6, spring=spring)
        np.testing.assert_allclose(plan.future_positions[400, 2], path[460], atol=1e-6)
        np.testing.assert_allclose(plan.future_yaws, 0.5, atol=1e-12)
    plan = look_ahead_trajectory(path, np.full(600, 0.5), FPS)
    np.testing.assert_allclose(plan.future_positions[:500, 1], path[40:540], atol=1e-9)
    np.testing.assert_allclose(plan.velocities, np.broadcast_to([0.3, -1.2], (600, 2)), atol=1e-9)


def test_look_ahead_reads_the_recorded_future_and_holds_its_end():
    path, yaws = walk(4)
    plan = look_ahead_trajectory(path, yaws, FPS)
    # the present is not smoothed: alpha is measured from the body itself
    np.testing.assert_array_equal(plan.targets, path)
    np.testing.assert_allclose(plan.future_positions[-1], np.broadcast_to(path[-1], (3, 2)), atol=1e-9)
    np.testing.assert_allclose(plan.future_yaws[-1], yaws[-1], atol=1e-9)
    np.testing.assert_allclose(plan.future_positions[:-60, 2], plan.future_positions[40:-20, 0], atol=1e-12)


@given(st.integers(0, 50), st.floats(-3, 3), st.sampled_from(["causal", "look-ahead"]))
def test_turning_the_world_turns_the_trajectory(seed: int, angle: float, form: str):
    path, yaws = walk(seed, 80)
    settings = replace(BakeSettings(), trajectory=form)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    here = make_trajectory(path, yaws, FPS, settings)
    there = make_trajectory(path @ turn + 5.0, yaws + angle, FPS, settings)
    np.testing.assert_allclose(there.future_positions, here.future_positions @ turn + 5.0, atol=1e-9)
    np.testing.assert_allclose(there.velocities, here.velocities @ turn, atol=1e-9)
    difference = there.future_yaws - here.future_yaws - angle
    np.testing.assert_allclose(np.sin(difference), 0, atol=1e-9)
    np.testing.assert_allclose(np.cos(difference), 1, atol=1e-9)


@pytest.mark.parametrize("form", ["causal", "look-ahead"])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_shortest_recordings(form: str, count: int):
    plan = make_trajectory(
        np.ones((count, 2)), np.zeros(count), FPS, replace(BakeSettings(), trajectory=form)
    )
    np.testing.assert_allclose(plan.future_positions, 1.0)


def test_full_turns_of_the_prediction_do_not_matter():
    path, yaws = walk(6)
    wrapped = (yaws + np.pi) % (2 * np.pi) - np.pi
    settings = BakeSettings()
    a, b = make_trajectory(path, yaws, FPS, settings), make_trajectory(path, wrapped, FPS, settings)
    np.testing.assert_allclose(np.diff(a.future_yaws, axis=0), np.diff(b.future_yaws, axis=0), atol=1e-9)


def test_bad_input_is_refused_in_words():
    with pytest.raises(InputError, match="no frames"):
        make_trajectory(np.zeros((0, 2)), np.zeros(0), FPS, BakeSettings())
    path = np.zeros((9, 2))
    path[7, 1] = np.nan
    with pytest.raises(InputError, match=r"frame 7.*not finite"):
        make_trajectory(path, np.zeros(9), FPS, BakeSettings())

"""Feet on slopes and steps whose heights are known in closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.body.edit import cut
from footwork.core.body.legs import legs_of
from footwork.core.body.motion import Motion
from footwork.core.body.skeleton import SIDES
from footwork.core.body.toes import toe_places, toe_positions
from footwork.core.database.contacts import find_contacts
from footwork.core.maths import quat
from footwork.core.mocap.demo import demo_motion
from footwork.core.recording.simulate import simulate_recording
from footwork.core.rig.avatar import AvatarResult, animate
from footwork.core.rig.ground import Ground, _Foot, _Knots, _stands
from footwork.core.settings import BakeSettings
from hypothesis import given, settings
from hypothesis import strategies as st

USER = cut(demo_motion("visit", seed=0), 0, 420)
CONTACTS = find_contacts(toe_positions(USER), USER.fps)
RECORDING = simulate_recording(USER, "user")


def bake(ground: Ground | None, contacts: np.ndarray = CONTACTS, **options: object) -> AvatarResult:
    chosen = replace(BakeSettings(), **options)
    return animate(USER, contacts, RECORDING, USER.skeleton, chosen, ground=ground)


FLAT = bake(None)
SOLE = float(USER.skeleton.tpose_positions()[toe_places(USER.skeleton)[0][0], 2])
"""Metres from the floor to a toe joint that stands on it."""


def plane(x: float, y: float, height: float = 0.0) -> Ground:
    normal = np.array([-x, -y, 1.0]) / np.sqrt(x * x + y * y + 1.0)
    return lambda points: (height + points @ np.array([x, y]), np.tile(normal, (len(points), 1)))


def kerb(axis: int, edge: float, height: float) -> Ground:
    up = np.array([0.0, 0.0, 1.0])
    return lambda points: (np.where(points[:, axis] > edge, height, 0.0), np.tile(up, (len(points), 1)))


def tips(motion: Motion) -> np.ndarray:
    joints, _ = toe_places(motion.skeleton)
    positions, rotations = motion.forward()
    return positions[:, joints] + quat.rotate(rotations[:, joints], motion.skeleton.tips[joints])


def under(ground: Ground, points: np.ndarray) -> np.ndarray:
    return ground(points[..., :2].reshape(-1, 2))[0].reshape(points.shape[:-1])


def straightest(motion: Motion) -> float:
    """The greatest share of its length to which a leg is stretched."""
    positions, _ = motion.forward()
    ends = [[motion.skeleton.joint(f"{part}.{side}") for side in SIDES] for part in ("thigh", "foot")]
    ways = positions[:, ends[0]] - positions[:, ends[1]]
    return float(np.linalg.norm(ways, axis=-1).max()) / USER.skeleton.leg_length()


@given(st.floats(-100.0, 100.0))
@settings(max_examples=8)
def test_level_ground_lifts_everything_by_its_height(height: float) -> None:
    result = bake(plane(0.0, 0.0, height))
    assert np.abs(result.motion.positions - FLAT.motion.positions - [0.0, 0.0, height]).max() < 1e-9
    assert np.abs(result.motion.rotations - FLAT.motion.rotations).max() < 1e-6
    assert result.footing is not None and not result.footing.bare.any()
    assert FLAT.footing is None


@given(st.floats(-0.45, 0.45), st.floats(-0.45, 0.45))
@settings(max_examples=12)
def test_feet_stand_on_a_slope(x: float, y: float) -> None:
    ground = plane(x, y, 0.3)
    result = bake(ground)
    normal = ground(np.zeros((1, 2)))[1][0]
    toes, held = toe_positions(result.motion), result.contacts
    away = (toes[..., 2] - under(ground, toes)) * normal[2] - SOLE
    assert np.abs(away[held]).max() < 2e-3
    assert (
        away.min() > -5e-3 and (tips(result.motion)[..., 2] - under(ground, tips(result.motion))).min() > 0.0
    )
    still = np.linalg.norm(np.diff(toes, axis=0), axis=-1)[held[1:] & held[:-1]]
    assert still.max() < 1e-9
    # where a foot lies flat on the floor its sole is parallel to the slope
    for side in range(2):
        foot = USER.skeleton.joint(f"foot.{SIDES[side]}")
        up, sole = (
            quat.rotate(motion.forward()[1][:, foot], np.array([0.0, 0.0, 1.0]))
            for motion in (FLAT.motion, result.motion)
        )
        flat = held[:, side] & (up[:, 2] > np.cos(np.radians(0.5)))
        angle = np.degrees(np.arccos(np.clip(sole[flat] @ normal, -1.0, 1.0)))
        assert flat.sum() > 50 and np.percentile(angle, 75) < 1.0


@given(st.floats(-0.45, 0.45), st.floats(-0.45, 0.45))
@settings(max_examples=12)
def test_head_and_hands_rise_with_the_body_alone(x: float, y: float) -> None:
    ground = plane(x, y)
    result = bake(ground)
    assert result.footing is not None
    up = result.footing.lift[:, None] * np.array([0.0, 0.0, 1.0])
    for i, side in enumerate(SIDES):
        hand = USER.skeleton.joint(f"hand.{side}")
        reached = ~(result.unreachable | FLAT.unreachable)[:, i]
        raised = result.motion.forward()[0][reached, hand] - FLAT.motion.forward()[0][reached, hand]
        assert reached.mean() > 0.9 and np.abs(raised - up[reached]).max() < 1e-9
    head = result.motion.forward()[0][:, USER.skeleton.joint("head")]
    assert np.abs(head - FLAT.motion.forward()[0][:, USER.skeleton.joint("head")] - up).max() < 1e-9
    feet = under(ground, toe_positions(result.motion))
    lift = result.footing.lift
    assert (lift < feet.max(axis=-1) + 0.05).all() and (lift > feet.min(axis=-1) - 0.3).all()
    assert np.abs(np.diff(lift, 2)).max() * USER.fps**2 < 6.0
    assert straightest(result.motion) < 0.9985


@given(st.integers(0, 1), st.floats(-0.2, 2.0), st.sampled_from([0.08, 0.15, -0.15]))
@settings(max_examples=25)
def test_feet_go_over_a_kerb(axis: int, edge: float, height: float) -> None:
    ground = kerb(axis, edge, height)
    result = bake(ground)
    toes = toe_positions(result.motion)
    assert (toes[..., 2] - SOLE - under(ground, toes)).min() > -5e-3
    assert (tips(result.motion)[..., 2] - under(ground, tips(result.motion))).min() > -5e-3
    assert np.abs(toes[..., 2] - SOLE - under(ground, toes))[result.contacts].max() < 1e-3
    jerks = np.linalg.norm(np.diff(toes, 2, axis=0), axis=-1) * USER.fps**2
    assert jerks.max() < 200.0 and np.percentile(jerks, 99) < 75.0
    assert straightest(result.motion) < 1.0 - 1e-6


def test_a_foot_that_would_stand_in_a_step_stands_before_or_beside_it() -> None:
    places = toe_positions(FLAT.motion)
    first = places[FLAT.contacts[:, 0], 0][0]
    for axis, edge in ((1, first[1] + 0.09), (0, first[0] + 0.035)):
        ground = kerb(axis, edge, 0.2)
        toes = toe_positions(bake(ground).motion)
        start = toes[np.flatnonzero(FLAT.contacts[:, 0])[0], 0]
        assert start[2] == pytest.approx(SOLE, abs=1e-9)
        assert start[axis] < first[axis] - 0.009
        assert np.abs(np.delete(start - first, axis)).max() < 1e-9


def test_ground_that_is_too_steep_to_stand_on_counts_as_level() -> None:
    result = bake(plane(0.0, 1.2))
    foot = USER.skeleton.joint("foot.L")
    up = quat.rotate(result.motion.forward()[1][:, foot], np.array([0.0, 0.0, 1.0]))
    assert np.degrees(np.arccos(up[result.contacts[:, 0], 2])).min() < 1.0


def test_no_ground_is_a_floor_at_zero_and_told() -> None:
    def ground(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        there = points[:, 1] < 0.5
        return np.where(there, 0.0, np.nan), np.tile([0.0, 0.0, 1.0], (len(points), 1))

    result = bake(ground)
    assert np.abs(result.motion.positions - FLAT.motion.positions).max() < 1e-9
    assert result.footing is not None
    beyond = (toe_positions(FLAT.motion)[..., 1] >= 0.5).any(axis=-1)
    assert 0 < beyond.sum() < len(beyond)
    np.testing.assert_array_equal(result.footing.bare, beyond)


@pytest.mark.parametrize("contacts", [CONTACTS, np.zeros_like(CONTACTS)], ids=["contacts", "never"])
def test_feet_that_are_not_locked_follow_the_ground(contacts: np.ndarray) -> None:
    ground = plane(0.0, 0.2)
    result = bake(ground, contacts, feet="matched")
    flat = bake(None, contacts, feet="matched")
    toes, before = toe_positions(result.motion), toe_positions(flat.motion)
    over = toes[..., 2] - under(ground, toes) - before[..., 2]
    assert over.min() > -0.02 and over.max() < 0.15


def knots(levels: tuple[float, float], frames: int) -> _Knots:
    """A foot that leaves at the first frame and lands at the last."""
    before = np.zeros(frames + 1, np.intp)
    before[-1] = 1
    passed = np.linspace(0.0, 1.0, frames + 1)
    passed[-1] = 0.0
    ends = np.array([0, frames])
    return _Knots(ends, ends, np.array(levels), np.zeros((2, 3)), np.zeros((2, 2)), before, passed)


@pytest.mark.parametrize("share", [1.0, 0.6, 0.3])
def test_a_foot_goes_up_early_and_comes_down_late(share: float) -> None:
    u = np.linspace(0.0, 1.0, 101)

    def quintic(t: np.ndarray) -> np.ndarray:
        t = np.clip(t, 0.0, 1.0)
        return t**3 * (10.0 - 15.0 * t + 6.0 * t**2)

    up, down = knots((0.1, 0.4), 100)._way(share), knots((0.4, 0.1), 100)._way(share)
    np.testing.assert_allclose(up, 0.1 + 0.3 * quintic(u / share), atol=1e-12)
    np.testing.assert_allclose(down, up[::-1], atol=1e-12)


@pytest.mark.parametrize(("peak", "powers"), [(1 / 2, (3, 3)), (1 / 3, (3, 6)), (2 / 3, (6, 3))])
def test_a_foot_over_one_obstacle_is_highest_there_and_just_clears_it(
    peak: float, powers: tuple[int, int]
) -> None:
    needed = np.zeros(61)
    needed[round(60 * peak)] = 0.2
    found = knots((0.5, 0.5), 60).heights(0.5 + needed, 60.0)
    u = np.arange(61) / 60
    bump = u ** powers[0] * (1.0 - u) ** powers[1]
    np.testing.assert_allclose(found, 0.5 + 0.2 * bump / bump.max(), atol=1e-12)


@pytest.mark.parametrize("yaw", [0.0, 0.7, -2.0])
@pytest.mark.parametrize("edge", [0.024, 0.045, 0.083, 0.117, 0.131, 0.5])
def test_a_foot_is_moved_off_an_edge_the_least_way_that_helps(yaw: float, edge: float) -> None:
    leg = legs_of(USER.skeleton)[0]
    forward = np.array([-np.sin(yaw), np.cos(yaw)])
    place = np.array([1.3, -0.4])

    def ground(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        high = (points - place) @ forward > edge
        return np.where(high, 0.2, 0.0), np.tile([0.0, 0.0, 1.0], (len(points), 1))

    toes = np.tile([*place, leg.height], (20, 1))
    foot = _Foot(toes, np.tile(quat.from_yaw(np.array(yaw)), (20, 1)), leg)
    moved = _stands(foot, np.ones(20, np.bool_), ground, 60.0).moved
    # back until 8 cm before the tip are off it, or on until the toe is on it, by whole centimetres
    back = max(np.ceil((leg.to_tip[1] + 0.08 - edge) * 100.0 - 1e-9), 0.0)
    on = np.floor(edge * 100.0 + 1e-9) + 1.0
    centimetres = -back if back < on else on
    np.testing.assert_allclose(moved, [0.01 * centimetres * forward], atol=1e-12)

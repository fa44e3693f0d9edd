"""Foot locks on a demo walk, whose feet are planted by construction, and on feet that are made to slide."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.database.contacts import find_contacts, toe_positions
from footwork.core.mocap.skeleton import Motion
from footwork.core.rig.feet import place_feet, plan_feet
from footwork.core.rig.locks import Lock, clear, find_locks, offsets, take_turns

UNLOCK, HALFLIFE = 0.2, 0.1


@pytest.fixture(scope="module")
def contacts(walk: Motion) -> np.ndarray:
    return find_contacts(toe_positions(walk), walk.fps)


@pytest.fixture(scope="module")
def sliding(walk: Motion) -> Motion:
    """The walk on ice: the whole body is dragged to and fro, up and down."""
    time = np.arange(len(walk)) / walk.fps
    drag = np.stack(
        [0.1 * np.sin(1.9 * time), 0.08 * np.sin(2.7 * time), 0.01 * np.sin(3.3 * time) - 0.01], axis=-1
    )
    return replace(walk, positions=walk.positions + drag)


def lock(motion: Motion, contacts: np.ndarray) -> tuple[Motion, np.ndarray]:
    plan = plan_feet(motion, contacts, UNLOCK, HALFLIFE)
    return place_feet(motion, plan), plan.contacts


def higher(motion: Motion, height: float) -> Motion:
    return replace(motion, positions=motion.positions + np.array([0.0, 0.0, height]))


def speeds(toes: np.ndarray, fps: float) -> np.ndarray:
    return np.linalg.norm(np.diff(toes, axis=0), axis=-1) * fps


def test_a_planted_toe_does_not_move(sliding: Motion, contacts: np.ndarray) -> None:
    locked, held = lock(sliding, contacts)
    toes = toe_positions(locked)
    still = held[1:] & held[:-1]
    assert speeds(toe_positions(sliding), 60.0)[still].mean() > 0.1
    assert speeds(toes, 60.0)[still].max() < 1e-4
    height = locked.skeleton.tpose_positions()[locked.skeleton.joint("toe.L"), 2]
    np.testing.assert_allclose(toes[held][:, 2], height, atol=1e-6)
    assert held.mean() > 0.95 * contacts.mean()


def test_no_toe_and_no_tip_goes_below_the_floor(sliding: Motion, contacts: np.ndarray) -> None:
    locked, _ = lock(sliding, contacts)
    positions, rotations = locked.forward()
    toe = locked.skeleton.joint("toe.L")
    w, v = rotations[:, toe, :1], rotations[:, toe, 1:]
    tip = locked.skeleton.tips[toe]
    end = positions[:, toe] + tip + 2 * np.cross(v, np.cross(v, tip) + w * tip)
    assert toe_positions(locked)[..., 2].min() > 0.0
    assert end[:, 2].min() > -1e-3


def test_the_foot_comes_and_goes_without_a_jerk(sliding: Motion, contacts: np.ndarray) -> None:
    locked, _ = lock(sliding, contacts)
    bump = np.abs(np.diff(toe_positions(locked), n=2, axis=0)).max() * 60.0**2
    before = np.abs(np.diff(toe_positions(sliding), n=2, axis=0)).max() * 60.0**2
    assert bump < 1.6 * before


def test_a_walk_with_planted_feet_stays_as_it_is(walk: Motion, contacts: np.ndarray) -> None:
    locked, _ = lock(walk, contacts)
    away = np.linalg.norm(locked.forward()[0] - walk.forward()[0], axis=-1)
    assert np.median(away.max(axis=1)) < 0.005 and away.max() < 0.04
    np.testing.assert_array_equal(locked.positions, walk.positions)


def test_bones_keep_their_place_in_the_arms_and_trunk(sliding: Motion, contacts: np.ndarray) -> None:
    locked, _ = lock(sliding, contacts)
    legs = [
        j
        for j, role in enumerate(locked.skeleton.roles)
        if role.split(".")[0] in ("thigh", "shin", "foot", "toe")
    ]
    others = [j for j in range(len(locked.skeleton)) if j not in legs]
    np.testing.assert_array_equal(locked.rotations[:, others], sliding.rotations[:, others])


def test_knees_bend_forward(sliding: Motion, contacts: np.ndarray, world) -> None:
    locked, _ = lock(sliding, contacts)
    for side in "LR":
        hip, knee, ankle = (world(locked, f"{part}.{side}")[0] for part in ("thigh", "shin", "foot"))
        line = (ankle - hip) / np.linalg.norm(ankle - hip, axis=-1, keepdims=True)
        bend = knee - hip - np.sum((knee - hip) * line, axis=-1, keepdims=True) * line
        hips = world(locked, "hips")[1]
        forward = np.stack(
            [
                2 * (hips[:, 1] * hips[:, 2] - hips[:, 0] * hips[:, 3]),
                hips[:, 0] ** 2 + hips[:, 2] ** 2 - 0.5,
            ],
            -1,
        )
        assert (np.sum(bend[:, :2] * forward, axis=-1) > -1e-3).all()


def test_hips_that_are_too_high_raise_the_heels(walk: Motion, contacts: np.ndarray, world) -> None:
    plan = plan_feet(walk, contacts, UNLOCK, HALFLIFE)
    standing = slice(10, 60)
    raised = place_feet(higher(walk, 0.05), plan)
    np.testing.assert_allclose(toe_positions(raised)[standing], plan.toes[standing], atol=1e-6)
    lift = world(raised, "foot.L")[0][standing, 2] - world(walk, "foot.L")[0][standing, 2]
    assert lift.min() > 0.01


def test_hips_out_of_all_reach_leave_straight_legs(walk: Motion, contacts: np.ndarray, world) -> None:
    plan = plan_feet(walk, contacts, UNLOCK, HALFLIFE)
    flying = place_feet(higher(walk, 1.0), plan)
    legs = np.linalg.norm(world(flying, "foot.L")[0] - world(flying, "thigh.L")[0], axis=-1)
    np.testing.assert_allclose(legs, flying.skeleton.leg_length(), atol=1e-6)
    assert np.isfinite(flying.rotations).all()


def test_locks_come_within_reach_of_a_body_elsewhere(walk: Motion, contacts: np.ndarray) -> None:
    lifted = higher(walk, 0.04)
    plan = plan_feet(walk, contacts, UNLOCK, HALFLIFE, lifted)
    toes = toe_positions(place_feet(lifted, plan))
    still = plan.contacts[1:] & plan.contacts[:-1]
    assert speeds(toes, 60.0)[still].max() < 0.02
    assert np.abs(toes[plan.contacts] - plan.toes[plan.contacts]).max() < 2e-3


def test_a_motion_that_leaves_its_lock_is_followed_by_a_step() -> None:
    frames = 240
    path = np.zeros((frames, 3))
    path[:, 0] = np.interp(np.arange(frames), [60, 90], [0.0, 1.0])
    locks = find_locks(path, np.ones(frames, np.bool_), 0.02, UNLOCK, 60.0)
    assert len(locks) > 1 and locks[1].steps and not locks[0].steps
    assert locks[1].first - locks[0].last >= 14
    for item in locks:
        assert np.abs(path[item.first : item.last + 1, 0] - item.point[0]).max() <= UNLOCK + 1e-9
    toe = path + offsets(path, locks, 24)
    gap = slice(locks[0].last + 1, locks[1].first)
    assert toe[gap, 2].max() > 0.03
    assert np.linalg.norm(np.diff(toe, axis=0), axis=-1).max() * 60.0 < 8.0


def test_short_gaps_and_short_contacts_change_nothing() -> None:
    flags = np.zeros(120, np.bool_)
    flags[20:60] = True
    flags[40:43] = False
    flags[100:103] = True
    locks = find_locks(np.zeros((120, 3)), flags, 0.0, UNLOCK, 60.0)
    assert [(item.first, item.last) for item in locks] == [(20, 59)]


@pytest.mark.parametrize("frames", [1, 2, 3, 7])
def test_short_motions(walk: Motion, contacts: np.ndarray, frames: int) -> None:
    short = replace(walk, positions=walk.positions[:frames], rotations=walk.rotations[:frames])
    locked, _ = lock(short, contacts[:frames])
    assert np.isfinite(locked.rotations).all() and len(locked) == frames


def test_clearance_keeps_what_is_high_and_lifts_what_is_low() -> None:
    held = np.zeros(61, np.bool_)
    held[:10] = held[50:] = True
    heights = np.where(held, 0.0, 0.1)
    np.testing.assert_allclose(clear(heights, held, 60.0)[20:40], 0.1, atol=2e-3)
    low = clear(np.where(held, 0.0, -0.03), held, 60.0)
    assert (low >= 0.0).all() and low[30] > 0.015 and (low[held] == 0.0).all()


def test_own_steps_take_turns_and_their_time() -> None:
    def pair(stop: int, way: float) -> list[Lock]:
        here, there = np.zeros(3), np.array([way, 0.0, 0.0])
        return [Lock(0, stop, here, False), Lock(stop + 15, 400, there, True)]

    left, right = take_turns([pair(100, 0.1), pair(105, 0.4)], 60.0)
    assert [lock.first for lock in left] == [0, 100 + round((0.25 + 0.35 * 0.1) * 60)]
    assert right[0].last >= left[1].first and right[1].first - right[0].last == round(
        (0.25 + 0.35 * 0.4) * 60
    )
    # no room to wait: the step stays where it was
    short = [Lock(0, 105, np.zeros(3), False), Lock(120, 128, np.ones(3), True)]
    assert take_turns([pair(100, 0.1), short], 60.0)[1] == short


def test_a_knee_does_not_snap_where_the_leg_gets_straight(walk: Motion) -> None:
    frames = 240
    body = replace(
        walk, positions=walk.positions[:1].repeat(frames, 0), rotations=walk.rotations[:1].repeat(frames, 0)
    )
    rise = 0.04 * np.sin(2.0 * np.pi * np.arange(frames) / 60.0)
    moved = replace(body, positions=body.positions + rise[:, None] * np.array([0.0, 0.0, 1.0]))
    plan = plan_feet(body, np.ones((frames, 2), np.bool_), UNLOCK, HALFLIFE, moved)
    placed = place_feet(moved, plan).forward()[0]
    knee = np.linalg.norm(np.diff(placed[:, placed_joint(body, "shin.L")], 2, axis=0), axis=-1) * 3600.0
    # the hips' own peak is 1.6 m/s^2; a leg locked at 0.998 of its length gives more than 40
    assert knee.max() < 20.0


def placed_joint(motion: Motion, role: str) -> int:
    return motion.skeleton.joint(role)

"""Planted feet on a demo walk, whose feet stand by construction, and on feet that are made to slide."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.body.motion import Motion
from footwork.core.body.toes import toe_positions
from footwork.core.database.contacts import find_contacts
from footwork.core.rig.feet import place_feet, plan_feet

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


def test_a_walk_with_planted_feet_stays_as_it_is(walk: Motion, contacts: np.ndarray, world) -> None:
    locked, _ = lock(walk, contacts)
    away = np.linalg.norm(locked.forward()[0] - walk.forward()[0], axis=-1).max(axis=1)
    # where it turns back its ankles pass at 4 cm, and are led around each other
    ankles = [world(walk, f"foot.{side}")[0] for side in "LR"]
    near = np.linalg.norm((ankles[1] - ankles[0])[:, :2], axis=-1) < 0.11
    around = np.convolve(near, np.ones(31), "same") > 0.0
    assert near.sum() < 20
    assert np.median(away) < 0.005 and away[~around].max() < 0.04 and away.max() < 0.07
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


@pytest.fixture(scope="module")
def leaving(walk: Motion) -> Motion:
    """A body that stands still as it does at the walk's start, and whose root is dragged 0.5 m aside in 10 s."""
    frames = 600
    standing = replace(
        walk, positions=walk.positions[:1].repeat(frames, 0), rotations=walk.rotations[:1].repeat(frames, 0)
    )
    away = 0.05 / 60.0 * np.arange(frames)[:, None] * np.array([0.8, 0.6, 0.0])
    return replace(standing, positions=standing.positions + away)


def test_a_root_that_leaves_its_feet_is_followed_by_steps(leaving: Motion) -> None:
    locked, held = lock(leaving, np.ones((len(leaving), 2), np.bool_))
    toes = toe_positions(locked)
    speed = np.linalg.norm(np.diff(toes[..., :2], axis=0), axis=-1) * 60.0
    assert speed[held[1:] & held[:-1]].max() < 1e-4
    # as far as a step goes in its time without haste: way / time * 15 / 8, and 6 way / time^2
    assert speed.max() < 1.3
    bend = np.linalg.norm(np.diff(toes[..., :2], n=2, axis=0), axis=-1) * 3600.0
    assert bend.max() < 12.0
    assert held.any(axis=1).all()
    height = locked.skeleton.tpose_positions()[locked.skeleton.joint("toe.L"), 2]
    for side in range(2):
        edges = np.flatnonzero(np.diff(held[:, side], prepend=True, append=True)).reshape(-1, 2)
        assert len(edges) in (1, 2)
        for first, stop in edges:
            assert (stop - first) / 60.0 >= 0.3
            assert 0.03 < toes[first:stop, side, 2].max() - height < 0.12
    away = np.linalg.norm((toes - toe_positions(leaving))[..., :2], axis=-1)
    assert away[held].max() <= UNLOCK + 1e-3


def test_the_heel_leaves_first_in_a_step_of_ours(leaving: Motion, world) -> None:
    locked, held = lock(leaving, np.ones((len(leaving), 2), np.bool_))
    first, stop = np.flatnonzero(np.diff(held[:, 0], prepend=True, append=True))[:2]
    toe, ankle = toe_positions(locked)[:, 0, 2], world(locked, "foot.L")[0][:, 2]
    lifted = ankle - toe - (ankle - toe)[first - 1]
    early = (stop - first) // 3
    assert lifted[first : first + early].max() > 0.02
    assert np.abs(lifted[stop - 2 : stop + 2]).max() < 0.01


@pytest.mark.parametrize("frames", [1, 2, 3, 7])
def test_short_motions(walk: Motion, contacts: np.ndarray, frames: int) -> None:
    short = replace(walk, positions=walk.positions[:frames], rotations=walk.rotations[:frames])
    locked, _ = lock(short, contacts[:frames])
    assert np.isfinite(locked.rotations).all() and len(locked) == frames


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

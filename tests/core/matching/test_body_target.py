from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.database.motion_database import MotionDatabase
from footwork.core.matching.body_target import body_posture
from footwork.core.matching.posture_model import Posture, pooled, sums_of
from footwork.core.mocap.demo import demo_skeleton
from scipy.spatial.transform import Rotation

FPS = 60.0


def leans(
    rng: np.random.Generator, count: int, low: float, high: float, sway: float
) -> tuple[np.ndarray, np.ndarray]:
    """Pitch and roll that wander smoothly."""
    knots = np.arange(0, count + 60, 30)
    pitch = np.interp(np.arange(count), knots, rng.uniform(low, high, len(knots)))
    roll = np.interp(np.arange(count), knots, rng.normal(0.0, sway, len(knots)))
    return pitch, roll


def turns_of(pitch: np.ndarray, roll: np.ndarray) -> Rotation:
    return Rotation.from_euler("xy", np.stack([-pitch, roll], -1))


def leaning(db: MotionDatabase, pitch: np.ndarray, roll: np.ndarray) -> MotionDatabase:
    """Stiff bodies that lean from the hips: by `pitch` forward and by `roll` to the right."""
    skeleton = demo_skeleton(1.7)
    rotations = np.zeros((len(db), len(skeleton.names), 4))
    rotations[..., 0] = 1.0
    rotations[:, 0] = np.roll(turns_of(pitch, roll).as_quat(), 1, axis=-1)
    hips = np.broadcast_to([0.0, 0.0, 0.9], (len(db), 3))
    poses = replace(db.poses, rotations=rotations, hips_positions=hips)
    return replace(db, skeleton=skeleton, head_height=1.6, poses=poses)


class User:
    """A stiff body that leans while it walks along and turns; joints of head and hands as the database's."""

    def __init__(
        self, db: MotionDatabase, pitch: np.ndarray, roll: np.ndarray, yaws: np.ndarray, hips: np.ndarray
    ):
        joints = db.skeleton.tpose_positions()
        arms = [joints[db.skeleton.joint(role)] - joints[0] for role in ("head", "hand.L", "hand.R")]
        turns = Rotation.from_rotvec(np.outer(yaws, [0, 0, 1])) * turns_of(pitch, roll)
        centre = np.column_stack([hips, np.full(len(hips), 0.9)])
        self.hips = hips
        self.positions = np.stack([turns.apply(arm) + centre for arm in arms], axis=1)
        self.rotations = np.repeat(np.roll(turns.as_quat(), 1, axis=-1)[:, None], 3, axis=1)
        self.valid = np.ones((len(hips), 3), dtype=bool)

    def targets(self, *databases: MotionDatabase) -> np.ndarray:
        return self.positions[:, 0, :2] + self.posture(*databases).hips

    def posture(self, *databases: MotionDatabase) -> Posture:
        return body_posture(self.positions, self.rotations, self.valid, 1.6, FPS, databases)


def user(db: MotionDatabase, seed: int = 1, count: int = 400, flip: float = 1.0, turn: float = 0.0) -> User:
    rng = np.random.default_rng(seed)
    pitch, roll = leans(rng, count, 0.0, 0.45, 0.1)
    roll = roll * flip
    knots = np.arange(0, count + 60, 30)
    yaws = np.interp(np.arange(count), knots, np.cumsum(rng.normal(0, 0.4, len(knots)))) * flip + turn
    steps = rng.normal(0, 0.01, 2) + np.zeros((count, 2))
    hips = np.cumsum(steps, axis=0) * [flip, 1.0]
    c, s = np.cos(turn), np.sin(turn)
    return User(db, pitch, roll, yaws, hips @ np.array([[c, s], [-s, c]]))


@pytest.fixture
def stoopers(make_database) -> MotionDatabase:
    rng = np.random.default_rng(0)
    db = make_database(lengths=(4000,))
    return leaning(db, *leans(rng, 4000, -0.1, 0.5, 0.15))


def test_the_hips_are_found_under_a_leaning_body(stoopers):
    found = user(stoopers)
    before = np.linalg.norm(found.positions[:, 0, :2] - found.hips, axis=-1)
    after = np.linalg.norm(found.targets(stoopers) - found.hips, axis=-1)
    assert before.mean() > 0.12
    assert after.mean() < 0.035


def test_the_chest_of_a_stiff_body_turns_as_its_head_does(stoopers):
    # the head of a stiff body has its chest's rotation, which a linear model need not know exactly
    found = user(stoopers)
    chest = Rotation.from_quat(np.roll(found.posture(stoopers).chest, -1, axis=-1))
    head = Rotation.from_quat(np.roll(found.rotations[:, 0], -1, axis=-1))
    assert np.degrees((chest.inv() * head).magnitude()).mean() < 4.0
    assert np.degrees(head.magnitude()).mean() > 15.0


def test_left_and_right_are_treated_alike(stoopers):
    here, there = user(stoopers), user(stoopers, flip=-1.0)
    np.testing.assert_allclose(there.targets(stoopers) * [-1, 1], here.targets(stoopers), atol=2e-5)


def test_turning_the_world_turns_the_target(stoopers):
    here, there = user(stoopers), user(stoopers, turn=np.pi / 3)
    c, s = np.cos(np.pi / 3), np.sin(np.pi / 3)
    turn = np.array([[c, s], [-s, c]])
    np.testing.assert_allclose(there.targets(stoopers), here.targets(stoopers) @ turn, atol=2e-5)


def test_no_lean_beyond_what_the_databases_show(stoopers):
    # a user who lies down or stands on a table: neither is in the database
    for height in (0.2, 3.0):
        found = user(stoopers)
        found.positions = found.positions * [1.0, 1.0, 0.0] + [0.0, 0.0, height]
        away = np.linalg.norm(found.targets(stoopers) - found.positions[:, 0, :2], axis=-1)
        assert (away < 0.7).all()


def test_hands_that_are_not_tracked_do_not_matter(stoopers):
    found = user(stoopers)
    found.valid[:, 1:] = False
    before = found.targets(stoopers)
    found.positions[:, 1:] += np.random.default_rng(2).normal(0, 1, found.positions[:, 1:].shape)
    found.rotations[:, 1:] = Rotation.random(800, random_state=3).as_quat().reshape(-1, 2, 4)
    np.testing.assert_array_equal(found.targets(stoopers), before)
    assert np.linalg.norm(before - found.hips, axis=-1).mean() < 0.6 * 0.12


def test_a_hand_lost_for_a_moment_leaves_no_jump(stoopers):
    found = user(stoopers)
    whole = found.targets(stoopers)
    found.valid[200:203, 1] = False
    assert np.linalg.norm(found.targets(stoopers) - whole, axis=-1).max() < 0.03


def test_a_body_that_never_moves_teaches_its_own_offset(make_database):
    db = leaning(make_database(), np.full(500, 0.2), np.zeros(500))
    found = user(db)
    away = np.linalg.norm(found.targets(db) - found.positions[:, 0, :2], axis=-1)
    head = db.skeleton.tpose_positions()[db.skeleton.joint("head")] - db.skeleton.tpose_positions()[0]
    np.testing.assert_allclose(away, turns_of(np.array([0.2]), np.zeros(1)).apply(head)[0, 1], atol=0.005)


def test_the_sums_of_two_databases_are_those_of_all_their_frames(stoopers, make_database):
    rng = np.random.default_rng(5)
    first = leaning(make_database(lengths=(600,)), *leans(rng, 600, 0.0, 0.3, 0.1))
    second = leaning(make_database(lengths=(600,)), *leans(rng, 600, 0.2, 0.6, 0.1))
    both = make_database(lengths=(600, 600))
    names = ("hips_positions", "rotations", "root_positions", "root_yaws")
    joined = {name: np.concatenate([getattr(db.poses, name) for db in (first, second)]) for name in names}
    both = replace(both, skeleton=first.skeleton, head_height=1.6, poses=replace(both.poses, **joined))
    one, other = pooled([sums_of(first), sums_of(second)]), sums_of(both)
    assert one.count == other.count
    np.testing.assert_allclose(one.usual, other.usual, atol=1e-9)
    np.testing.assert_allclose(one.squares, other.squares, atol=1e-9)
    np.testing.assert_allclose(one.products, other.products, atol=1e-9)

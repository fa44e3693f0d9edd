from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.database.motion_database import MotionDatabase
from footwork.core.matching.body_target import body_targets
from scipy.spatial.transform import Rotation

SPINE = np.array([0.0, 0.0, 0.7])


def leaning(db: MotionDatabase, pitch: np.ndarray, roll: np.ndarray) -> MotionDatabase:
    """Stiff bodies that lean from the hips: by `pitch` forward and by `roll` to the right."""
    turns = Rotation.from_euler("xy", np.stack([-pitch, roll], -1))
    rotations = np.zeros_like(db.poses.rotations)
    rotations[..., 0] = 1.0
    rotations[:, 0] = np.roll(turns.as_quat(), 1, axis=-1)
    hips = np.broadcast_to([0.0, 0.0, 0.9], (len(db), 3))
    return replace(db, poses=replace(db.poses, rotations=rotations, hips_positions=hips))


def heads(
    pitch: np.ndarray, roll: np.ndarray, yaws: np.ndarray, hips: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    turns = Rotation.from_rotvec(np.outer(yaws, [0, 0, 1])) * Rotation.from_euler(
        "xy", np.stack([-pitch, roll], -1)
    )
    return turns.apply(SPINE) + np.column_stack([hips, np.full(len(hips), 0.9)]), np.roll(
        turns.as_quat(), 1, axis=-1
    )


@pytest.fixture
def stoopers(make_database) -> MotionDatabase:
    rng = np.random.default_rng(0)
    db = make_database(lengths=(2000,))
    return leaning(db, rng.uniform(-0.1, 0.5, 2000), rng.normal(0.05, 0.1, 2000))


def user(seed: int = 1, count: int = 300) -> tuple[np.ndarray, ...]:
    rng = np.random.default_rng(seed)
    return (
        rng.uniform(0.0, 0.45, count),
        rng.normal(0.0, 0.1, count),
        rng.uniform(-9, 9, count),
        rng.normal(0, 5, (count, 2)),
    )


def test_the_hips_are_found_under_a_leaning_body(stoopers):
    pitch, roll, yaws, hips = user()
    positions, rotations = heads(pitch, roll, yaws, hips)
    before = np.linalg.norm(positions[:, :2] - hips, axis=-1)
    after = np.linalg.norm(body_targets(positions, rotations, yaws, [stoopers]) - hips, axis=-1)
    assert before.mean() > 0.15
    assert after.mean() < 0.015


def test_left_and_right_are_treated_alike(stoopers):
    pitch, roll, _, _ = user()
    zeros = np.zeros(300)
    positions, rotations = heads(pitch, roll, zeros, np.zeros((300, 2)))
    other_positions, other_rotations = heads(pitch, -roll, zeros, np.zeros((300, 2)))
    here = body_targets(positions, rotations, zeros, [stoopers])
    there = body_targets(other_positions, other_rotations, zeros, [stoopers])
    inner = np.abs(roll) < 0.15
    np.testing.assert_allclose(there[inner] * [-1, 1], here[inner], atol=1e-9)


def test_turning_the_world_turns_the_target(stoopers):
    pitch, roll, yaws, hips = user()
    positions, rotations = heads(pitch, roll, yaws, hips)
    here = body_targets(positions, rotations, yaws, [stoopers])
    turn = np.array([[0.0, 1.0], [-1.0, 0.0]])
    moved, moved_rotations = heads(pitch, roll, yaws + np.pi / 2, hips @ turn + 2.0)
    there = body_targets(moved, moved_rotations, yaws + np.pi / 2, [stoopers])
    np.testing.assert_allclose(there, here @ turn + 2.0, atol=1e-9)


def test_no_lean_beyond_what_the_databases_show(stoopers):
    # a user who lies down or stands on a table: neither is in the database
    zeros = np.zeros(2)
    rotations = np.broadcast_to([1.0, 0.0, 0.0, 0.0], (2, 4))
    target = body_targets(np.array([[0.0, 0.0, 0.2], [0.0, 0.0, 3.0]]), rotations, zeros, [stoopers])
    assert (np.abs(target) < 0.7 * np.sin(0.5)).all()


def test_a_body_that_never_moves_teaches_its_own_offset(make_database):
    db = leaning(make_database(), np.full(500, 0.2), np.zeros(500))
    pitch, roll, yaws, hips = user()
    positions, rotations = heads(pitch, roll, yaws, hips)
    away = np.linalg.norm(body_targets(positions, rotations, yaws, [db]) - positions[:, :2], axis=-1)
    np.testing.assert_allclose(away, 0.7 * np.sin(0.2), atol=1e-6)

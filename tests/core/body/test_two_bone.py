"""Two-bone reach against forward kinematics by scipy."""

from __future__ import annotations

import numpy as np
import pytest
from footwork.core.body.two_bone import bend_direction, reach, triangle
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

metres = st.floats(-1.0, 1.0)
vectors = st.tuples(metres, metres, metres).map(np.array)
lengths = st.floats(0.1, 0.6)


def spread(vector: np.ndarray) -> bool:
    return bool(np.linalg.norm(vector) > 0.05)


directions = vectors.filter(spread).map(lambda v: v / np.linalg.norm(v))


def end_of(joints: np.ndarray, before: np.ndarray, after: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mid joint and end once the bones turned from the rotations `before` to `after`."""

    def turned(i: int) -> Rotation:
        new, old = Rotation.from_quat(np.roll(after[i], -1)), Rotation.from_quat(np.roll(before[i], -1))
        return new * old.inv()

    mid = joints[0] + turned(0).apply(joints[1] - joints[0])
    return mid, mid + turned(1).apply(joints[2] - joints[1])


@settings(max_examples=150, deadline=None)
@given(
    vectors,
    directions,
    directions,
    lengths,
    lengths,
    directions,
    st.floats(0.02, 0.98),
    directions,
    st.integers(0, 99),
)
def test_the_end_is_at_any_target_in_reach(root, first, second, a, b, way, share, aim, seed) -> None:
    joints = np.stack([root, root + a * first, root + a * first + b * second])
    before = np.roll(Rotation.random(2, random_state=seed).as_quat(), 1, axis=-1)
    target = root + way * (abs(a - b) + share * (a + b - abs(a - b)))
    after, reached = reach(joints, before, target, np.cross(first, [0.3, 0.5, 0.8]), aim)
    assert reached
    mid, end = end_of(joints, before, after)
    assert np.linalg.norm(end - target) < 1e-7
    assert np.linalg.norm(mid - root) == pytest.approx(a, abs=1e-9)
    assert (mid - root) @ (aim - (aim @ way) * way) > -1e-9


@settings(max_examples=60, deadline=None)
@given(directions, lengths, lengths, st.floats(1.001, 5.0), st.integers(0, 99))
def test_a_target_out_of_reach_leaves_the_limb_straight(way, a, b, far, seed) -> None:
    bones = Rotation.random(2, random_state=seed)
    joints = np.cumsum([np.zeros(3), bones[0].apply([a, 0, 0]), bones[1].apply([b, 0, 0])], axis=0)
    before = np.roll(bones.as_quat(), 1, axis=-1)
    after, reached = reach(
        joints, before, far * (a + b) * way, np.array([0.1, 0.2, 1.0]), np.array([0.3, 1.0, 0.2])
    )
    assert not reached
    mid, end = end_of(joints, before, after)
    np.testing.assert_allclose(mid, a * way, atol=1e-6)
    np.testing.assert_allclose(end, (a + b) * way, atol=1e-6)


def test_a_limb_that_is_there_stays_as_it_is() -> None:
    joints = np.array([[0, 0, 1.0], [0.05, 0.1, 0.55], [0, 0, 0.1]])
    before = np.roll(Rotation.random(2, random_state=5).as_quat(), 1, axis=-1)
    bend = bend_direction(joints, np.array([0.0, 1.0, 0.0]), 0.0)
    after, _ = reach(joints, before, joints[2], bend, bend)
    np.testing.assert_allclose(np.abs(np.sum(after * before, axis=-1)), 1.0, atol=1e-12)


def test_noise_around_a_straight_leg_does_not_turn_its_knee() -> None:
    rng = np.random.default_rng(0)
    joints = np.array([[0, 0, 0.9], [0, 0, 0.45], [0, 0, 0.0]]) + rng.normal(0, 5e-4, (200, 3, 3))
    bend = bend_direction(joints, np.array([0.0, 1.0, 0.0]), 0.03)
    sideways = np.degrees(np.arctan2(np.abs(bend[:, 0]), bend[:, 1]))
    assert sideways.max() < 6.0


def test_an_own_bend_counts_more_than_the_hint() -> None:
    joints = np.array([[0, 0, 0.9], [0.2, 0, 0.45], [0, 0, 0.0]])
    bend = bend_direction(joints, np.array([0.0, 1.0, 0.0]), 0.03)
    assert bend[0] > 6 * bend[1] > 0


def test_degenerate_targets_and_aims_stay_finite() -> None:
    wanted = np.array([[0.0, 0, 0], [0, 0, 0.5], [0, 0, 1e-15]])
    mid, end, reached = triangle(np.full(3, 0.3), np.full(3, 0.3), wanted, np.array([0.0, 0.0, 1.0]))
    assert np.isfinite(mid).all() and np.isfinite(end).all() and reached.all()
    np.testing.assert_allclose(np.linalg.norm(mid, axis=-1), 0.3)

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


def limbs(shape: tuple[int, ...], seed: int = 0) -> tuple[np.ndarray, ...]:
    """Joints, rotations, targets in reach, bends and aims of limbs of unequal bones."""
    rng = np.random.default_rng(seed)
    joints = np.cumsum(rng.normal(size=(*shape, 3, 3)), axis=-2)
    rotations = rng.normal(size=(*shape, 2, 4))
    rotations /= np.linalg.norm(rotations, axis=-1, keepdims=True)
    bones = np.linalg.norm(np.diff(joints, axis=-2), axis=-1)
    least, most = np.abs(bones[..., 0] - bones[..., 1]), bones.sum(axis=-1)
    way = rng.normal(size=(*shape, 3))
    way /= np.linalg.norm(way, axis=-1, keepdims=True)
    targets = joints[..., 0, :] + way * (least + 0.7 * (most - least))[..., None]
    return joints, rotations, targets, *rng.normal(size=(2, *shape, 3))


@pytest.mark.parametrize("shape", [(1,), (6,), (3, 2), (2, 1, 4)])
def test_many_limbs_at_once_are_each_one_alone(shape: tuple[int, ...]) -> None:
    given = limbs(shape)
    turned, reached = reach(*given)
    assert turned.shape == (*shape, 2, 4) and reached.shape == shape and reached.all()
    for place in np.ndindex(*shape):
        alone, there = reach(*(array[place] for array in given))
        np.testing.assert_allclose(turned[place], alone, atol=1e-12)
        assert there
        _, end = end_of(given[0][place], given[1][place], turned[place])
        np.testing.assert_allclose(end, given[2][place], atol=1e-9)


def test_the_mid_joint_lies_where_the_aim_is() -> None:
    joints, rotations, targets, bend, aim = limbs((40,), 3)
    turned, _ = reach(joints, rotations, targets, bend, aim)
    for i in range(40):
        mid, _ = end_of(joints[i], rotations[i], turned[i])
        way = (targets[i] - joints[i, 0]) / np.linalg.norm(targets[i] - joints[i, 0])
        sides = [v - (v @ way) * way for v in (mid - joints[i, 0], aim[i])]
        cosine = sides[0] @ sides[1] / np.linalg.norm(sides[0]) / np.linalg.norm(sides[1])
        assert cosine == pytest.approx(1.0, abs=1e-9)


def test_bones_turn_with_the_limbs_plane() -> None:
    """A limb as a rigid body: where target, bend and aim are those of the turned limb, so are the rotations."""
    joints, rotations, _, _, _ = limbs((30,), 4)
    bend = bend_direction(joints, np.ones(3), 0.0)
    whole = Rotation.random(30, random_state=1)
    targets = joints[:, 0] + whole.apply(joints[:, 2] - joints[:, 0])
    turned, _ = reach(joints, rotations, targets, bend, whole.apply(bend))
    for i in range(2):
        before = Rotation.from_quat(np.roll(rotations[:, i], -1, axis=-1))
        after = Rotation.from_quat(np.roll(turned[:, i], -1, axis=-1))
        assert (after * (whole * before).inv()).magnitude().max() < 1e-6


@pytest.mark.parametrize(("upper", "lower"), [(0.5, 0.3), (0.3, 0.5)])
@pytest.mark.parametrize("distance", [0.01, 0.199, 0.2, 0.3, 0.6, 0.8, 0.801, 7.0])
def test_triangles_of_unequal_bones(upper: float, lower: float, distance: float) -> None:
    rng = np.random.default_rng(5)
    way, aim = rng.normal(size=(2, 3))
    way /= np.linalg.norm(way)
    mid, end, reached = triangle(np.array(upper), np.array(lower), distance * way, aim)
    span = np.clip(distance, 0.2, 0.8)
    np.testing.assert_allclose(end, span * way, atol=1e-9)
    assert np.linalg.norm(mid) == pytest.approx(upper, abs=1e-9)
    assert np.linalg.norm(end - mid) == pytest.approx(lower, abs=1e-7)
    assert mid @ (aim - (aim @ way) * way) > -1e-9
    assert abs(np.dot(mid, np.cross(way, aim))) < 1e-9
    assert reached == (0.2 <= distance <= 0.8)


def test_a_micrometre_too_far_is_reached() -> None:
    way = np.array([0.48, 0.6, 0.64])
    far = np.array([0.8, 0.8 + 0.9e-6, 0.8 + 1.1e-6, 0.2 - 0.9e-6, 0.2 - 1.1e-6])
    _, _, reached = triangle(np.full(5, 0.5), np.full(5, 0.3), far[:, None] * way, np.array([1.0, 0.2, 0.0]))
    assert reached.tolist() == [True, True, False, True, False]


def test_bends_and_hints_are_added_across_the_line() -> None:
    rng = np.random.default_rng(6)
    joints, hint = rng.normal(size=(20, 3, 3)), rng.normal(size=(20, 3))
    hint /= np.linalg.norm(hint, axis=-1, keepdims=True)
    for softness in (0.0, 0.04, 2.0):
        found = bend_direction(joints, hint, softness)
        for i in range(20):
            root, mid, end = joints[i]
            way = (end - root) / np.linalg.norm(end - root)
            # rejection by the double cross product
            expected = [-np.cross(way, np.cross(way, v)) for v in (mid - root, hint[i])]
            np.testing.assert_allclose(found[i], expected[0] + softness * expected[1], atol=1e-12)

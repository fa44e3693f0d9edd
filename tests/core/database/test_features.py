from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.body.edit import mirror
from footwork.core.body.motion import Motion
from footwork.core.database.features import clip_features, horizon_frames, normalize_features
from footwork.core.database.motion_database import FEATURE_GROUPS
from footwork.core.database.virtual_root import virtual_root
from footwork.core.maths import quat
from footwork.core.mocap.demo import demo_motion
from hypothesis import given, settings
from hypothesis import strategies as st

HORIZONS = np.array([1 / 3, 2 / 3, 1.0])
DEMO = demo_motion("sidestep")


def features_of(motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    return clip_features(motion, *virtual_root(motion))


def group(values: np.ndarray, name: str) -> np.ndarray:
    return values[:, FEATURE_GROUPS[name]]


def tpose_foot(motion: Motion, side: str) -> np.ndarray:
    return motion.skeleton.tpose_positions()[motion.skeleton.joint(f"foot.{side}")]


def test_layout_is_complete() -> None:
    columns = np.concatenate([np.arange(27)[part] for part in FEATURE_GROUPS.values()])
    np.testing.assert_array_equal(columns, np.arange(27))


@pytest.mark.parametrize("fps", [60.0, 72.0, 30.0])
def test_straight_walk(glide, fps: float) -> None:
    heading, speed = 0.9, 1.25
    t = np.arange(round(3 * fps)) / fps
    ahead = np.array([-np.sin(heading), np.cos(heading)])
    motion = glide(np.array([4.0, -2.0]) + speed * t[:, None] * ahead, np.full(len(t), heading), fps)
    values, valid = features_of(motion)
    steps = np.round(HORIZONS * fps)
    assert valid.sum() == len(t) - steps[-1]
    expected = np.column_stack([np.zeros(3), speed * steps / fps]).ravel()
    found = values[valid]
    np.testing.assert_allclose(group(found, "trajectory_positions") - expected, 0.0, atol=1e-9)
    np.testing.assert_allclose(group(found, "trajectory_directions") - [0, 1] * 3, 0.0, atol=1e-9)
    # pose features hold for every frame, those near the clip's end too
    for side, name in (("L", "left_foot"), ("R", "right_foot")):
        foot = tpose_foot(motion, side)
        np.testing.assert_allclose(group(values, f"{name}_position") - foot, 0.0, atol=1e-9)
        np.testing.assert_allclose(group(values, f"{name}_velocity") - [0, speed, 0], 0.0, atol=1e-9)
    np.testing.assert_allclose(group(values, "hips_velocity") - [0, speed, 0], 0.0, atol=1e-9)


def test_circle_to_the_left(glide) -> None:
    radius, speed = 1.5, 1.2
    rate = speed / radius
    t = np.arange(200) / 60.0
    yaws = 0.4 + rate * t
    # the centre lies a radius to the left
    motion = glide(radius * np.column_stack([np.cos(yaws), np.sin(yaws)]), yaws)
    values, valid = features_of(motion)
    angle = rate * HORIZONS
    chord = radius * np.column_stack([np.cos(angle) - 1.0, np.sin(angle)])
    heading = np.column_stack([-np.sin(angle), np.cos(angle)])
    found = values[valid]
    np.testing.assert_allclose(group(found, "trajectory_positions") - chord.ravel(), 0.0, atol=1e-9)
    np.testing.assert_allclose(group(found, "trajectory_directions") - heading.ravel(), 0.0, atol=1e-9)


def test_turning_on_the_spot(glide) -> None:
    rate = -1.8
    motion = glide(np.tile([3.0, 1.0], (150, 1)), rate * np.arange(150) / 60.0)
    values, valid = features_of(motion)
    np.testing.assert_allclose(group(values, "trajectory_positions"), 0.0, atol=1e-9)
    heading = np.column_stack([-np.sin(rate * HORIZONS), np.cos(rate * HORIZONS)]).ravel()
    np.testing.assert_allclose(group(values[valid], "trajectory_directions") - heading, 0.0, atol=1e-9)
    c, s = np.cos(rate / 60.0), np.sin(rate / 60.0)
    step = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) - np.eye(3)
    for side, name in (("L", "left_foot"), ("R", "right_foot")):
        foot = tpose_foot(motion, side)
        np.testing.assert_allclose(group(values, f"{name}_position") - foot, 0.0, atol=1e-9)
        expected = step @ foot * 60.0
        np.testing.assert_allclose(group(values[:-1], f"{name}_velocity") - expected, 0.0, atol=1e-8)


def test_horizons_past_the_end_read_the_end(glide) -> None:
    t = np.arange(100) / 60.0
    values, valid = features_of(glide(np.column_stack([0.0 * t, t]), 0.0 * t))
    np.testing.assert_array_equal(valid, np.arange(100) < 40)
    left = (99 - np.arange(100)) / 60.0
    expected = np.minimum(left[:, None], [1 / 3, 2 / 3, 1.0])
    np.testing.assert_allclose(group(values, "trajectory_positions")[:, 1::2], expected, atol=1e-9)


@settings(max_examples=25, deadline=None)
@given(st.floats(-50, 50), st.floats(-50, 50), st.floats(-10, 10))
def test_moving_and_turning_the_take_changes_nothing(x: float, y: float, yaw: float) -> None:
    turn = quat.from_yaw(yaw)
    rotations = DEMO.rotations.copy()
    rotations[:, 0] = quat.multiply(turn, rotations[:, 0])
    positions = quat.rotate(turn, DEMO.positions) + np.array([x, y, 0.0])
    moved = replace(DEMO, positions=positions, rotations=rotations)
    np.testing.assert_allclose(features_of(moved)[0], features_of(DEMO)[0], atol=1e-8)


def test_mirror_image_has_reflected_features() -> None:
    values, valid = features_of(DEMO)
    image, image_valid = features_of(mirror(DEMO))
    expected = values.copy()
    for part in ("position", "velocity"):
        left, right = FEATURE_GROUPS[f"left_foot_{part}"], FEATURE_GROUPS[f"right_foot_{part}"]
        expected[:, left], expected[:, right] = values[:, right], values[:, left]
    expected[:, [0, 2, 4, 6, 8, 10, 12, 15, 18, 21, 24]] *= -1.0
    np.testing.assert_allclose(image, expected, atol=1e-9)
    np.testing.assert_array_equal(image_valid, valid)
    assert np.abs(values[:, 0]).max() > 0.1


def test_each_frame_by_hand() -> None:
    """The definition, one frame at a time, with matrices instead of yaws."""
    joints = DEMO.forward()[0]
    names = DEMO.skeleton.names
    values, _ = features_of(DEMO)
    for n in (0, 17, 400, 700):
        forward = quat.to_matrix(DEMO.rotations[n, 0])[:, 1] * [1, 1, 0]
        forward /= np.linalg.norm(forward)
        axes = np.array([np.cross(forward, [0, 0, 1]), forward, [0, 0, 1]])
        root = joints[n, 0] * [1, 1, 0]
        z: list[float] = []
        for step in (20, 40, 60):
            z += [*(axes @ (joints[n + step, 0] - root))[:2]]
        for step in (20, 40, 60):
            ahead = quat.to_matrix(DEMO.rotations[n + step, 0])[:2, 1]
            z += [*(axes[:2, :2] @ (ahead / np.linalg.norm(ahead)))]
        for name in ("LeftAnkle", "RightAnkle"):
            j = names.index(name)
            z += [*(axes @ (joints[n, j] - root)), *(axes @ (joints[n + 1, j] - joints[n, j]) * 60.0)]
        z += [*(axes @ (joints[n + 1, 0] - joints[n, 0]) * 60.0)]
        np.testing.assert_allclose(values[n], z, atol=1e-9)


def test_normalisation_by_group() -> None:
    rng = np.random.default_rng(2)
    values = rng.normal(size=(400, 27)) * rng.uniform(0.1, 5.0, 27) + rng.normal(size=27)
    valid = rng.random(400) < 0.7
    values[~valid] += 100.0
    database = normalize_features(values, valid)
    for columns in FEATURE_GROUPS.values():
        each = [np.sqrt(np.mean((c - c.mean()) ** 2)) for c in values[valid][:, columns].T]
        np.testing.assert_allclose(database.deviation[columns], np.mean(each))
        # the shares within a group stay: not every column has unit deviation
        ratio = database.values[valid][:, columns].std(axis=0) / each
        np.testing.assert_allclose(ratio, ratio[0], rtol=1e-5)
    np.testing.assert_allclose(database.values[valid].mean(axis=0), 0.0, atol=1e-5)
    back = database.values * database.deviation + database.mean
    np.testing.assert_allclose(back, values, atol=1e-4)
    assert database.values.dtype == np.float32


def test_still_features_keep_their_unit(glide) -> None:
    values, valid = features_of(glide(np.zeros((100, 2)), np.zeros(100)))
    database = normalize_features(values, valid)
    np.testing.assert_array_equal(database.deviation, 1.0)
    np.testing.assert_allclose(database.values, 0.0, atol=1e-6)


def test_horizon_frames() -> None:
    assert horizon_frames(60.0).tolist() == [20, 40, 60]
    assert horizon_frames(30.0).tolist() == [10, 20, 30]
    assert horizon_frames(72.0).tolist() == [24, 48, 72]

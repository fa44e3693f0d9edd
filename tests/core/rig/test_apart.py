"""Feet that do not pass through each other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.body.motion import Motion
from footwork.core.rig.apart import missing, spread_plants, step_around
from footwork.core.rig.feet import place_feet, plan_feet
from footwork.core.rig.locks import Lock
from scipy.spatial.transform import Rotation

LEG = 0.9
NEAR = 0.12 * LEG


def to_world(points: np.ndarray, yaw: float) -> np.ndarray:
    return Rotation.from_euler("z", yaw).apply(points)


@pytest.mark.parametrize("yaw", [0.0, 0.7, -2.4])
def test_what_is_missing_by_hand(yaw: float) -> None:
    ways = np.array([[0.2, 0.0, 0], [0.05, 0.0, 0], [0.0, 0.06, 0], [-0.04, -0.08, 0], [-0.3, 0.2, 0]])
    expected = [0.0, NEAR - 0.05, np.sqrt(NEAR**2 - 0.06**2), np.sqrt(NEAR**2 - 0.08**2) + 0.04, 0.0]
    found = missing(to_world(ways, yaw)[:, :2], np.full(5, yaw), LEG)
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_plants_that_stand_too_near_go_apart_by_half_each() -> None:
    yaw, ankles = 1.1, np.zeros((100, 2, 3))
    left = [Lock(0, 40, to_world(np.array([0.0, 0.0, 0.02]), yaw)), Lock(60, 99, np.array([3.0, 1.0, 0.02]))]
    right = [Lock(20, 99, to_world(np.array([0.04, 0.03, 0.02]), yaw))]
    (first, second), (only,) = spread_plants((left, right), ankles, np.full(100, yaw), LEG)
    half = 0.5 * (np.sqrt(NEAR**2 - 0.03**2) - 0.04)
    np.testing.assert_allclose(
        first.point, left[0].point + to_world(np.array([-half, 0, 0]), yaw), atol=1e-12
    )
    np.testing.assert_allclose(only.point, right[0].point + to_world(np.array([half, 0, 0]), yaw), atol=1e-12)
    assert second is left[1]
    # feet that never stand at the same time do not know of each other
    (alone,), _ = spread_plants(
        ([Lock(0, 10, np.zeros(3))], [Lock(11, 20, np.zeros(3))]), ankles, np.zeros(100), LEG
    )
    np.testing.assert_array_equal(alone.point, np.zeros(3))


def test_a_foot_in_the_air_goes_around_the_leg_that_stands() -> None:
    frames, yaw = 120, -0.8
    ahead = np.linspace(-0.6, 0.6, frames)
    still = np.tile([0.0, 0.0, 0.02], (frames, 1))
    swing = np.stack([np.full(frames, 0.03), ahead, np.full(frames, 0.1)], axis=-1)
    paths = [to_world(still, yaw), to_world(swing, yaw)]
    before = paths[1].copy()
    free = np.stack([np.zeros(frames), np.ones(frames)], axis=-1)
    step_around(paths, np.zeros((frames, 2, 3)), free, np.full(frames, yaw), LEG, 60.0)
    np.testing.assert_array_equal(paths[0], to_world(still, yaw))
    apart = np.linalg.norm((paths[1] - paths[0])[:, :2], axis=-1)
    assert apart.min() > NEAR - 1e-9
    # far from the other leg nothing changes, and the way is smooth
    np.testing.assert_allclose(paths[1][np.abs(ahead) > 0.35], before[np.abs(ahead) > 0.35], atol=1e-6)
    assert np.abs(np.diff(paths[1], n=2, axis=0)).max() < 0.006


def test_a_narrow_walk_keeps_its_shins_apart(walk: Motion, world) -> None:
    # the walker with thighs and feet drawn to the middle, so that the ankles pass at 2 cm
    skeleton = walk.skeleton
    narrow = walk.rotations.copy()
    for side, sign in (("L", -1.0), ("R", 1.0)):
        joint = skeleton.joint(f"thigh.{side}")
        inward = Rotation.from_euler("y", sign * 5.5, degrees=True)
        own = Rotation.from_quat(np.roll(narrow[:, joint], -1, axis=-1))
        narrow[:, joint] = np.roll((inward * own).as_quat(), 1, axis=-1)
    motion = replace(walk, rotations=narrow)
    contacts = np.zeros((len(walk), 2), np.bool_)

    def nearest(body: Motion) -> float:
        ankles = [world(body, f"foot.{side}")[0] for side in "LR"]
        return float(np.linalg.norm((ankles[1] - ankles[0])[:, :2], axis=-1).min())

    placed = place_feet(motion, plan_feet(motion, contacts, 0.2, 0.1))
    assert nearest(motion) < 0.05
    assert nearest(placed) > 0.11 * skeleton.leg_length()

"""Recordings brought to the origin and motions put at places, against rotations by matrices."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.body.edit import cut
from footwork.core.maths import quat
from footwork.core.mocap.demo import demo_motion
from footwork.core.recording.simulate import simulate_recording
from footwork.core.recording.targets import joint_targets
from footwork.core.rig.place import Place, from_start, ground_from, put
from scipy.spatial.transform import Rotation

MOTION = cut(demo_motion("visit", seed=0), 60, 300)
PLACE = Place((3.0, -1.0, 0.7), 2.2)
TURN = Rotation.from_euler("z", PLACE.yaw).as_matrix()


def test_a_motion_at_a_place_is_turned_and_moved_as_a_whole() -> None:
    before, after = MOTION.forward()[0], put(MOTION, PLACE).forward()[0]
    np.testing.assert_allclose(after, before @ TURN.T + PLACE.position, atol=1e-9)
    positions, rotations = PLACE.from_scene(*PLACE.to_scene(before, MOTION.forward()[1]))
    np.testing.assert_allclose(positions, before, atol=1e-9)
    assert np.abs(np.sum(rotations * MOTION.forward()[1], axis=-1)).min() > 1.0 - 1e-12


@pytest.mark.parametrize("yaw", [0.0, 3.0, -1.2])
def test_every_recording_starts_alike_wherever_it_was_made(yaw: float) -> None:
    made = simulate_recording(MOTION, "user")
    turn = quat.from_yaw(yaw)
    elsewhere = replace(
        made,
        positions=quat.rotate(turn, made.positions) + np.array([5.0, -7.0, 0.0]),
        rotations=quat.multiply(turn, made.rotations),
    )
    one, two = from_start(made), from_start(elsewhere)
    np.testing.assert_allclose(one.positions, two.positions, atol=1e-9)
    heads, rotations = joint_targets(two)
    assert np.abs(heads[0, 0, :2]).max() < 1e-9
    assert heads[0, 0, 2] == pytest.approx(joint_targets(made)[0][0, 0, 2])
    assert np.abs(quat.heading(rotations[:20, 0])).max() < 0.2


def test_ground_lies_about_the_origin_as_it_does_about_the_place() -> None:
    normal = np.array([-0.3, 0.2, 1.0]) / np.sqrt(1.13)

    def slope(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return 0.1 + points @ np.array([0.3, -0.2]), np.tile(normal, (len(points), 1))

    points = np.random.default_rng(1).uniform(-3.0, 3.0, (50, 2))
    heights, normals = ground_from(slope, PLACE)(points)
    there = np.column_stack([points, heights]) @ TURN.T + PLACE.position
    np.testing.assert_allclose(slope(there[:, :2])[0], there[:, 2], atol=1e-9)
    np.testing.assert_allclose(normals @ TURN.T, np.tile(normal, (50, 1)), atol=1e-9)

"""The motion model's body, inputs and answers."""

from __future__ import annotations

import numpy as np
import pytest
from footwork.core.body.motion import Motion
from footwork.core.body.skeleton import SIDES
from footwork.core.maths import quat
from footwork.core.mocap.demo import demo_motion
from footwork.nn.motion.body import HEIGHT, TOE_HEIGHT, ankle_of, put_ankles, starter_skeleton
from footwork.nn.motion.conditions import (
    SIZE,
    Root,
    body_of,
    conditions,
    poses_of,
    root_of,
    soft_contacts,
)


@pytest.fixture(scope="module")
def walk() -> Motion:
    return demo_motion("walk", fps=30.0)


def turned(motion: Motion, yaw: float) -> Motion:
    """The whole motion turned about the vertical and moved 3 m aside."""
    turn = quat.from_yaw(yaw)
    rotations = motion.rotations.copy()
    rotations[:, 0] = quat.multiply(turn, rotations[:, 0])
    return Motion(
        motion.skeleton,
        motion.fps,
        quat.rotate(turn, motion.positions) + np.array([3.0, -1.0, 0.0]),
        rotations,
    )


def test_the_body_is_symmetric_stands_on_the_floor_and_is_as_tall_as_it_says() -> None:
    body = starter_skeleton()
    places = body.tpose_positions()
    left, right = ([j for j, role in enumerate(body.roles) if role.endswith(f".{s}")] for s in SIDES)
    assert np.allclose(places[left] * (-1.0, 1.0, 1.0), places[right])
    assert places[body.joint("toe.L"), 2] == pytest.approx(TOE_HEIGHT)
    head = body.joint("head")
    assert places[head, 2] + body.tips[head, 2] == pytest.approx(HEIGHT, abs=0.04)


def test_poses_come_back_as_the_same_body(walk: Motion) -> None:
    root = root_of(walk)
    hips, rotations = body_of(poses_of(walk, root), root)
    _, wanted = walk.forward()
    assert np.allclose(hips, walk.positions, atol=1e-9)
    assert np.allclose(np.abs(np.sum(rotations * wanted, axis=-1)), 1.0, atol=1e-9)


def test_what_the_model_is_told_does_not_depend_on_place_and_facing(walk: Motion) -> None:
    steps = soft_contacts(np.ones((len(walk), 2)), walk.fps)
    here, there = (conditions(root_of(motion), steps) for motion in (walk, turned(walk, 2.5)))
    assert here.shape == (len(walk), SIZE)
    assert np.allclose(here, there, atol=1e-9)


def test_a_straight_way_is_told_in_metres_ahead() -> None:
    count, fps, speed = 121, 60.0, 1.2
    way = np.column_stack([np.zeros(count), speed * np.arange(count) / fps])
    root = Root(fps, way, np.zeros(count), np.full(count, 0.9))
    middle = conditions(root, np.zeros((count, 2)))[60, :65].reshape(13, 5)
    assert np.allclose(middle[:, 1], speed * np.arange(-6, 7) / 6.0)
    assert np.allclose(middle[:, [0, 2]], 0.0)
    assert np.allclose(middle[:, 3], 1.0)
    assert np.allclose(middle[:, 4], 0.9)


def test_contacts_lose_nothing_by_softening() -> None:
    hard = np.zeros((90, 2))
    hard[30:60, 0] = 1.0
    soft = soft_contacts(hard, 30.0)
    assert soft.sum() == pytest.approx(30.0)
    assert soft[45, 0] == pytest.approx(1.0)
    assert not soft[:, 1].any()


def test_ankles_come_to_their_places_and_knees_stay_in_front() -> None:
    body = starter_skeleton()
    count = 20
    rotations = np.tile(quat.IDENTITY, (count, len(body), 1))
    hips = np.tile(body.offsets[0] + np.array([0.0, 0.02, -0.1]), (count, 1))
    places, world = Motion(body, 60.0, hips, rotations).forward()
    toes = np.array([[-0.1, 0.1, TOE_HEIGHT], [0.1, 0.2, TOE_HEIGHT]])
    ankles = np.stack(
        [ankle_of(body, s, np.tile(toes[i], (count, 1)), world[:, 0]) for i, s in enumerate(SIDES)], 1
    )
    out = put_ankles(body, places, world, ankles)
    for i, side in enumerate(SIDES):
        thigh, shin, foot = (body.joint(f"{part}.{side}") for part in ("thigh", "shin", "foot"))
        knee = places[:, thigh] + quat.rotate(out[:, thigh], body.offsets[shin])
        end = knee + quat.rotate(out[:, shin], body.offsets[foot])
        assert np.allclose(end, ankles[:, i], atol=1e-9)
        assert np.all(knee[:, 1] > 0.5 * (places[:, thigh] + end)[:, 1])

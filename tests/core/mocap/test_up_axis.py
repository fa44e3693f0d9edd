"""The up axis of takes in which nobody stands: the floor tells it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.body.edit import cut
from footwork.core.body.motion import Motion
from footwork.core.maths import quat
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.export import to_bvh
from footwork.core.mocap.raw_body import find_up, reduce_to_body


def on_all_fours(motion: Motion, pitch: float) -> Motion:
    """The body tipped forward, with its lowest joint on the floor."""
    yaws = quat.from_yaw(quat.heading(motion.rotations[:, 0]))
    tipped = quat.multiply(quat.multiply(yaws, quat.from_axis("X", -pitch)), quat.conjugate(yaws))
    rotations = motion.rotations.copy()
    rotations[:, 0] = quat.multiply(tipped, rotations[:, 0])
    down = replace(motion, rotations=rotations)
    lowest = down.forward()[0][..., 2].min(axis=1)
    return replace(down, positions=down.positions - lowest[:, None] * [0.0, 0.0, 1.0])


@pytest.mark.parametrize("pitch", [75.0, 90.0, 105.0])
@pytest.mark.parametrize("yaw", [0.0, 0.9, 1.57, -2.2])
@pytest.mark.parametrize("script", ["walk", "crouch", "visit"])
def test_who_crawls_is_on_the_floor(script: str, yaw: float, pitch: float) -> None:
    motion = on_all_fours(cut(demo_motion(script, 2, 30.0), 30, 330), np.radians(pitch))
    turn = quat.from_yaw(yaw)
    rotations = motion.rotations.copy()
    rotations[:, 0] = quat.multiply(turn, rotations[:, 0])
    motion = replace(motion, positions=quat.rotate(turn, motion.positions), rotations=rotations)
    body = reduce_to_body(to_bvh(motion, "crawl"), motion.skeleton.roles)
    assert find_up(body)[0] == "Y"
    assert find_up(body.turned(quat.from_axis("X", np.pi / 2), 1.0))[0] == "Z"


@pytest.mark.parametrize("script", ["walk", "crouch", "visit", "turn"])
def test_who_stands_tells_it_by_standing(script: str) -> None:
    motion = demo_motion(script, 5, 30.0)
    body = reduce_to_body(to_bvh(motion, script), motion.skeleton.roles)
    for found, axis in ((body, "Y"), (body.turned(quat.from_axis("X", np.pi / 2), 1.0), "Z")):
        up, share = find_up(found)
        assert up == axis and share > 0.7

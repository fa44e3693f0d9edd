"""The height of people at ease, whatever else they do in a take."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.body.standing import standing_head_height, standing_height
from footwork.core.mocap.demo import demo_motion


def test_standing_is_found_between_crouching_and_tip_toe() -> None:
    heights = np.concatenate([np.full(500, 1.0), np.full(300, 1.6), np.full(60, 1.75)])
    assert standing_height(heights, np.zeros(860)) == pytest.approx(1.6)


def test_fast_frames_do_not_count() -> None:
    heights = np.concatenate([np.full(300, 1.6), np.full(500, 1.8)])
    speeds = np.concatenate([np.zeros(300), np.full(500, 2.0)])
    assert standing_height(heights, speeds) == pytest.approx(1.6)


def test_a_body_twice_as_large_stands_twice_as_high() -> None:
    small, large = (standing_head_height(demo_motion("walk", height=height)) for height in (0.9, 1.8))
    assert large == pytest.approx(2.0 * small, rel=0.01)


def test_a_take_without_anyone_standing_stays_near_the_t_pose() -> None:
    motion = demo_motion("crouch")
    tall = motion.skeleton.tpose_positions()[motion.skeleton.joint("head"), 2]
    assert standing_head_height(motion) == pytest.approx(0.95 * tall)
    floating = replace(motion, positions=motion.positions + np.array([0.0, 0.0, 3.0]))
    assert standing_head_height(floating) == pytest.approx(tall)

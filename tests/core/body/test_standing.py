"""The height of people at ease, whatever else they do in a take."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.body.motion import Motion
from footwork.core.body.standing import standing_head_height, standing_height
from footwork.core.mocap.demo import demo_motion, demo_skeleton


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


def spread(*stretches: tuple[float, float, int]) -> np.ndarray:
    """Heights that run evenly from one to another, for each (from, to, frames)."""
    return np.concatenate([np.linspace(*stretch) for stretch in stretches])


@pytest.mark.parametrize("shuffled", [False, True])
@pytest.mark.parametrize(("share", "found"), [(0.14, 1.2), (0.16, 1.7)])
def test_the_highest_place_held_for_fifteen_percent_counts(
    share: float, found: float, shuffled: bool
) -> None:
    high = round(1000 * share)
    heights = np.r_[np.full(high, 1.7), np.full(1000 - high, 1.2)]
    if shuffled:
        heights = np.random.default_rng(0).permutation(heights)
    assert standing_height(heights, np.zeros(1000)) == pytest.approx(found)


@pytest.mark.parametrize(("band", "found"), [(0.055, 1.7 - 0.0275), (0.2, 1.2)])
def test_standing_people_sway_by_six_centimetres(band: float, found: float) -> None:
    # 20 % of the frames: all within a band that is narrow enough, or too few in any
    heights = spread((1.7 - band, 1.7, 200), (1.2, 1.2, 800))
    assert standing_height(heights, np.zeros(1000)) == pytest.approx(found, abs=1e-3)


def test_one_held_for_exactly_its_share_counts() -> None:
    heights = np.r_[np.full(15, 1.7), np.full(85, 1.0)]
    assert standing_height(heights, np.zeros(100)) == 1.7


def test_who_never_stands_is_nearly_as_high_as_at_most() -> None:
    heights = np.random.default_rng(1).permutation(np.linspace(0.0, 10.0, 101))
    assert standing_height(heights, np.zeros(101)) == pytest.approx(9.5)


@pytest.mark.parametrize(("speed", "found"), [(0.29, 1.8), (0.31, 1.6)])
def test_three_decimetres_per_second_are_slow_enough(speed: float, found: float) -> None:
    heights = np.r_[np.full(300, 1.6), np.full(300, 1.8)]
    speeds = np.r_[np.zeros(300), np.full(300, speed)]
    assert standing_height(heights, speeds) == pytest.approx(found)


@pytest.mark.parametrize(("slow", "found"), [(9, 1.8), (10, 1.6)])
def test_where_few_frames_are_slow_all_count(slow: int, found: float) -> None:
    heights = np.r_[np.full(slow, 1.6), np.full(100 - slow, 1.8)]
    speeds = np.r_[np.zeros(slow), np.full(100 - slow, 2.0)]
    assert standing_height(heights, speeds) == pytest.approx(found)


def gliding(fps: float, *stretches: tuple[float, float, float]) -> Motion:
    """A stiff body at shares of its T-pose height: (share, metres per second over the ground, seconds) each."""
    body = demo_skeleton(1.7)
    head = body.tpose_positions()[body.joint("head"), 2]
    shares, speeds = (
        np.concatenate(
            [np.full(round(seconds * fps), (share, speed)[i]) for share, speed, seconds in stretches]
        )
        for i in (0, 1)
    )
    positions = np.zeros((len(shares), 3))
    positions[:, :2] = np.cumsum(speeds / fps)[:, None] * [0.6, 0.8]
    positions[:, 2] = body.offsets[0, 2] + (shares - 1.0) * head
    return Motion(body, fps, positions, np.tile([1.0, 0, 0, 0], (len(shares), len(body), 1)))


def share_of_t_pose(*motions: Motion) -> float:
    body = motions[0].skeleton
    return standing_head_height(*motions) / body.tpose_positions()[body.joint("head"), 2]


@pytest.mark.parametrize("fps", [5.0, 24.0, 60.0, 120.0])
def test_standing_people_are_found_at_any_rate(fps: float) -> None:
    slow = gliding(fps, (0.96, 0.0, 6.0), (0.99, 0.28, 7.0))
    fast = gliding(fps, (0.96, 0.0, 6.0), (0.99, 0.32, 7.0))
    # within the band of 6 cm both heights count where both are slow
    assert share_of_t_pose(fast) == pytest.approx(0.96, abs=2e-3)
    assert share_of_t_pose(slow) > 0.97


def test_several_takes_of_a_body_are_measured_together() -> None:
    crouching, standing = gliding(60.0, (0.7, 0.0, 20.0)), gliding(30.0, (0.98, 0.0, 5.0))
    assert share_of_t_pose(crouching) == pytest.approx(0.95)
    assert share_of_t_pose(crouching, standing) == pytest.approx(0.98)
    assert share_of_t_pose(standing, crouching) == pytest.approx(0.98)


@pytest.mark.parametrize(("share", "found"), [(0.90, 0.95), (0.951, 0.951), (0.999, 0.999), (1.02, 1.0)])
def test_nobody_stands_much_lower_or_higher_than_the_t_pose(share: float, found: float) -> None:
    assert share_of_t_pose(gliding(60.0, (share, 0.0, 3.0))) == pytest.approx(found)


def test_one_frame_is_enough() -> None:
    assert share_of_t_pose(gliding(60.0, (0.97, 0.0, 0.02))) == pytest.approx(0.97)

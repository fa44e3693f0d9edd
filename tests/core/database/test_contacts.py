from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.body.toes import toe_places, toe_positions
from footwork.core.database.contacts import find_contacts, resample_contacts
from footwork.core.mocap.demo import demo_motion, demo_skeleton


def toes_along(distance: np.ndarray) -> np.ndarray:
    """Left toe moved along a slanted line, right toe at rest."""
    toes = np.zeros((len(distance), 2, 3))
    toes[:, 0] = distance[:, None] * np.array([0.6, 0.0, 0.8])
    return toes


@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0])
def test_rest_and_step(fps: float) -> None:
    t = np.arange(round(3.0 * fps)) / fps
    distance = np.clip(t - 1.0, 0.0, 1.0)
    contacts = find_contacts(toes_along(distance), fps)
    moving = (t > 1.0) & (t < 2.0)
    assert contacts[:, 1].all()
    # central differences see the border frames half moving
    assert np.count_nonzero(contacts[:, 0] == moving) <= 2


@pytest.mark.parametrize(("frames", "kept"), [(6, False), (7, True)])
def test_short_blips_go(frames: int, kept: bool) -> None:
    # 13 frames at 60 per second: a run of 7 is a majority, one of 6 is not
    # held from frame 50 on, so that central differences vanish on `frames` frames
    held = frames + 2
    place = np.concatenate([np.arange(51), np.full(held - 2, 50), np.arange(50, 110)]) / 60.0
    contacts = find_contacts(toes_along(place), 60.0)
    assert contacts[:, 0].any() == kept


def test_threshold_is_speed_in_three_dimensions() -> None:
    t = np.arange(120) / 60.0
    for speed, expected in ((0.149, True), (0.151, False)):
        assert find_contacts(toes_along(speed * t), 60.0)[:, 0].all() == expected
        assert find_contacts(toes_along(speed * t), 60.0)[:, 0].any() == expected


def test_planted_feet_of_a_walk_are_found() -> None:
    motion = demo_motion("walk")
    toes = toe_positions(motion)
    contacts = find_contacts(toes, motion.fps)
    # planted exactly by construction: a toe that does not move over 15 frames is in its stance
    still = np.abs(toes[15:] - toes[:-15]).max(axis=-1) < 1e-6
    middle = np.zeros_like(contacts)
    middle[7 : len(toes) - 8] = still
    assert middle.sum() > 500
    assert contacts[middle].all()
    assert not contacts[np.linalg.norm(np.gradient(toes, axis=0), axis=-1) * 60.0 > 1.0].any()


def test_skeletons_without_toes() -> None:
    motion = demo_motion("turn")
    whole = motion.skeleton
    expected = toe_positions(motion)
    roles = tuple("" if role.startswith("toe") else role for role in whole.roles)
    guessed = toe_positions(replace(motion, skeleton=replace(whole, roles=roles)))
    # a guess from leg length: within 5 cm of the demo's own toes
    assert np.linalg.norm(guessed - expected, axis=-1).max() < 0.05
    tips = whole.tips.copy()
    for side in "LR":
        tips[whole.joint(f"foot.{side}")] = whole.offsets[whole.joint(f"toe.{side}")]
    tipped = toe_positions(replace(motion, skeleton=replace(whole, roles=roles, tips=tips)))
    np.testing.assert_allclose(tipped, expected, atol=1e-12)


def test_toe_joints() -> None:
    skeleton = demo_skeleton()
    joints, offsets = toe_places(skeleton)
    assert [skeleton.names[j] for j in joints] == ["LeftToe", "RightToe"]
    assert not offsets.any()


@pytest.mark.parametrize(
    ("to", "expected"),
    [
        (10.0, "..###..##"),
        # halfway between two frames the later one
        (20.0, "...######....####"),
        # frames 0, 2, 4, 6, 8; then 0, 4, 8
        (5.0, ".##.#"),
        (2.5, ".##"),
        # times 0, 0.125, ... 0.75 s: frames 0, 1.25, 2.5, 3.75, 5, 6.25, 7.5
        (8.0, "..##..#"),
    ],
)
def test_contacts_at_another_rate(to: float, expected: str) -> None:
    column = np.array([letter == "#" for letter in "..###..##"])
    shown = resample_contacts(np.column_stack([column, ~column]), 10.0, to)
    wanted = np.array([letter == "#" for letter in expected])
    np.testing.assert_array_equal(shown, np.column_stack([wanted, ~wanted]))

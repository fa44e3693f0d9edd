"""Legs, toes, pelvis, spine and neck of bodies with other joints than the usual, by hand from their table."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from footwork.core.body import trunk
from footwork.core.body.legs import Leg, legs_of
from footwork.core.body.skeleton import Skeleton
from footwork.core.body.toes import place_toes, toe_places, toe_positions
from scipy.spatial.transform import Rotation

SEEDS = [None, 1, 2]
TOE_OF_LEG = np.array([0.0, 0.21, -0.095])


def named(skeleton: Skeleton, joints: list[int]) -> list[str]:
    return [skeleton.names[joint] for joint in joints]


def with_tip(skeleton: Skeleton, name: str, tip: tuple[float, ...]) -> Skeleton:
    tips = skeleton.tips.copy()
    tips[skeleton.names.index(name)] = tip
    return replace(skeleton, tips=tips)


@pytest.mark.parametrize("seed", SEEDS)
def test_trunk_of_a_body_with_joints_in_between(crooked, seed: int | None) -> None:
    body: Skeleton = crooked(seed)
    assert named(body, trunk.pelvis(body)) == ["hips", "pelvis"]
    assert named(body, trunk.spine(body)) == ["pelvis", "back", "between", "breast"]
    assert named(body, trunk.neck(body)) == ["nape", "atlas"]
    middle = (np.array([-0.09, 0.01, -0.04]) + np.array([0.1, 0.0, -0.05])) / 2.0 + np.array(
        [0.0, 0.01, -0.03]
    )
    np.testing.assert_allclose(trunk.thighs_middle(body), middle, atol=1e-15)


@pytest.mark.parametrize(
    ("parts", "pelvis", "spine", "neck"),
    [
        (("chest",), ["hips", "pelvis"], ["pelvis", "back", "between"], ["nape", "atlas"]),
        (("neck",), ["hips", "pelvis"], ["pelvis", "back", "between", "breast"], ["atlas"]),
        # with neither chest nor neck all joints below the head are the back
        (("chest", "neck"), ["hips", "pelvis"], ["pelvis", "back", "between", "atlas"], []),
        (("spine1", ""), ["hips"], ["hips", "breast"], ["nape"]),
        (("spine1", "chest", ""), ["hips"], ["hips"], ["nape"]),
        (("spine1", "chest", "neck", ""), ["hips"], ["hips"], []),
    ],
)
def test_trunk_of_bodies_that_lack_joints(
    crooked, without, parts: tuple[str, ...], pelvis: list[str], spine: list[str], neck: list[str]
) -> None:
    body = without(crooked(), *parts)
    assert named(body, trunk.pelvis(body)) == pelvis
    assert named(body, trunk.spine(body)) == spine
    assert named(body, trunk.neck(body)) == neck


def test_one_thigh_that_hangs_lower_makes_the_pelvis_longer(crooked) -> None:
    body: Skeleton = crooked()
    parents = body.parents.copy()
    parents[body.joint("thigh.R")] = body.joint("spine1")
    assert named(body, trunk.pelvis(replace(body, parents=parents))) == ["hips", "pelvis", "back"]


@pytest.mark.parametrize("seed", SEEDS)
def test_what_stands_for_a_toe(crooked, seed: int | None) -> None:
    body: Skeleton = crooked(seed)
    joints, offsets = toe_places(body)
    assert named(body, joints.tolist()) == ["toe l", "foot r"]
    np.testing.assert_array_equal(offsets, [[0, 0, 0], [0.02, 0.13, -0.07]])
    unknown = with_tip(body, "foot r", (0.0, 0.0, 0.0))
    np.testing.assert_allclose(
        toe_places(unknown)[1], [[0, 0, 0], TOE_OF_LEG * body.leg_length()], atol=1e-15
    )


@pytest.mark.parametrize(("length", "known"), [(0.0, False), (0.0099, False), (0.0101, True), (0.2, True)])
def test_a_foot_of_less_than_a_centimetre_has_no_known_tip(crooked, length: float, known: bool) -> None:
    tip = (0.6 * length, 0.64 * length, -0.48 * length)
    body = with_tip(crooked(), "foot r", tip)
    expected = tip if known else TOE_OF_LEG * body.leg_length()
    np.testing.assert_allclose(toe_places(body)[1][1], expected, atol=1e-15)


def test_toes_in_the_world_turn_with_what_carries_them(crooked, moved) -> None:
    motion = moved(crooked(4))
    body = motion.skeleton
    positions, rotations = motion.forward()
    toe, foot = body.joint("toe.L"), body.joint("foot.R")
    turned = Rotation.from_quat(np.roll(rotations[:, foot], -1, axis=-1)).apply([0.02, 0.13, -0.07])
    expected = np.stack([positions[:, toe], positions[:, foot] + turned], axis=1)
    np.testing.assert_allclose(toe_positions(motion), expected, atol=1e-12)
    np.testing.assert_allclose(place_toes(body, positions, rotations), expected, atol=1e-12)


@pytest.mark.parametrize("seed", SEEDS)
def test_measures_of_a_leg_with_a_toe_and_of_one_without(
    crooked: Callable[..., Skeleton], seed: int | None
) -> None:
    body = crooked(seed)
    left, right = legs_of(body)
    assert named(body, [left.thigh, left.shin, left.foot, left.end]) == [
        "thigh l",
        "shin l",
        "foot l",
        "toe l",
    ]
    assert named(body, [right.thigh, right.shin, right.foot, right.end]) == [
        "thigh r", "shin r", "foot r", "foot r",
    ]  # fmt: skip
    thigh, shin = np.linalg.norm([0.03, 0.01, -0.42]), np.linalg.norm([-0.03, -0.03, -0.4])
    np.testing.assert_allclose(left.bones, [thigh, shin], atol=1e-12)
    assert left.length == pytest.approx(thigh + shin, abs=1e-12)
    np.testing.assert_allclose(left.shift, [0, 0, 0])
    np.testing.assert_allclose(right.shift, [0.02, 0.13, -0.07])
    np.testing.assert_allclose(left.to_toe, [-0.02, 0.14, -0.06], atol=1e-12)
    np.testing.assert_allclose(right.to_toe, [0.02, 0.13, -0.07], atol=1e-12)
    assert left.height == pytest.approx(0.97 - 0.03 - 0.04 - 0.2 - 0.22 - 0.4 - 0.06, abs=1e-12)
    assert right.height == pytest.approx(0.97 - 0.03 - 0.05 - 0.41 - 0.39 - 0.07, abs=1e-12)
    # on hips 2.5 cm lower the right toe would be below the floor, and the left as much nearer to it
    low = legs_of(replace(body, offsets=body.offsets - np.eye(len(body), 1) * [0.0, 0.0, 0.025]))
    assert low[1].height == 0.0
    assert low[0].height == pytest.approx(max(left.height - 0.025, 0.0), abs=1e-12)
    np.testing.assert_allclose(left.tip, [0.01, 0.06, -0.01])
    np.testing.assert_allclose(left.to_tip, left.tip)
    np.testing.assert_array_equal(right.to_tip, [0.0, 0.0, 0.0])


def test_angles_and_heel_of_a_foot(crooked) -> None:
    leg: Leg = legs_of(crooked())[0]
    # 14 cm back and 6 cm up from toe to ankle; the heel is 1.35 times as far back, on the floor
    assert leg.radius == pytest.approx(np.sqrt(0.14**2 + 0.06**2), abs=1e-12)
    assert np.tan(leg.flat) == pytest.approx(0.06 / 0.14, abs=1e-12)
    np.testing.assert_allclose(leg.heel, [0.0, -1.35 * 0.14, -leg.height], atol=1e-12)


@pytest.mark.parametrize(("length", "known"), [(0.0, False), (0.0049, False), (0.0051, True)])
def test_a_toe_of_less_than_five_millimetres_has_half_the_foots_length(
    crooked, length: float, known: bool
) -> None:
    tip = (0.6 * length, 0.8 * length, 0.0)
    leg: Leg = legs_of(with_tip(crooked(), "toe l", tip))[0]
    np.testing.assert_allclose(leg.tip, tip if known else [0.0, 0.07, 0.0], atol=1e-12)
    np.testing.assert_allclose(leg.to_tip, leg.tip)

"""Hands at their targets, and arms that look like arms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.body.motion import Motion
from footwork.core.body.skeleton import SIDES
from footwork.core.mocap.demo import demo_skeleton
from footwork.core.rig.arms import reach_hands
from scipy.spatial.transform import Rotation

SKELETON = demo_skeleton()
PLACES = SKELETON.tpose_positions()
SHOULDERS = PLACES[[SKELETON.joint(f"upper_arm.{side}") for side in SIDES]]
ARM = 0.54
"""Metres from shoulder to wrist of the demo's body."""
OUT = np.array([[-1.0, 1.0, 1.0], [1.0, 1.0, 1.0]])
"""Signs that make a right arm's vector either side's."""


def standing(frames: int) -> Motion:
    rotations = np.tile([1.0, 0, 0, 0], (frames, len(SKELETON), 1))
    return Motion(SKELETON, 60.0, np.tile(SKELETON.offsets[0], (frames, 1)), rotations)


def wxyz(rotation: Rotation) -> np.ndarray:
    return np.roll(rotation.as_quat(), 1, axis=-1)


def pointing(way: np.ndarray, roll: float = 0.0) -> np.ndarray:
    """Rotations `(2, 4)` of hands whose fingers point along a right arm's vector, thumb up, rolled in degrees."""
    out = []
    for sign in OUT:
        fingers = sign * way / np.linalg.norm(way)
        # in T-pose the thumb looks forward: its axis goes as near to up as the fingers let it
        thumb = np.array([0, 0, 1.0]) - fingers[2] * fingers
        thumb /= np.linalg.norm(thumb)
        x = sign[0] * fingers
        axes = np.stack([x, thumb, np.cross(x, thumb)], axis=-1)
        out.append(wxyz(Rotation.from_rotvec(np.radians(roll) * fingers) * Rotation.from_matrix(axes)))
    return np.stack(out)


def reach(way: np.ndarray, hands: np.ndarray, frames: int = 90) -> tuple[Motion, np.ndarray, np.ndarray]:
    """Both hands of a standing body at `way` from the shoulder, as a right arm sees it."""
    targets = np.tile(SHOULDERS + OUT * way, (frames, 1, 1))
    done, missed = reach_hands(
        standing(frames), targets, np.tile(hands, (frames, 1, 1)), np.ones((frames, 2), np.bool_)
    )
    return done, missed, targets


FORWARD, DOWN, ACROSS, UP, SIDE = (
    np.array(v)
    for v in ([0.05, 0.4, -0.1], [0.08, 0.08, -0.48], [-0.2, 0.25, 0.0], [0.1, 0.15, 0.45], [0.45, 0.1, 0.0])
)


@pytest.mark.parametrize("way", [FORWARD, DOWN, ACROSS, UP, SIDE])
@pytest.mark.parametrize("roll", [-60.0, 0.0, 60.0])
def test_hands_are_at_their_targets(way: np.ndarray, roll: float, world, degrees_between) -> None:
    hands = pointing(np.array([0.1, 1.0, 0.1]), roll)
    done, missed, targets = reach(way, hands)
    assert not missed.any()
    for i, side in enumerate(SIDES):
        place, turn = world(done, f"hand.{side}")
        assert np.linalg.norm(place - targets[:, i], axis=-1).max() < 1e-6
        assert degrees_between(turn, np.tile(hands[i], (90, 1))).max() < 1e-5


@pytest.mark.parametrize("way", [FORWARD, DOWN, ACROSS, SIDE])
def test_elbows_are_low_outside_or_behind(way: np.ndarray, world) -> None:
    done, _, _ = reach(way, pointing(np.array([0.1, 1.0, 0.0])))
    for i, side in enumerate(SIDES):
        shoulder, elbow, wrist = (
            world(done, f"{part}.{side}")[0][45] for part in ("upper_arm", "forearm", "hand")
        )
        middle = 0.5 * (shoulder + wrist)
        bend = (elbow - middle) * OUT[i]
        assert bend[2] < 0.03 and bend[1] < 0.05
        assert bend @ np.array([0.4, -0.4, -0.85]) > 0.05


def test_elbows_go_where_the_trackers_tell_them_to_be(world) -> None:
    hands = np.tile(np.array([[-0.35, 0.35, 1.15], [0.3, 0.4, 1.25]]), (90, 1, 1))
    turns = np.tile([1.0, 0.0, 0.0, 0.0], (90, 2, 1))
    body = standing(90)
    free, _ = reach_hands(body, hands, turns, np.ones((90, 2), np.bool_))
    for height in (-0.6, 0.4):
        # the same arms, swivelled about the line from shoulder to hand
        told = np.tile(np.array([[-0.7, -0.4, height], [0.7, -0.4, height]]), (90, 1, 1))
        told /= np.linalg.norm(told, axis=-1, keepdims=True)
        placed, _ = reach_hands(body, hands, turns, np.ones((90, 2), np.bool_), told)
        for i, side in enumerate(SIDES):
            np.testing.assert_allclose(world(placed, f"hand.{side}")[0], hands[:, i], atol=1e-6)
            line = hands[45, i] - world(placed, f"upper_arm.{side}")[0][45]
            line /= np.linalg.norm(line)

            def aside(
                point: np.ndarray, line: np.ndarray = line, hand: np.ndarray = hands[45, i]
            ) -> np.ndarray:
                out = point - hand - line * ((point - hand) @ line)
                return out / np.linalg.norm(out)

            goal = aside(hands[45, i] + told[45, i])
            found, own = (aside(world(motion, f"forearm.{side}")[0][45]) for motion in (placed, free))
            assert np.arccos(found @ goal) < 0.6 * np.arccos(own @ goal) + 0.05


def test_left_and_right_are_mirror_images(world) -> None:
    done, _, _ = reach(ACROSS, pointing(np.array([-0.3, 1.0, 0.2])))
    left, right = (world(done, f"forearm.{side}")[0][45] for side in SIDES)
    np.testing.assert_allclose(left, right * [-1, 1, 1], atol=1e-9)


def test_the_elbow_is_a_hinge(world) -> None:
    """The forearm turns against the upper arm about the hinge, which is upright in T-pose, and about itself only."""
    done, _, _ = reach(FORWARD, pointing(FORWARD))
    upper, lower = (
        Rotation.from_quat(np.roll(world(done, f"{p}.R")[1][45], -1)) for p in ("upper_arm", "forearm")
    )
    along = (upper.inv() * lower).apply([1.0, 0, 0])
    assert abs(along[2]) < 1e-6 and along[1] > 0.1


def test_the_forearm_takes_a_share_of_the_twist(world, degrees_between) -> None:
    turned = {}
    for roll in (0.0, 60.0):
        done, _, _ = reach(FORWARD, pointing(FORWARD, roll))
        turned[roll] = {part: world(done, f"{part}.R")[1][45] for part in ("upper_arm", "forearm", "hand")}
    by = {part: degrees_between(turned[60.0][part], turned[0.0][part]) for part in turned[0.0]}
    assert by["hand"] == pytest.approx(60, abs=1e-6)
    assert 25 < by["forearm"] < 50 and by["upper_arm"] < 8


def test_clavicles_help_at_full_reach(world) -> None:
    ahead = np.array([0.0, 1.0, 0.0])
    near, _, _ = reach(0.6 * ARM * ahead, pointing(ahead))
    far, missed, targets = reach(1.02 * ARM * ahead, pointing(ahead))
    assert not missed.any()
    for i, side in enumerate(SIDES):
        rest = SHOULDERS[i, 1]
        assert abs(world(near, f"upper_arm.{side}")[0][45, 1] - rest) < 0.006
        assert world(far, f"upper_arm.{side}")[0][45, 1] - rest > 0.02
        assert np.linalg.norm(world(far, f"hand.{side}")[0] - targets[:, i], axis=-1).max() < 1e-3


def test_out_of_reach_the_arm_is_straight_towards_the_target(world) -> None:
    way = np.array([0.3, 0.8, 0.1])
    done, missed, targets = reach(way, pointing(way))
    assert missed.all()
    for i, side in enumerate(SIDES):
        shoulder, elbow, wrist = (
            world(done, f"{part}.{side}")[0][45] for part in ("upper_arm", "forearm", "hand")
        )
        assert np.linalg.norm(wrist - shoulder) > ARM - 2e-3
        towards = (targets[45, i] - shoulder) / np.linalg.norm(targets[45, i] - shoulder)
        assert (wrist - shoulder) @ towards / np.linalg.norm(wrist - shoulder) > 0.9999
        assert np.linalg.norm(np.cross(elbow - shoulder, towards)) < 0.04


def test_a_lost_controller_leaves_its_arm_to_the_motion(
    visit: Motion, walk: Motion, world, degrees_between
) -> None:
    frames = min(len(visit), len(walk))
    body = replace(walk, positions=walk.positions[:frames], rotations=walk.rotations[:frames])
    chest, towards = world(body, "chest"), world(visit, "chest")
    targets, hands = np.empty((frames, 2, 3)), np.empty((frames, 2, 4))
    for i, side in enumerate(SIDES):
        place, turn = (value[:frames] for value in world(visit, f"hand.{side}"))
        back = Rotation.from_quat(np.roll(chest[1], -1, axis=-1))
        away = Rotation.from_quat(np.roll(towards[1][:frames], -1, axis=-1)).inv()
        targets[:, i] = chest[0] + (back * away).apply(place - towards[0][:frames])
        hands[:, i] = wxyz(back * away * Rotation.from_quat(np.roll(turn, -1, axis=-1)))
    valid = np.ones((frames, 2), np.bool_)
    valid[400:520, 0] = False
    valid[700:706, 0] = False
    targets[~valid], hands[~valid] = np.nan, np.nan
    done, missed = reach_hands(body, targets, hands, valid)
    assert np.isfinite(done.rotations).all() and not missed[~valid].any()
    joints = [SKELETON.joint(f"{part}.L") for part in ("clavicle", "upper_arm", "forearm", "hand")]
    np.testing.assert_allclose(done.rotations[413:507, joints], body.rotations[413:507, joints], atol=1e-6)
    place = world(done, "hand.L")[0]
    known = valid[:, 0] & ~missed[:, 0]
    assert np.linalg.norm(place[known] - targets[known, 0], axis=-1).max() < 1e-3
    for joint in joints:
        steps = degrees_between(done.rotations[1:, joint], done.rotations[:-1, joint])
        assert steps[380:540].max() < 15.0


def test_a_smooth_circle_moves_the_arm_smoothly(degrees_between) -> None:
    frames = 360
    angle = np.linspace(0.0, 4.0 * np.pi, frames)
    way = np.stack([0.1 + 0.15 * np.cos(angle), np.full(frames, 0.3), 0.2 * np.sin(angle)], axis=-1)
    targets = SHOULDERS + OUT * way[:, None]
    hands = np.tile(pointing(np.array([0.0, 1.0, 0.1])), (frames, 1, 1))
    done, missed = reach_hands(standing(frames), targets, hands, np.ones((frames, 2), np.bool_))
    assert not missed.any()
    for part in ("clavicle", "upper_arm", "forearm", "hand"):
        turns = Rotation.from_quat(np.roll(done.rotations[:, SKELETON.joint(f"{part}.R")], -1, axis=-1))
        speed = (turns[1:] * turns[:-1].inv()).as_rotvec(degrees=True) * 60.0
        acceleration = np.linalg.norm(np.diff(speed, axis=0), axis=-1) * 60.0
        assert acceleration.max() < 4000.0, part


@pytest.mark.parametrize("frames", [1, 2, 4])
def test_short_motions(frames: int) -> None:
    done, _, _ = reach(FORWARD, pointing(FORWARD), frames)
    assert np.isfinite(done.rotations).all() and len(done) == frames


def test_a_clavicle_that_does_not_carry_its_arm_is_left_alone(world) -> None:
    motion = standing(30)
    skeleton = motion.skeleton
    arm, clavicle = skeleton.joint("upper_arm.L"), skeleton.joint("clavicle.L")
    parents, offsets = skeleton.parents.copy(), skeleton.offsets.copy()
    parents[arm] = parents[clavicle]
    offsets[arm] += offsets[clavicle]
    loose = replace(motion, skeleton=replace(skeleton, parents=parents, offsets=offsets))
    targets = np.tile(SHOULDERS + OUT * np.array([0.1, 0.3, 0.0]), (30, 1, 1))
    done, missed = reach_hands(
        loose, targets, np.tile(pointing(FORWARD), (30, 1, 1)), np.ones((30, 2), np.bool_)
    )
    assert not missed.any()
    for side, name in enumerate(SIDES):
        np.testing.assert_allclose(world(done, f"hand.{name}")[0], targets[:, side], atol=1e-6)
    np.testing.assert_array_equal(done.rotations[:, clavicle], motion.rotations[:, clavicle])


def arm_of(upper: float, fore: float) -> Motion:
    """Demo bodies with a right arm of these lengths, each frame a pose of its own: nothing is smoothed over time."""
    body = standing(1)
    skeleton = body.skeleton
    offsets = skeleton.offsets.copy()
    for role, length in (("forearm.R", upper), ("hand.R", fore)):
        joint = skeleton.joint(role)
        offsets[joint] *= length / np.linalg.norm(offsets[joint])
    return replace(body, skeleton=replace(skeleton, offsets=offsets), fps=1e-3)


def forearms(body: Motion, hands: np.ndarray, turns: np.ndarray, world) -> Rotation:
    """World rotations of the right forearm with the hand at places and turned."""
    count = len(hands)
    many = replace(
        body, positions=np.repeat(body.positions, count, 0), rotations=np.repeat(body.rotations, count, 0)
    )
    left = np.tile(world(body, "hand.L")[0], (count, 1))
    still = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))
    places, wanted = np.stack([left, hands], axis=1), np.stack([still, turns], axis=1)
    placed, _ = reach_hands(many, places, wanted, np.ones((count, 2), np.bool_))
    return Rotation.from_quat(np.roll(world(placed, "forearm.R")[1], -1, axis=-1))


@pytest.mark.parametrize(
    ("upper", "fore"), [(0.29, 0.25), (0.33, 0.25), (0.26, 0.26), (0.2, 0.24), (0.45, 0.4)]
)
def test_a_hand_that_moves_a_centimetre_turns_the_forearm_little(upper: float, fore: float, world) -> None:
    rng, body, count = np.random.default_rng(3), arm_of(upper, fore), 6000
    ways = rng.normal(size=(count, 3))
    ways /= np.linalg.norm(ways, axis=-1, keepdims=True)
    # no arm points back, up and inward
    behind = np.array([-0.2, -0.75, 0.63])
    ways = ways[np.degrees(np.arccos(ways @ (behind / np.linalg.norm(behind)))) > 45.0]
    far = rng.uniform(0.3, 1.0, len(ways)) * (upper + fore)
    hands = world(body, "upper_arm.R")[0] + ways * far[:, None]
    steps = rng.normal(size=hands.shape)
    steps *= 0.01 / np.linalg.norm(steps, axis=-1, keepdims=True)
    turns = wxyz(Rotation.random(len(hands), random_state=4))
    before, after = (forearms(body, at, turns, world) for at in (hands, hands + steps))
    turned = np.degrees((after * before.inv()).magnitude())
    assert np.percentile(turned, 99.0) < 10.0
    assert turned.max() < 25.0


@pytest.mark.parametrize("way", [(0.1, 0.9, -0.1), (-0.5, 0.7, 0.3), (0.3, 0.4, 0.8), (0.2, 0.3, -0.9)])
def test_a_hand_that_comes_to_its_shoulder_turns_no_forearm_over(way: tuple[float, ...], world) -> None:
    """Nearer than sqrt(upper^2 - fore^2), here 0.215 m, the forearm points back along the line."""
    body = arm_of(0.33, 0.25)
    far = np.arange(0.5, 0.115, -0.01)
    hands = world(body, "upper_arm.R")[0] + far[:, None] * np.array(way) / np.linalg.norm(way)
    turns = np.tile(wxyz(Rotation.from_euler("z", 60, degrees=True)), (len(far), 1))
    found = forearms(body, hands, turns, world)
    steps = np.degrees((found[1:] * found[:-1].inv()).magnitude())
    assert steps.max() < 10.0

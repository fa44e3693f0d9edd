"""The head at its target, and what the rest of the body does for it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.body.motion import Motion
from footwork.core.body.retarget import retarget
from footwork.core.mocap.demo import demo_skeleton
from footwork.core.rig.head import _Chain, _shaking, _stoop, place_head
from footwork.core.rig.known import Known
from scipy.spatial.transform import Rotation


def standing(frames: int) -> Motion:
    skeleton = demo_skeleton()
    rotations = np.tile([1.0, 0, 0, 0], (frames, len(skeleton), 1))
    return Motion(skeleton, 60.0, np.tile(skeleton.offsets[0], (frames, 1)), rotations)


def wxyz(rotation: Rotation) -> np.ndarray:
    return np.roll(rotation.as_quat(), 1, axis=-1)


@pytest.fixture(scope="module")
def targets(visit: Motion, walk: Motion, world) -> tuple[np.ndarray, np.ndarray]:
    """A head that moves as another person's does, about where the walking body is."""
    frames = np.arange(len(walk)) % len(visit)
    places, turns = world(visit, "head")
    own = world(walk, "head")[0]
    # the visitor's head relative to a slow copy of its own path
    slow = np.stack(
        [np.convolve(np.pad(c, 90, "edge"), np.ones(181) / 181, "valid") for c in places.T], axis=-1
    )
    slow[:, 2] = np.median(places[:, 2])
    return own + (places - slow)[frames] * np.hanning(len(walk))[:, None], turns[frames]


def all_valid(motion: Motion) -> np.ndarray:
    return np.ones(len(motion), np.bool_)


def test_the_head_is_at_its_target(walk: Motion, targets, world, degrees_between) -> None:
    placed, _ = place_head(walk, *targets, all_valid(walk))
    place, turn = world(placed, "head")
    assert np.linalg.norm(place - targets[0], axis=-1).max() < 1e-9
    assert degrees_between(turn, targets[1]).max() < 1e-5


def test_a_head_that_is_there_changes_nothing(walk: Motion, world) -> None:
    placed, moved = place_head(walk, *world(walk, "head"), all_valid(walk))
    np.testing.assert_allclose(placed.forward()[0], walk.forward()[0], atol=1e-9)
    np.testing.assert_allclose(moved, 0.0, atol=1e-9)


def test_a_look_to_the_side_turns_neck_more_than_chest(world, degrees_between) -> None:
    body = standing(120)
    places, _ = world(body, "head")
    look = np.tile(wxyz(Rotation.from_euler("z", 70, degrees=True)), (120, 1))
    placed, _ = place_head(body, places, look, all_valid(body))
    turned = {
        r: degrees_between(world(placed, r)[1], world(body, r)[1])[60]
        for r in ("hips", "chest", "neck", "head")
    }
    assert turned["head"] == pytest.approx(70, abs=1e-6) and turned["hips"] == pytest.approx(0, abs=1e-6)
    assert 30 < turned["neck"] < 50 and 5 < turned["chest"] < 20
    # the chest stays upright: only its heading goes along
    up = Rotation.from_quat(np.roll(world(placed, "chest")[1][60], -1)).apply([0, 0, 1])
    assert up[2] > 0.9999


def test_a_head_that_turns_all_the_way_round_flips_nothing(world) -> None:
    frames = 360
    body = standing(frames)
    places, _ = world(body, "head")
    look = wxyz(Rotation.from_euler("z", np.arange(frames)[:, None], degrees=True))
    placed, _ = place_head(body, places, look, all_valid(body))
    for role in ("chest", "neck", "spine1"):
        turns = Rotation.from_quat(np.roll(world(placed, role)[1], -1, axis=-1))
        step = np.degrees((turns[1:] * turns[:-1].inv()).magnitude())
        assert step.max() < 3.0, role


def test_a_quick_lean_bends_the_spine_and_a_slow_drift_moves_the_body(world) -> None:
    body = standing(1200)
    places, turns = world(body, "head")
    time = np.arange(1200) / 60.0

    quick = places.copy()
    quick[:, 1] += 0.06 * np.sin(2 * np.pi * 1.0 * time)
    leaning, moved = place_head(body, quick, turns, all_valid(body))
    hips = leaning.positions[300:900, 1]
    assert np.ptp(hips) < 0.04 and np.ptp(moved[300:900, 1]) < 0.02

    slow = places.copy()
    slow[:, 0] += 0.2 * np.sin(2 * np.pi * 0.05 * time)
    drifting, moved = place_head(body, slow, turns, all_valid(body))
    np.testing.assert_allclose(drifting.positions[300:900, 0], slow[300:900, 0], atol=0.01)
    np.testing.assert_allclose(moved[300:900, 0], slow[300:900, 0], atol=0.01)


def test_a_chest_that_is_known_is_held_and_the_head_stays_exact(
    walk: Motion, targets, world, degrees_between
) -> None:
    rng = np.random.default_rng(5)
    time = np.arange(len(walk)) / 60.0
    # leans of up to 40 degrees, slower than what is left to the motion
    lean = np.radians(20.0) * np.sin(np.outer(time, [0.7, 0.5, 0.3]) * 2.0 + rng.uniform(0, 6, 3))
    chest = wxyz(
        Rotation.from_rotvec(lean) * Rotation.from_quat(np.roll(world(walk, "chest")[1], -1, axis=-1))
    )
    roots = walk.positions[:, :2] + np.array([0.05, -0.08])
    placed, _ = place_head(walk, *targets, all_valid(walk), Known(roots, chest))
    np.testing.assert_allclose(world(placed, "head")[0], targets[0], atol=1e-9)
    assert degrees_between(world(placed, "head")[1], targets[1]).max() < 1e-5
    assert degrees_between(world(placed, "chest")[1], chest).mean() < 1.5
    # where nothing is known of it, it stays where the motion has it, but for its share of the head's turn
    free, _ = place_head(walk, *targets, all_valid(walk), Known(roots))
    assert degrees_between(world(free, "chest")[1], chest).mean() > 10.0


def test_trunk_and_knees_bend_together_under_a_head_that_comes_down(world) -> None:
    # a body that bows by 60 degrees from its hips, which stay: the chest that is known tells it from a squat
    body = standing(300)
    bow = np.radians(60.0) * np.sin(np.linspace(0.0, np.pi, 300)) ** 2
    turns = Rotation.from_rotvec(np.outer(-bow, [1.0, 0.0, 0.0]))
    places, _ = world(body, "head")
    bowed = body.positions + turns.apply(places - body.positions)
    squat, _ = place_head(body, bowed, wxyz(turns), all_valid(body))
    known, _ = place_head(
        body, bowed, wxyz(turns), all_valid(body), Known(body.positions[:, :2], wxyz(turns))
    )
    lowest = 100.0 * (body.positions[150, 2] - squat.positions[150, 2])
    assert lowest > 8.0
    assert abs(100.0 * (body.positions[150, 2] - known.positions[150, 2])) < 0.7 * lowest


def test_hips_go_most_of_the_way_to_where_they_should_be_under_a_head_that_stays(world) -> None:
    body = standing(600)
    places, turns = world(body, "head")
    away = np.array([0.03, -0.05])
    roots = np.tile(body.positions[0, :2] + away, (600, 1))
    placed, moved = place_head(body, places, turns, all_valid(body), Known(roots))
    np.testing.assert_allclose(world(placed, "head")[0], places, atol=1e-9)
    gone = placed.positions[:, :2] - body.positions[:, :2]
    np.testing.assert_allclose(gone, np.tile(0.7 * away, (600, 1)), atol=0.006)
    # feet are to go along
    np.testing.assert_allclose(moved, gone, atol=0.001)
    # where the headset was lost nothing is known of the hips either
    lost = all_valid(body)
    lost[200:400] = False
    placed, _ = place_head(body, places, turns, lost, Known(roots))
    np.testing.assert_allclose(placed.positions[280:320], body.positions[280:320], atol=0.001)


def test_the_spine_does_not_bend_past_its_limit(world, degrees_between) -> None:
    body = standing(240)
    places, turns = world(body, "head")
    places[120:] += [0.0, 0.5, 0.0]
    placed, _ = place_head(body, places, turns, all_valid(body))
    assert degrees_between(world(placed, "chest")[1], world(body, "chest")[1]).max() < 21.0
    assert np.linalg.norm(world(placed, "head")[0] - places, axis=-1).max() < 1e-9


@pytest.mark.parametrize("drop", [0.2, 0.45, 0.8])
def test_a_low_head_lowers_and_stoops_the_body_but_not_below_the_floor(drop: float, world) -> None:
    body = standing(120)
    places, turns = world(body, "head")
    places -= [0.0, 0.0, drop]
    placed, _ = place_head(body, places, turns, all_valid(body))
    hips, chest = world(placed, "hips")[0], world(placed, "chest")[0]
    assert hips[60, 2] >= 0.2 * body.skeleton.leg_length()
    assert hips[60, 2] < body.positions[60, 2] - 0.1
    assert chest[60, 1] - hips[60, 1] > 0.03
    if drop < 0.8:
        assert np.linalg.norm(world(placed, "head")[0] - places, axis=-1).max() < 1e-9


def test_a_lost_headset_leaves_the_head_to_the_motion(walk: Motion, targets, world, degrees_between) -> None:
    valid = all_valid(walk)
    valid[300:420] = False
    places, turns = (np.where(valid[:, None], value, np.nan) for value in targets)
    placed, _ = place_head(walk, places, turns, valid)
    assert np.isfinite(placed.rotations).all() and np.isfinite(placed.positions).all()
    middle = slice(320, 400)
    assert degrees_between(world(placed, "head")[1][middle], world(walk, "head")[1][middle]).max() < 1e-4
    head, neck = (walk.skeleton.joint(role) for role in ("head", "neck"))
    assert degrees_between(placed.rotations[middle, neck], walk.rotations[middle, neck]).max() < 3.0
    steps = degrees_between(placed.rotations[1:, head], placed.rotations[:-1, head])
    assert steps[290:430].max() < 8.0


def test_no_headset_at_all_changes_nothing(walk: Motion, targets) -> None:
    placed, moved = place_head(walk, *targets, np.zeros(len(walk), np.bool_))
    assert placed is walk and not moved.any()


@pytest.mark.parametrize(
    "parts",
    [("neck",), ("spine1", "spine2", "spine3", "chest"), ("spine1", "spine2", "spine3", "chest", "neck")],
)
def test_bodies_with_fewer_joints(walk: Motion, targets, without, world, parts: tuple[str, ...]) -> None:
    body = retarget(walk, without(walk.skeleton, *parts))
    placed, _ = place_head(body, *targets, all_valid(walk))
    assert np.linalg.norm(world(placed, "head")[0] - targets[0], axis=-1).max() < 1e-9


@pytest.mark.parametrize("frames", [1, 2, 5])
def test_short_motions(walk: Motion, targets, frames: int, world) -> None:
    short = replace(walk, positions=walk.positions[:frames], rotations=walk.rotations[:frames])
    placed, _ = place_head(short, targets[0][:frames], targets[1][:frames], np.ones(frames, np.bool_))
    assert np.linalg.norm(world(placed, "head")[0] - targets[0][:frames], axis=-1).max() < 1e-9


def test_hips_under_a_steady_head_are_steady_whatever_the_spine_does(world) -> None:
    frames = 600
    body = standing(frames)
    places, turns = world(body, "head")
    swing = np.radians(5.0) * np.sin(2.0 * np.pi * 4.0 * np.arange(frames) / 60.0)
    rotations = body.rotations.copy()
    spine = body.skeleton.joint("spine1")
    rotations[:, spine] = np.stack([np.cos(swing / 2), np.sin(swing / 2), 0 * swing, 0 * swing], axis=-1)
    placed, _ = place_head(replace(body, rotations=rotations), places, turns, all_valid(body))
    assert np.linalg.norm(world(placed, "head")[0] - places, axis=-1).max() < 1e-9
    # the swing moves the head by 4 cm to either side
    assert np.ptp(placed.positions[60:-60, 1]) < 0.008


def bent(degrees: float, frames: int = 1) -> Motion:
    """Standing with the back bent forward in its lowest joint, the rest straight on."""
    body = standing(frames)
    body.rotations[:, body.skeleton.joint("spine1")] = wxyz(Rotation.from_euler("x", -degrees, degrees=True))
    return body


def pitch(rotations: np.ndarray) -> np.ndarray:
    """Degrees forward of rotations that only pitch."""
    return -np.degrees(2.0 * np.arctan2(rotations[..., 1], rotations[..., 0]))


@pytest.mark.parametrize("share", [-0.5, 0.0, 0.2, 0.5, 0.79, 1.5])
def test_a_back_is_drawn_up_by_the_share_of_what_that_raises_the_head(share: float) -> None:
    body = bent(40.0)
    # from the lowest joint of the back to the head: 0.55 m up, 0.02 m forward
    angle = np.radians(40.0)
    raised = 0.55 - (0.55 * np.cos(angle) - 0.02 * np.sin(angle))
    chain = _Chain(body)
    chain.straighten(np.array([share * raised]))
    wanted = 40.0 * (1.0 - np.clip(share, 0.0, 0.8))
    np.testing.assert_allclose(pitch(chain.rotations[0, 1:-1]), wanted, atol=1e-6)
    np.testing.assert_allclose(pitch(chain.rotations[0, [0, -1]]), [0.0, 40.0], atol=1e-6)


def test_a_head_that_jumps_up_draws_the_back_up_within_some_tenths_of_a_second(world) -> None:
    body = bent(40.0, 240)
    places, turns = world(body, "head")
    places[120:, 2] += 0.1
    placed, _ = place_head(body, places, turns, all_valid(body))
    angle = pitch(world(placed, "spine1")[1])
    assert angle[20] - angle[-20] > 15.0
    assert np.abs(np.diff(angle)).max() < 0.15 * (angle[20] - angle[-20])


def test_a_turn_is_shared_by_chest_neck_and_head(world, degrees_between) -> None:
    body = standing(30)
    places, _ = world(body, "head")
    look = np.tile(wxyz(Rotation.from_euler("z", 70, degrees=True)), (30, 1))
    placed, _ = place_head(body, places, look, all_valid(body))
    shares = {"hips": 0.0, "spine1": 0.045, "spine2": 0.09, "spine3": 0.135, "chest": 0.18, "neck": 0.59}
    for role, share in {**shares, "head": 1.0}.items():
        # a head that lies before its neck bends the back by a trifle to stay
        assert degrees_between(world(placed, role)[1], world(body, role)[1]) == pytest.approx(
            70.0 * share, abs=0.5
        )


def test_half_of_a_stoop_is_in_the_hips_the_rest_along_the_back() -> None:
    body = standing(1)
    body.rotations[:, 0] = wxyz(Rotation.from_euler("z", 50, degrees=True))
    chain = _Chain(body)
    chain.stoop(np.radians([48.0]))
    upright = Rotation.from_euler("z", 50, degrees=True)
    turned = Rotation.from_quat(np.roll(chain.rotations[0], -1, axis=-1)) * upright.inv()
    forward = upright.apply([0.0, 1.0, 0.0])
    # by so much each leans to where the body faces: hips, four of the back, neck and head
    for turn, degrees in zip(turned, [24.0, 30.0, 36.0, 42.0, 48.0, 0.0, 0.0], strict=True):
        wanted = np.radians(degrees) * np.cross([0.0, 0.0, 1.0], forward)
        np.testing.assert_allclose(turn.as_rotvec(), wanted, atol=1e-9)


@pytest.mark.parametrize("drop", [0.04, 0.3, 0.6, 0.9, 1.0, 1.3])
def test_a_stoop_follows_the_drop_and_what_room_hips_have(drop: float) -> None:
    body = standing(40)
    # hips at 0.95 m, the head 0.65 m above them; hips not below a quarter of a leg of 0.84 m
    by_drop = 0.9 * max(drop - 0.05, 0.0)
    left = (0.95 + 0.65 - drop - 0.21) / 0.65
    wanted = min(max(by_drop, np.arccos(min(left, 1.0))), np.radians(100.0))
    error = np.tile([0.0, 0.0, -drop], (40, 1))
    np.testing.assert_allclose(
        _stoop(body, _Chain(body), error, 0.25 * body.skeleton.leg_length()), wanted, atol=1e-9
    )


@pytest.mark.parametrize("radius", [0.0005, 0.002, 0.01])
def test_a_head_shakes_by_what_it_moves_quickly_beside_the_motion(radius: float) -> None:
    time = np.arange(600) / 60.0
    circle = radius * np.stack([np.sin(8.0 * np.pi * time), np.cos(8.0 * np.pi * time)], axis=-1)
    # a Gaussian of 0.1 s leaves this share of 4 turns a second; a slow way aside is none of it
    left = np.exp(-0.5 * (8.0 * np.pi * 0.1) ** 2)
    square = (radius * (1.0 - left)) ** 2
    found = _shaking(circle + 0.2 * time[:, None], 60.0)
    np.testing.assert_allclose(found[120:-120], square / (square + 0.002**2), atol=0.01)

"""Bodies that lie or sit on the floor: calm and safe, the head where it is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.body.motion import Motion
from footwork.core.mocap.demo import demo_skeleton
from footwork.core.recording.mounts import DEVICE_MOUNTS
from footwork.core.recording.simulate import simulate_recording
from footwork.core.rig.avatar import AvatarResult, animate
from footwork.core.rig.known import Known
from footwork.core.rig.lying import flat, lying, towards
from footwork.core.settings import BakeSettings
from scipy.spatial.transform import Rotation

SKELETON = demo_skeleton()
STANDING = float(SKELETON.tpose_positions()[SKELETON.joint("head"), 2])
FPS = 60.0


def wxyz(rotation: Rotation) -> np.ndarray:
    return np.roll(rotation.as_quat(), 1, axis=-1)


def scipy_of(rotations: np.ndarray) -> Rotation:
    return Rotation.from_quat(np.roll(rotations, -1, axis=-1))


def still(height: float, turn: Rotation, frames: int = 200) -> tuple[np.ndarray, np.ndarray, float, float]:
    return np.tile([0.3, -0.2, height], (frames, 1)), np.tile(wxyz(turn), (frames, 1)), STANDING, FPS


HEADING = Rotation.from_euler("z", 0.8)


@pytest.mark.parametrize(
    ("height", "turn", "expected"),
    [
        (1.5, Rotation.identity(), 0.0),
        (1.5, Rotation.from_euler("x", 80, degrees=True), 0.0),  # looks at the sky
        (0.4, Rotation.from_euler("x", 10, degrees=True), 0.0),  # crawls and looks ahead
        (0.12, Rotation.from_euler("x", 90, degrees=True), 1.0),  # on the back
        (0.15, Rotation.from_euler("x", -90, degrees=True), 1.0),  # on the belly
        (0.2, Rotation.from_euler("y", 85, degrees=True), 1.0),  # on the side
    ],
)
def test_who_lies(height: float, turn: Rotation, expected: float) -> None:
    np.testing.assert_allclose(lying(*still(height, HEADING * turn)), expected, atol=1e-6)


@pytest.mark.parametrize("axis", ["x", "-x", "y", "-y"])
def test_a_trunk_lies_flat_on_the_side_on_which_its_head_is(axis: str) -> None:
    tipped = Rotation.from_euler(axis[-1], -82 if axis[0] == "-" else 82, degrees=True)
    trunk = scipy_of(flat(*still(0.2, HEADING * tipped))[100])
    whole = Rotation.from_euler(axis[-1], -90 if axis[0] == "-" else 90, degrees=True)
    assert ((HEADING * whole).inv() * trunk).magnitude() < np.radians(5.0)


def test_a_turn_goes_the_same_way_round_past_half_a_turn() -> None:
    angle = np.linspace(2.5, 3.9, 300)
    given, goal = np.tile(wxyz(Rotation.identity()), (300, 1)), wxyz(Rotation.from_euler("z", angle[:, None]))
    found = scipy_of(towards(given, goal, np.full(300, 0.5)))
    np.testing.assert_allclose(found.as_rotvec()[:, 2], 0.5 * angle, atol=1e-9)


def lies_down(turn: str, seconds: float = 3.0) -> tuple[Motion, Known]:
    """A body that goes down stiffly about its heels within some seconds, lies and gets up, and its chest."""
    frames = round((4.0 + 2.0 * seconds) * FPS)
    time = np.arange(frames) / FPS
    down = np.interp(time, [1.0, 1.0 + seconds, 3.0 + seconds, 3.0 + 2.0 * seconds], [0.0, 1.0, 1.0, 0.0])
    down = 0.5 - 0.5 * np.cos(np.pi * down)
    sign = -1.0 if turn[0] == "-" else 1.0
    turns = HEADING * Rotation.from_euler(turn[-1], sign * 0.5 * np.pi * down[:, None])
    hips = SKELETON.offsets[0, 2]
    centre = turns.apply([0.0, 0.0, hips - 0.12]) + np.array([0.0, 0.0, 0.12])
    rotations = np.tile([1.0, 0.0, 0.0, 0.0], (frames, len(SKELETON), 1))
    rotations[:, 0] = wxyz(turns)
    return Motion(SKELETON, FPS, centre, rotations), Known(centre[:, :2], wxyz(turns))


def avatar_of(user: Motion, known: Known | None) -> AvatarResult:
    """What a database of people who stand makes of it."""
    recording = simulate_recording(user, "user", DEVICE_MOUNTS)
    upright = np.zeros(user.rotations.shape)
    upright[..., 0] = 1.0
    upright[:, 0] = wxyz(HEADING)
    places = np.column_stack([user.positions[:, :2], np.full(len(user), SKELETON.offsets[0, 2])])
    matched = replace(user, positions=places, rotations=upright)
    return animate(matched, np.ones((len(user), 2), np.bool_), recording, SKELETON, BakeSettings(), known)


FORWARD_FALL = pytest.param(
    "-x",
    marks=pytest.mark.xfail(
        reason="a knee reaches 13 m/s as the leg folds under a body that falls on its face"
    ),
)


@pytest.mark.parametrize("turn", ["x", FORWARD_FALL, "y"])
def test_who_lies_down_is_calm_and_above_the_floor(turn: str, world) -> None:
    user, known = lies_down(turn)
    found = avatar_of(user, known)
    places = found.motion.forward()[0]
    away = np.linalg.norm(world(found.motion, "head")[0] - world(user, "head")[0], axis=-1)
    assert away.max() < 0.05
    # the user's own stretched arms go into the floor
    arms = ("clavicle", "upper_arm", "forearm", "hand")
    kept = [j for j, role in enumerate(SKELETON.roles) if role.split(".")[0] not in arms and role]
    assert places[:, kept, 2].min() > -0.07
    speeds = np.linalg.norm(np.diff(places, axis=0), axis=-1) * FPS
    assert speeds.max() < 8.0
    middle = len(user) // 2
    assert found.lies[middle] > 0.95 and found.lies[:30].max() < 1e-6
    up = scipy_of(found.motion.rotations[middle, 0]).apply([0.0, 0.0, 1.0])
    np.testing.assert_allclose(up, scipy_of(user.rotations[middle, 0]).apply([0.0, 0.0, 1.0]), atol=0.05)
    assert np.linalg.norm(places[middle] - user.forward()[0][middle], axis=-1).max() < 0.3
    assert not found.contacts[middle].any()


def test_who_stands_is_left_alone(walk: Motion) -> None:
    recording = simulate_recording(walk, "user", DEVICE_MOUNTS)
    contacts = np.zeros((len(walk), 2), np.bool_)
    found = animate(walk, contacts, recording, walk.skeleton, BakeSettings())
    assert not found.lies.any()

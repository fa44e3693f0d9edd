"""The whole last step on real takes: the user's own motion, spoilt, on a body of other proportions."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from footwork.core.body.edit import cut
from footwork.core.body.motion import Motion
from footwork.core.body.skeleton import SIDES
from footwork.core.body.toes import toe_positions
from footwork.core.database.contacts import find_contacts
from footwork.core.mocap.demo import demo_skeleton
from footwork.core.mocap.takes import load_take
from footwork.core.recording.recording import Recording
from footwork.core.recording.simulate import simulate_recording
from footwork.core.recording.targets import joint_targets, scale
from footwork.core.rig.avatar import AvatarResult, animate
from footwork.core.settings import BakeSettings
from scipy.spatial.transform import Rotation

RIG = demo_skeleton(1.62)
TAKES = {"walk": ("lafan1/walk2_subject3_walk2_filtered.bvh", 900), "play": ("fubot_vr/generic_0.bvh", 1200)}


def spoilt(motion: Motion) -> Motion:
    """A match that is off: dragged about the floor, another yaw, arms stretched out, looking straight ahead."""
    time = np.arange(len(motion)) / motion.fps
    drag = np.stack([0.08 * np.sin(0.7 * time), 0.08 * np.cos(0.9 * time), 0.0 * time], axis=-1)
    rotations = motion.rotations.copy()
    for part in ("clavicle", "upper_arm", "forearm", "hand"):
        for side in SIDES:
            rotations[:, motion.skeleton.joint(f"{part}.{side}")] = [1.0, 0, 0, 0]
    rotations[:, motion.skeleton.joint("head")] = [1.0, 0, 0, 0]
    return replace(motion, positions=motion.positions + drag, rotations=rotations)


@pytest.fixture(scope="module", params=list(TAKES))
def case(request: pytest.FixtureRequest, data: Path) -> tuple[AvatarResult, np.ndarray, Motion, Recording]:
    path, frames = TAKES[request.param]
    user = cut(load_take(data / "takes" / path, 60.0).motion, 0, frames)
    contacts = find_contacts(toe_positions(user), user.fps)
    recording = simulate_recording(user, "user")
    standing, ours = (float(body.tpose_positions()[body.joint("head"), 2]) for body in (user.skeleton, RIG))
    factor = ours / standing
    body = user.skeleton
    sized = replace(body, offsets=body.offsets * factor, tips=body.tips * factor)
    matched = spoilt(replace(user, skeleton=sized, positions=user.positions * factor))
    sized_recording = scale(recording, factor)
    return animate(matched, contacts, sized_recording, RIG, BakeSettings()), contacts, user, sized_recording


def test_head_and_hands_are_at_the_trackers(case, world, degrees_between) -> None:
    result, _, _, recording = case
    targets, rotations = joint_targets(recording)
    place, turn = world(result.motion, "head")
    assert np.linalg.norm(place - targets[:, 0], axis=-1).max() < 1e-6
    assert degrees_between(turn, rotations[:, 0]).max() < 1e-4
    for i, side in enumerate(SIDES):
        place, turn = world(result.motion, f"hand.{side}")
        away = np.linalg.norm(place - targets[:, 1 + i], axis=-1)
        assert away[~result.unreachable[:, i]].max() < 1e-3
        assert degrees_between(turn, rotations[:, 1 + i]).max() < 1e-4
    assert result.unreachable.mean() < 0.15


def test_feet_stand_on_the_floor(case) -> None:
    result, contacts, _, _ = case
    toes = toe_positions(result.motion)
    speed = np.linalg.norm(np.diff(toes[..., :2], axis=0), axis=-1) * 60.0
    held = result.contacts[1:] & result.contacts[:-1]
    assert speed[held].mean() < 0.01
    assert toes[..., 2].min() > -1e-3
    assert result.contacts.mean() > 0.85 * contacts.mean()


def test_joints_move_as_smoothly_as_the_user_s(case) -> None:
    result, _, user, _ = case

    def sharpest(motion: Motion, parts: tuple[str, ...]) -> float:
        worst = 0.0
        for part in parts:
            for side in SIDES:
                joint = motion.skeleton.joint(f"{part}.{side}")
                turns = Rotation.from_quat(np.roll(motion.rotations[:, joint], -1, axis=-1))
                speed = (turns[1:] * turns[:-1].inv()).as_rotvec(degrees=True) * motion.fps
                bends = np.linalg.norm(np.diff(speed, axis=0), axis=-1) * motion.fps
                worst = max(worst, float(np.percentile(bends, 99)))
        return worst

    for parts in (("thigh", "shin", "foot"), ("upper_arm", "forearm", "hand")):
        assert sharpest(result.motion, parts) < 2.5 * sharpest(user, parts)


def test_knees_and_elbows_bend_their_own_way(case, world) -> None:
    result, _, _, _ = case
    for side in SIDES:
        hip, knee, ankle = (world(result.motion, f"{part}.{side}")[0] for part in ("thigh", "shin", "foot"))
        forward = Rotation.from_quat(np.roll(world(result.motion, f"shin.{side}")[1], -1, axis=-1)).apply(
            [0, 1, 0]
        )
        line = (ankle - hip) / np.linalg.norm(ankle - hip, axis=-1, keepdims=True)
        bend = knee - hip - np.sum((knee - hip) * line, axis=-1, keepdims=True) * line
        assert np.percentile(np.sum(bend * forward, axis=-1), 1) > -0.01
        upper, lower = (
            Rotation.from_quat(np.roll(world(result.motion, f"{part}.{side}")[1], -1, axis=-1))
            for part in ("upper_arm", "forearm")
        )
        # in T-pose an elbow bends the forearm forward
        along = (upper.inv() * lower).apply([-1.0 if side == "L" else 1.0, 0, 0])
        assert along[:, 1].min() > -1e-6


def test_settings_leave_parts_to_the_match(visit: Motion, world) -> None:
    recording = simulate_recording(visit, "visit")
    contacts = find_contacts(toe_positions(visit), visit.fps)
    off = replace(BakeSettings(), head=False, arms=False, feet="matched")
    result = animate(spoilt(visit), contacts, recording, visit.skeleton, off)
    np.testing.assert_array_equal(result.motion.positions, spoilt(visit).positions)
    np.testing.assert_array_equal(result.contacts, contacts)
    arm = visit.skeleton.joint("forearm.L")
    np.testing.assert_array_equal(result.motion.rotations[:, arm], spoilt(visit).rotations[:, arm])
    assert not result.unreachable.any()

"""Readers of other people's formats: conventions in closed form, and whole real recordings."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from footwork.core.errors import InputError
from footwork.core.maths import quat
from footwork.core.maths.filters import gaussian
from footwork.core.recording.raw import change_axes
from footwork.core.recording.read import read_recording
from footwork.core.recording.reading.answers import Answers
from footwork.core.recording.recording import Recording
from scipy.spatial.transform import Rotation

S = np.sqrt(0.5)
FORWARD, RIGHT = np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0])


def in_head_yaw(recording: Recording) -> np.ndarray:
    """Controllers relative to the headset in its heading: `(T, 2, 3)`, X right, Y ahead."""
    away = recording.positions[:, 1:] - recording.positions[:, :1]
    return quat.rotate(quat.from_yaw(-quat.heading(recording.rotations[:, 0]))[:, None], away)


@pytest.mark.parametrize(
    ("axes", "xyzw", "moved", "expected"),
    [
        # Unity: a turn of +90 degrees about up faces right, about right looks down, about forward lifts the right
        ("RUF", (0.0, S, 0.0, S), FORWARD, (1.0, 0.0, 0.0)),
        ("RUF", (S, 0.0, 0.0, S), FORWARD, (0.0, 0.0, -1.0)),
        ("RUF", (0.0, 0.0, S, S), RIGHT, (0.0, 0.0, 1.0)),
        # WebXR: about up faces left, about right looks up, about backward lifts the right
        ("RUB", (0.0, S, 0.0, S), FORWARD, (-1.0, 0.0, 0.0)),
        ("RUB", (S, 0.0, 0.0, S), FORWARD, (0.0, 0.0, 1.0)),
        ("RUB", (0.0, 0.0, S, S), RIGHT, (0.0, 0.0, 1.0)),
    ],
)
def test_change_of_axes(
    axes: str, xyzw: tuple[float, ...], moved: np.ndarray, expected: tuple[float, ...]
) -> None:
    wxyz = np.array(xyzw)[[3, 0, 1, 2]]
    positions, rotations = change_axes(np.array([1.0, 2.0, 3.0]), wxyz, axes)
    np.testing.assert_allclose(quat.rotate(rotations, moved), expected, atol=1e-12)
    np.testing.assert_allclose(positions, [1.0, 3.0 if axes == "RUF" else -3.0, 2.0])


def aframe(keys: tuple[str, ...] = ("camera", "left", "right"), frames: int = 60) -> dict[str, Any]:
    rng = np.random.default_rng(4)
    tracks: dict[str, Any] = {}
    for k, key in enumerate(keys):
        poses = [
            {
                "position": {"x": 0.3 * k + 0.01 * i, "y": 1.6 - 0.3 * k, "z": -0.2 * k},
                "rotation": dict(zip("xyz", rng.uniform(-40, 40, 3), strict=True)),
                "timestamp": 5000.0 + i * 1000 / 60,
            }
            for i in range(frames)
        ]
        tracks[key] = {"poses": poses, "events": []}
    return tracks


@pytest.mark.parametrize("wrapped", [False, True])
@pytest.mark.parametrize("keys", [("camera", "left", "right"), ("head", "leftHand", "rightHand")])
def test_aframe_poses(tmp_path: Path, keys: tuple[str, ...], wrapped: bool) -> None:
    tracks = aframe(keys)
    content: dict[str, Any] = {"avatar": {}, "recording": tracks} if wrapped else tracks
    (tmp_path / "r.json").write_text(json.dumps(content))
    recording = read_recording(tmp_path / "r.json")
    to_blender = Rotation.from_euler("x", 90, degrees=True)
    for i, key in enumerate(keys):
        for frame in (0, 17, 59):
            pose = tracks[key]["poses"][frame]
            place = [pose["position"][axis] for axis in "xyz"]
            turn = Rotation.from_euler("YXZ", [pose["rotation"][axis] for axis in "yxz"], degrees=True)
            expected = to_blender * turn * to_blender.inv()
            actual = Rotation.from_quat(recording.rotations[frame, i, [1, 2, 3, 0]])
            assert (expected * actual.inv()).magnitude() < 1e-7
            np.testing.assert_allclose(recording.positions[frame, i], to_blender.apply(place), atol=1e-12)
    np.testing.assert_allclose(recording.times, np.arange(60) / 60, atol=1e-9)


@pytest.mark.parametrize("value", ["[" * 100_000, "9" * 10_000 + "}"])
def test_aframe_files_that_no_parser_can_take(tmp_path: Path, value: str) -> None:
    (tmp_path / "r.json").write_text('{"poses": [], "rotation": ' + value)
    with pytest.raises(InputError, match=r"nested too deeply|more than 300 digits"):
        read_recording(tmp_path / "r.json")


def test_aframe_trackers_with_clocks_of_their_own_are_joined(tmp_path: Path) -> None:
    tracks = aframe()
    for i, pose in enumerate(tracks["left"]["poses"]):
        pose["timestamp"] = 5000.0 + 7.0 + i * 1000 / 45
        pose["position"] = {"x": 0.0, "y": 1.0 + 0.5 * (pose["timestamp"] - 5000.0) / 1000.0, "z": 0.0}
    del tracks["left"]["poses"][30:]
    tracks["right"]["poses"] = []
    (tmp_path / "r.json").write_text(json.dumps(tracks))
    recording = read_recording(tmp_path / "r.json")
    last = 0.007 + 29 / 45
    seen = (recording.times >= 0.007) & (recording.times <= last)
    np.testing.assert_allclose(recording.positions[seen, 1, 2], 1.0 + 0.5 * recording.times[seen], atol=1e-9)
    assert recording.valid[seen, 1].all()
    assert not recording.valid[recording.times > last + 0.11, 1].any()
    assert not recording.valid[:, 2].any()
    assert any("right controller never tracked" in doubt for doubt in recording.doubts)
    assert np.isfinite(recording.positions).all()


def fault(change: str) -> str:
    tracks = aframe()
    if change == "cut":
        return json.dumps(tracks, indent=1)[:-4000]
    if change == "no camera":
        del tracks["camera"]
    elif change == "no position":
        del tracks["left"]["poses"][7]["position"]["y"]
    elif change == "text":
        tracks["right"]["poses"][3]["rotation"]["x"] = "steep"
    elif change == "not a list":
        tracks["camera"]["poses"] = 5
    return json.dumps(tracks)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("cut", r"r.json: line \d+: broken JSON"),
        ("no camera", "no poses of the camera"),
        ("no position", "left: pose 7 lacks a number"),
        ("text", "right: pose 3 lacks a number"),
        ("not a list", "camera: poses is not a list"),
    ],
)
def test_aframe_faults(tmp_path: Path, change: str, message: str) -> None:
    (tmp_path / "r.json").write_text(fault(change))
    with pytest.raises(InputError, match=message):
        read_recording(tmp_path / "r.json")


def test_a_real_room_walk(data: Path) -> None:
    recording = read_recording(data / "recordings" / "aframe_room_walk.json")
    assert len(recording) == 2568
    assert recording.times[-1] == pytest.approx(29.24, abs=0.02)
    assert 1.72 < recording.eye_height < 1.80
    worn = (recording.times > 4.0) & (recording.times < 25.0)
    head = recording.positions[worn, 0]
    assert head[:, 2].min() > 1.55 and head[:, 2].max() < 1.85
    steps = np.linalg.norm(np.diff(recording.positions[:, 0, :2], axis=0), axis=-1)
    assert 4.0 < steps.sum() < 6.0
    hands = in_head_yaw(recording)[worn]
    assert (np.median(hands[:, :, 1], axis=0) > 0.15).all()
    assert np.median(hands[:, 0, 0]) < 0.0 < np.median(hands[:, 1, 0])
    # the wearer walks back to the table at the end, looking where they go
    velocity = gaussian(np.gradient(recording.positions[:, 0, :2], recording.times, axis=0), 20.0)
    speed = np.linalg.norm(velocity, axis=-1)
    walking = (recording.times > 22.0) & (recording.times < 26.0) & (speed > 0.25)
    facing = quat.rotate(recording.rotations[walking, 0], FORWARD)[:, :2]
    cosine = np.sum(facing * velocity[walking], axis=-1) / np.linalg.norm(facing, axis=-1) / speed[walking]
    assert np.median(cosine) > 0.85
    assert any("headset lies still" in doubt for doubt in recording.doubts)
    assert "jitter" in recording.found["repaired"]


def test_a_real_scripted_recording_follows_its_script(data: Path) -> None:
    """Step back, forward, left, right, crouch, tip-toe; look down, up, left, right; tilt left, right."""
    recording = read_recording(data / "recordings" / "questset_scripted_moves.csv", Answers(eye_height=1.7))

    def at(second: float) -> int:
        return int(np.searchsorted(recording.times, second))

    moved = recording.positions[:, 0] - recording.positions[0, 0]
    assert moved[at(10), 1] < -0.3 and moved[at(16), 1] > 0.4
    assert moved[at(28), 0] < -0.4 and moved[at(36), 0] > 0.4
    assert moved[at(50), 2] < -0.4
    assert np.ptp(moved[at(2) : at(46), 2]) < 0.1
    turns = quat.to_matrix(recording.rotations[:, 0])
    assert turns[at(64), 2, 1] < -0.7 and turns[at(78), 2, 1] > 0.7
    yaws = np.degrees(quat.heading(recording.rotations[:, 0]))
    assert yaws[at(88)] > 50 and yaws[at(98)] < -50
    # a head tilted to the left lifts its right side
    assert turns[at(107), 2, 0] > 0.7 and turns[at(118), 2, 0] < -0.7
    assert recording.positions[at(4), 0, 2] == pytest.approx(1.7, abs=0.03)
    assert not recording.valid[:, 1].any(), "the left controller slept"
    assert 0.7 < (~recording.valid[:, 2]).mean() < 0.8
    assert recording.mounts.offsets[0, 2] > 0.0


def test_a_scripted_recording_without_eye_height_is_doubted(data: Path) -> None:
    recording = read_recording(data / "recordings" / "questset_scripted_moves.csv")
    assert recording.eye_height == 1.65
    assert any("relative to the start" in doubt for doubt in recording.doubts)


def test_a_real_beat_saber_replay(data: Path) -> None:
    recording = read_recording(data / "recordings" / "beatsaber_quest2.bsor")
    assert len(recording) == 26554, "two samples have repeated times"
    assert recording.times[-1] == pytest.approx(295.2, abs=0.1)
    assert recording.fps == pytest.approx(90.0, abs=0.5)
    assert recording.found["device"] == "Oculus Quest 2, Oculus Touch"
    hands = in_head_yaw(recording)
    assert (np.median(hands[:, :, 1], axis=0) > 0.05).all()
    assert np.median(hands[:, 0, 0]) < -0.2 and np.median(hands[:, 1, 0]) > 0.2
    assert (np.median(hands[:, :, 2], axis=0) < -0.3).all()
    assert np.isfinite(recording.positions).all()


def test_a_real_recording_in_centimetres(data: Path) -> None:
    recording = read_recording(data / "recordings" / "alyx_test.csv")
    # 1.63 m as worn, looking down by some 30 degrees
    assert 1.63 < recording.eye_height < 1.72
    np.testing.assert_allclose(np.linalg.norm(recording.rotations, axis=-1), 1.0, atol=1e-12)
    assert (np.median(in_head_yaw(recording)[:, :, 1], axis=0) > 0.1).all(), "hands are in front"


def replay(frames: int = 30) -> bytes:
    texts = [b"v", b"g", b"1", b"id", b"\xff\xfe", b"oculus", b"t", b"Some HMD", b"c", b"h", b"s", b"m", b"d"]
    out = struct.pack("<IBB", 0x442D3D69, 1, 0)
    out += b"".join(struct.pack("<i", len(text)) + text for text in texts) + struct.pack("<i", 9)
    out += b"".join(struct.pack("<i", 2) + b"ab" for _ in range(3)) + struct.pack("<fBffff", 0, 0, 0, 0, 0, 0)
    out += struct.pack("<Bi", 1, frames)
    for i in range(frames):
        out += struct.pack("<fi", i / 90, 90)
        for k in range(3):
            out += struct.pack("<7f", 0.1 * k, 1.7, 0.01 * i, 0.0, S, 0.0, S)
    return out


def test_beat_saber_axes(tmp_path: Path) -> None:
    (tmp_path / "r.bsor").write_bytes(replay() + b"\x02rest")
    recording = read_recording(tmp_path / "r.bsor")
    np.testing.assert_allclose(recording.positions[20, 2], [0.2, 0.2, 1.7], atol=1e-6)
    # turned by +90 degrees about Unity's up: facing right
    np.testing.assert_allclose(quat.rotate(recording.rotations[5, 0], FORWARD), [1, 0, 0], atol=1e-6)


@pytest.mark.parametrize("content", [replay()[:200], replay()[:100], replay()[:5], b"i=-D\x01\x07"])
def test_broken_replays(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "r.bsor").write_bytes(content)
    with pytest.raises(InputError, match="garbled"):
        read_recording(tmp_path / "r.bsor")


def test_newer_replays(tmp_path: Path) -> None:
    (tmp_path / "r.bsor").write_bytes(b"i=-D\x02" + replay()[5:])
    with pytest.raises(InputError, match="version 2"):
        read_recording(tmp_path / "r.bsor")


def test_unity_recorder_tables(tmp_path: Path) -> None:
    names = ["timestamp_ms", "frame"]
    for device in ("hmd", "left", "right"):
        names += [f"{device}_pos_{axis}" for axis in "xyz"] + [f"{device}_rot_{axis}" for axis in "xyzw"]
    pose = f"0.1,1.6,0.3,0,{S},0,{S}"
    rows = [f"{7000 + 20 * i},{i},{pose},{pose},{pose}" for i in range(20)]
    (tmp_path / "u.csv").write_text("\n".join([",".join(names), *rows]))
    recording = read_recording(tmp_path / "u.csv")
    np.testing.assert_allclose(recording.times, 0.02 * np.arange(20), atol=1e-9)
    np.testing.assert_allclose(recording.positions[3, 1], [0.1, 0.3, 1.6])
    np.testing.assert_allclose(quat.rotate(recording.rotations[3, 1], FORWARD), RIGHT, atol=1e-12)
    (tmp_path / "u.csv").write_text("\n".join([",".join(names), *rows[:5], "9000,6,what" + ",0" * 20]))
    with pytest.raises(InputError, match="line 7: 'what' is not a number"):
        read_recording(tmp_path / "u.csv")


@pytest.mark.parametrize("content", [b"a,b,c\n1,2,3\n", b"HIERARCHY\nROOT Hips\n", bytes(range(256)) * 40])
def test_unknown_formats_say_what_is_missing(
    tmp_path: Path, content: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("x.dat").write_bytes(content)
    with pytest.raises(
        InputError, match=r"^x\.dat: .*no position and rotation of a headset.*name them head, left"
    ):
        read_recording("x.dat")


def test_empty_and_missing_files(tmp_path: Path) -> None:
    (tmp_path / "empty.csv").write_bytes(b"\n")
    with pytest.raises(InputError, match="empty"):
        read_recording(tmp_path / "empty.csv")
    with pytest.raises(InputError, match="cannot be read"):
        read_recording(tmp_path / "none.csv")


@pytest.mark.parametrize("height", [0.0, -1.0, 170.0, float("nan")])
def test_eye_heights_that_are_no_metres(tmp_path: Path, height: float) -> None:
    with pytest.raises(InputError, match="eye height"):
        read_recording(tmp_path / "none.csv", Answers(eye_height=height))

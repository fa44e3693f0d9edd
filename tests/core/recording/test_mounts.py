"""How devices sit: named by files, said by people, fitted where the movement tells."""

from __future__ import annotations

import numpy as np
import pytest
from footwork.core.errors import InputError
from footwork.core.maths import quat
from footwork.core.recording.fitting import fitted
from footwork.core.recording.mounts import DEVICE_MOUNTS, SHAPES, shape_in, shape_of
from footwork.core.recording.raw import RawRecording, Track
from footwork.core.recording.read import to_recording
from footwork.core.recording.reading.answers import Answers


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("Oculus Quest 2, Oculus Touch", "quest-touch"),
        ("Vive Pro 2, Knuckles", "index"),
        ("Vive MV, vive_controller", "vive-wands"),
        ("windows-mixed-reality", "wmr"),
        ("bytedance-pico-4", "pico"),
        ("generic-hand", "hands"),
        ("oculus-touch-v3", "quest-touch"),
        ("htc-vive", "vive-wands"),
        ("a toaster", ""),
        ("", ""),
    ],
)
def test_devices_are_known_by_what_files_call_them(text, name) -> None:
    assert shape_in(text) == name


def turning(reach: float, pitch: float) -> RawRecording:
    """Someone who stands and turns head and forearms: controllers about elbows that go with the head."""
    times = np.arange(900) / 60.0
    turn = [
        quat.from_euler(
            np.stack([0.5 * np.sin(a * times + i), 0.4 * np.sin(b * times), 0.6 * np.sin(c * times)], -1),
            "ZXY",
        )
        for i, (a, b, c) in enumerate(((1.3, 2.1, 0.7), (1.9, 1.1, 1.6), (1.2, 2.3, 0.9)))
    ]
    arm = quat.rotate(quat.from_axis("X", -np.radians(pitch)), np.array([0.0, 0.26 + reach, 0.0]))
    head = np.array([0.0, 0.0, 1.5]) + quat.rotate(turn[0], np.broadcast_to([0.0, 0.05, 0.12], (900, 3)))
    elbows = [head + np.array([side, 0.1, -0.5]) for side in (-0.2, 0.2)]
    places = [
        head,
        *(
            elbow + quat.rotate(q, np.broadcast_to(arm, (900, 3)))
            for elbow, q in zip(elbows, turn[1:], strict=True)
        ),
    ]
    tracks = [Track(times, place, q, np.ones(900, np.bool_)) for place, q in zip(places, turn, strict=True)]
    return RawRecording((tracks[0], tracks[1], tracks[2]), {"format": "made"})


def test_mounts_are_fitted_where_turns_tell_them() -> None:
    shape, told = fitted(turning(0.06, 25.0))
    assert told == "headset and controllers"
    assert (shape.ahead, shape.above) == pytest.approx((0.05, 0.12), abs=0.01)
    assert shape.reach == pytest.approx(0.06, abs=0.015)
    assert shape.pitch == pytest.approx(25.0, abs=2.0)


def test_a_headset_that_never_moves_is_told_as_that() -> None:
    raw = turning(0.06, 25.0)
    still = Track(raw.tracks[0].times, np.full((900, 3), 1.5), raw.tracks[0].rotations, raw.tracks[0].valid)
    lying = RawRecording((still, *raw.tracks[1:]), {"format": "made"}, stated=frozenset())
    with pytest.raises(InputError, match="stays at one point all"):
        to_recording(lying, "f", "")
    with pytest.raises(InputError, match="while others move"):
        to_recording(lying, "f", "", Answers(force=True))
    alone = RawRecording((still, still, still), {"format": "made"})
    assert "stays at one point" in to_recording(alone, "f", "", Answers(force=True)).doubts[0]


def test_who_walks_tells_nothing_of_mounts() -> None:
    raw = turning(0.06, 25.0)
    sway = np.random.default_rng(5).normal(size=(900, 3)).cumsum(axis=0) * 0.01
    tracks = [
        Track(t.times, t.positions + sway * (i + 1), t.rotations, t.valid) for i, t in enumerate(raw.tracks)
    ]
    _, told = fitted(RawRecording((tracks[0], tracks[1], tracks[2]), {}))
    assert told == ""


def test_what_is_said_goes_before_what_the_file_names() -> None:
    raw = turning(0.06, 25.0)
    named = RawRecording(raw.tracks, {"format": "made", "device": "Vive Pro, Knuckles"})
    read = to_recording(named, "f", "")
    assert read.found["mounts"].startswith("Index controllers, named in the file: headset 0.09 m ahead")
    np.testing.assert_allclose(read.mounts.offsets, SHAPES["index"].mounts.offsets)
    read = to_recording(named, "f", "", Answers(mounts="0.05,0.1,0.02,30"))
    np.testing.assert_allclose(read.mounts.offsets, [[0.0, 0.05, 0.1], [-0.02, 0.0, 0.0], [0.02, 0.0, 0.0]])
    assert "fitted to the movement" in to_recording(named, "f", "", Answers(mounts="fitted")).found["mounts"]
    assert to_recording(raw, "f", "").mounts is DEVICE_MOUNTS


@pytest.mark.parametrize("text", ["sledge", "1,2", "0.1,0.1,0.1,400", "a,b,c,d", "nan,0,0,0"])
def test_mounts_that_are_none(text) -> None:
    with pytest.raises(InputError, match=r"--mounts"):
        Answers(mounts=text).check()
    with pytest.raises(ValueError, match=r"give one of|is not from"):
        shape_of(text)

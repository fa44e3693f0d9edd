"""Small files that ask for much, and bodies that cannot be, are refused before memory is taken."""

from __future__ import annotations

import json
import tracemalloc
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from footwork.core.errors import InputError
from footwork.core.mocap.bvh import format_bvh, read_bvh
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.export import to_bvh
from footwork.core.mocap.takes import load_take
from footwork.core.recording.csv_format import write_csv
from footwork.core.recording.read import read_recording
from footwork.core.recording.reading.answers import Answers
from footwork.core.recording.simulate import simulate_recording

GROWTH = 60 << 20
"""Bytes that a refusal may cost."""


def refused(read: Callable[[], Any]) -> str:
    tracemalloc.start()
    try:
        with pytest.raises(InputError) as caught:
            read()
        assert tracemalloc.get_traced_memory()[1] < GROWTH
    finally:
        tracemalloc.stop()
    text = str(caught.value)
    assert text.isprintable() and len(text) <= 300
    return text


@pytest.fixture(scope="module")
def text() -> str:
    motion = demo_motion("walk")
    return format_bvh(
        to_bvh(replace(motion, positions=motion.positions[:20], rotations=motion.rotations[:20]), "w")
    )


def chain(joints: int) -> str:
    """A hierarchy in which every joint hangs on the one before."""
    lines = ["HIERARCHY"]
    for joint in range(joints):
        lines += [f"{'JOINT' if joint else 'ROOT'} j{joint}", "{", "OFFSET 0 1 0", "CHANNELS 1 Xrotation"]
    return "\n".join([*lines, *"}" * joints, "MOTION", "Frames: 1", "Frame Time: 0.02", "0 " * joints])


def flat(joints: int) -> str:
    inner = "JOINT a { OFFSET 0 1 0 CHANNELS 1 Xrotation }\n".replace(" {", "\n{").replace(" CH", "\nCH")
    return f"HIERARCHY\nROOT r\n{{\n{inner * joints}}}\nMOTION\nFrames: 1\nFrame Time: 1\n{'0 ' * joints}"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda t: chain(20_000), "256 joints hang on one another"),
        (lambda t: flat(5000), "more than 4096 joints"),
        (lambda t: t.replace("Frames: 20", "Frames: 99999999").replace("CHANNELS 3", "#"), "line"),
        (lambda t: t.split("MOTION")[0].replace("CHANNELS 3", "CHANNELS 0 #"), "line"),
        (lambda t: t.replace("CHANNELS 3", "CHANNELS " + "9" * 5000), "0 of 999999 channels"),
        *((lambda t, s=s: with_time(t, s), "no time between two frames") for s in ("1e-310", "1000", "1e-7")),
        (lambda t: with_time(t, "10").replace("Frames: 20", "Frames: 99999999"), "after 20 of 99999999"),
    ],
)
def test_takes(text: str, tmp_path: Path, change: Callable[[str], str], words: str) -> None:
    (tmp_path / "a.bvh").write_text(change(text))
    assert words in refused(lambda: load_take(tmp_path / "a.bvh", 60.0))


def with_time(text: str, value: str) -> str:
    head, _, rest = text.partition("Frame Time: ")
    return f"{head}Frame Time: {value}\n{rest.partition(chr(10))[2]}"


def test_frames_without_channels(text: str, tmp_path: Path) -> None:
    lines = [line for line in text.split("MOTION")[0].splitlines() if "CHANNELS" not in line]
    (tmp_path / "a.bvh").write_text("\n".join([*lines, "MOTION", "Frames: 99999999", "Frame Time: 0.01", ""]))
    assert "99999999 frames of" in refused(lambda: read_bvh(tmp_path / "a.bvh"))


def test_few_frames_at_a_very_low_rate(text: str, tmp_path: Path) -> None:
    rows = text.splitlines()[-1:] * 400
    slow = with_time(text, "9").replace("Frames: 20", "Frames: 420") + "\n".join(rows) + "\n"
    (tmp_path / "a.bvh").write_text(slow)
    assert "too few" in refused(lambda: load_take(tmp_path / "a.bvh", 60.0))


def test_a_bone_as_long_as_the_body(tmp_path: Path) -> None:
    motion = demo_motion("walk")
    offsets = motion.skeleton.offsets.copy()
    offsets[motion.skeleton.joint("toe.L")] *= 20.0
    long = replace(motion, skeleton=replace(motion.skeleton, offsets=offsets))
    (tmp_path / "a.bvh").write_text(format_bvh(to_bvh(long, "long")))
    assert "bone that ends at" in refused(lambda: load_take(tmp_path / "a.bvh"))


def recording(
    path: Path, shift: float = 0.0, stretch: Callable[[np.ndarray], np.ndarray] | None = None
) -> Path:
    made = simulate_recording(demo_motion("walk"), "walk")
    made = replace(made, positions=made.positions + np.array([0.0, 0.0, shift]))
    if stretch is not None:
        made = replace(made, times=stretch(made.times))
    write_csv(path, made)
    return path


@pytest.mark.parametrize("shift", [-3.0, -1.4, 8.0])
def test_eye_heights_that_are_measured(tmp_path: Path, shift: float) -> None:
    path = recording(tmp_path / "a.csv", shift)
    path.write_text("".join(line for line in path.open() if not line.startswith("# eye_height")))
    assert "person" in refused(lambda: read_recording(path))
    assert read_recording(path, Answers(eye_height=1.6)).eye_height == 1.6


@pytest.mark.parametrize("height", [0.05, 0.0, -1.0, 10.0])
def test_eye_heights_that_are_given_or_stated(tmp_path: Path, height: float) -> None:
    path = recording(tmp_path / "a.csv")
    assert "no person's" in refused(lambda: read_recording(path, Answers(eye_height=height)))
    lines = [f"# eye_height: {height}\n" if "eye_height" in line else line for line in path.open()]
    path.write_text("".join(lines))
    assert "no person's" in refused(lambda: read_recording(path))


def test_many_long_pauses(tmp_path: Path) -> None:
    path = recording(tmp_path / "a.csv", stretch=lambda t: t + 590.0 * np.floor(np.arange(len(t)) / 10))
    assert "pauses of" in refused(lambda: read_recording(path))


@pytest.mark.parametrize(("pause", "words"), [(590.0, "pauses of"), (1e300, "samples per second")])
def test_many_long_pauses_of_an_aframe_recording(tmp_path: Path, pause: float, words: str) -> None:
    def poses(name: str) -> dict[str, Any]:
        return {
            "poses": [
                {
                    "timestamp": 1000.0 * (i / 90.0 + pause * (i // 10)),
                    "position": {"x": 0.01 * i, "y": 1.6, "z": 0.0},
                    "rotation": {"x": 1.0, "y": 0.0, "z": 0.0},
                }
                for i in range(200)
            ]
        }

    (tmp_path / "a.json").write_text(json.dumps({n: poses(n) for n in ("camera", "left", "right")}))
    assert words in refused(lambda: read_recording(tmp_path / "a.json"))


def test_one_pause_of_nine_minutes_is_bridged(tmp_path: Path) -> None:
    path = recording(tmp_path / "a.csv", stretch=lambda t: t + 540.0 * (np.arange(len(t)) > 100))
    assert "1 pause of 540" in read_recording(path).found["repaired"]


def test_a_version_of_very_many_digits(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("# footwork-recording " + "9" * 5000 + "\n")
    assert "newer than" in refused(lambda: read_recording(tmp_path / "a.csv"))

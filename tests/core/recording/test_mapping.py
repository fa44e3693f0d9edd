"""The mapping assistant: columns, corrections, and what is kept of them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from footwork.cli import main
from footwork.core.errors import InputError
from footwork.core.mocap.demo import demo_motion
from footwork.core.recording.mapping import look, poses_in_words
from footwork.core.recording.mounts import DEVICE_MOUNTS
from footwork.core.recording.read import read_recording
from footwork.core.recording.reading.answers import Answers
from footwork.core.recording.reading.kept import check_said, keep_map, map_for, maps
from footwork.core.recording.recording import TRACKERS, Recording
from footwork.core.recording.simulate import simulate_recording

PARTS = ("px", "py", "pz", "qw", "qx", "qy", "qz")
SAID = {f"u{i}": text for i, text in enumerate(["time", *(f"{t}.{p}" for t in TRACKERS for p in PARTS)])}


@pytest.fixture(autouse=True)
def own(tmp_path, monkeypatch) -> Path:
    """A folder of presets for each test."""
    folder = tmp_path / "own"
    folder.mkdir()
    monkeypatch.setenv("FOOTWORK_PRESETS", str(folder))
    return folder


@pytest.fixture(scope="module")
def walk() -> Recording:
    """Someone who walks and turns."""
    return simulate_recording(demo_motion("turn", 3), "turn", DEVICE_MOUNTS)


def rows_of(walk: Recording) -> np.ndarray:
    """`(T, 22)` seconds and three poses in Blender's axes."""
    poses = np.concatenate([walk.positions, walk.rotations], axis=-1)
    return np.c_[walk.times, poses.reshape(len(walk), -1)]


def check_same(found: Recording, walk: Recording) -> None:
    """Where it was tracked: the demo's hands do not tremble at its start."""
    assert found.valid.mean() > 0.9
    np.testing.assert_allclose(found.positions[found.valid], walk.positions[found.valid], atol=1e-4)


@pytest.fixture
def nameless(walk, tmp_path) -> Path:
    """A table of names that say nothing, with one more column of text."""
    lines = ["note," + ",".join(SAID)]
    lines += ["a," + ",".join(f"{value:.7f}" for value in row) for row in rows_of(walk)]
    path = tmp_path / "nameless.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


def test_a_table_of_unknown_names_is_shown_corrected_and_kept(nameless, walk, own, capsys) -> None:
    with pytest.raises(InputError, match="no known recording format"):
        read_recording(nameless)
    shown = look(nameless, {})
    assert shown.recording is None
    assert "headset" in shown.fault
    assert [column.said for column in shown.columns] == ["nothing"] * 23
    flags = [flag for column, text in SAID.items() for flag in ("--set", f"{column}={text}")]
    assert main(["map", str(nameless), *flags]) == 0
    assert not list(own.iterdir())
    assert main(["map", str(nameless), *flags, "--axes", "RFU", "--keep", "Studio B"]) == 0
    said = capsys.readouterr().out
    assert "head.px  (you say so)" in said
    assert "goes " in said
    assert len(list(own.rglob("*.json"))) == 1
    found = read_recording(nameless)
    check_same(found, walk)
    assert found.found["columns"] == "as kept under 'Studio B'"
    assert {column.by for column in look(nameless, {}).columns} == {"", "kept"}


def test_other_columns_are_not_read_with_what_is_kept(nameless, tmp_path) -> None:
    keep_map(look(nameless, SAID).to_keep("own", SAID, Answers()))
    other = tmp_path / "other.csv"
    other.write_text(nameless.read_text().replace("note,", "text,"))
    assert map_for(("note", *SAID)) is not None
    with pytest.raises(InputError, match="no known recording format"):
        read_recording(other)


def test_what_a_person_says_of_a_known_table_counts(walk, tmp_path) -> None:
    path = tmp_path / "crossed.csv"
    header = ["time", *(f"{t}_{p}" for t in ("head", "right", "left") for p in PARTS)]
    np.savetxt(path, rows_of(walk), delimiter=",", header=",".join(header), comments="", fmt="%.7f")
    crossed = {f"{a}_{p}": f"{b}.{p}" for a, b in (("left", "right"), ("right", "left")) for p in PARTS}
    found = look(path, crossed, Answers(axes="RFU"))
    assert found.recording is not None
    assert not any("swapped" in doubt for doubt in found.recording.doubts)
    check_same(found.recording, walk)
    assert any("swapped" in doubt for doubt in read_recording(path, Answers(axes="RFU")).doubts)


def test_rows_of_devices_with_names_that_say_nothing(walk, tmp_path) -> None:
    values = rows_of(walk)
    lines = ["t_s,device,px,py,pz,qw,qx,qy,qz"]
    for row in values:
        for place, name in enumerate(("D1", "D2", "D3")):
            pose = ",".join(f"{value:.7f}" for value in row[1 + 7 * place : 8 + 7 * place])
            lines.append(f"{row[0]:.6f},{name},{pose}")
    path = tmp_path / "long.csv"
    path.write_text("\n".join(lines) + "\n")
    assert look(path, {}).recording is None
    said = {"D1": "head", "D2": "left", "D3": "right"}
    found = look(path, said, Answers(axes="RFU"))
    assert found.recording is not None
    check_same(found.recording, walk)


def test_json_and_a_rate_and_swapped_hands_are_kept(walk, tmp_path) -> None:
    path = tmp_path / "frames.json"
    swapped = rows_of(walk)[:, [*range(8), *range(15, 22), *range(8, 15)]]
    frames = [dict(zip([*SAID][1:], map(float, row[1:]), strict=True)) for row in swapped]
    path.write_text(json.dumps({"frames": frames}))
    said = {name: text for name, text in SAID.items() if name != "u0"}
    answers = Answers(axes="RFU", rate=walk.fps, swap_hands=True)
    keep_map(look(path, said, answers).to_keep("frames", said, answers))
    found = read_recording(path)
    check_same(found, walk)
    assert found.fps == pytest.approx(walk.fps)


def test_a_table_without_names_has_numbered_columns(walk, tmp_path) -> None:
    path = tmp_path / "bare.csv"
    np.savetxt(path, np.c_[rows_of(walk), np.zeros(len(walk))], delimiter=",", fmt="%.7f")
    shown = look(path, {})
    assert [column.name for column in shown.columns[:2]] == ["column 1", "column 2"]
    said = {f"column {place}": text for place, text in enumerate(SAID.values(), 1)}
    assert look(path, said, Answers(axes="RFU")).recording is not None


def test_layouts_tell_what_their_columns_are(tmp_path, walk) -> None:
    path = tmp_path / "unity.csv"
    names = [
        f"{t}_{p}"
        for t in ("hmd", "left", "right")
        for p in (*(f"pos_{a}" for a in "xyz"), *(f"rot_{a}" for a in "wxyz"))
    ]
    header = ",".join(["timestamp_ms", *names])
    np.savetxt(
        path, rows_of(walk) * ([1000.0] + [1.0] * 21), delimiter=",", header=header, comments="", fmt="%.7f"
    )
    shown = look(path, {})
    assert [column.said for column in shown.columns[:3]] == ["time", "head.px", "head.py"]


@pytest.mark.parametrize(
    ("flags", "line"),
    [
        (["--set", "u1"], "give COLUMN=MEANING"),
        (["--set", "u1=head.foo"], "none of time"),
        (["--set", "v9=time"], "no column or device is called 'v9'"),
        (["--set", "u0=time"], "or say what columns are"),
    ],
)
def test_faults_of_what_is_said_get_one_line(nameless, capsys, flags, line, own) -> None:
    assert main(["map", str(nameless), *flags, "--keep", "x"]) == 2
    told = capsys.readouterr().err
    assert line in told
    assert len(told.splitlines()) == 1
    assert not list(own.iterdir())


def test_broken_maps_are_skipped_and_named(nameless, own) -> None:
    keep_map(look(nameless, SAID).to_keep("good", SAID, Answers()))
    for place, change in enumerate(
        ({"said": 3}, {"said": {"u1": "head.foo"}}, {"rate": "x"}, {"swap_hands": 1}, {"axes": "RR"})
    ):
        text = json.loads((own / "recording_maps" / "good.json").read_text())
        (own / "recording_maps" / f"bad{place}.json").write_text(
            json.dumps({**text, "name": str(place), **change})
        )
    assert [entry.name for entry in maps().entries] == ["good"]
    assert len(maps().skipped) == 5


def test_words_and_poses() -> None:
    assert check_said(" head.px ") == "head.px"
    assert check_said("left foot.qw") == "left foot.qw"
    for text in ("head.", ".px", "px.head.zz", "Zeit!"):
        with pytest.raises(ValueError, match="none of"):
            check_said(text)


def test_poses_are_told_in_words(walk) -> None:
    told = poses_in_words(walk)
    assert "upright by 0.9" in told["head"] or "upright by 1.0" in told["head"]
    assert "left" in told["left"]
    assert "below" in told["left"]


def test_other_trackers_without_rotation_or_with_another_kind_are_kept(walk, tmp_path, capsys) -> None:
    rows = rows_of(walk)
    names = ["time", *(f"{t}_{p}" for t in TRACKERS for p in PARTS)]
    names += (
        [f"waist_p{a}" for a in "xyz"]
        + [f"left_foot_p{a}" for a in "xyz"]
        + [f"left_foot_r{a}" for a in "xyz"]
    )
    waist = walk.positions[:, 0] - (0.0, 0.0, 0.7)
    foot = np.c_[waist * (1.0, 1.0, 0.1), np.tile([0.0, 0.0, 90.0], (len(walk), 1))]
    path = tmp_path / "five.csv"
    table = np.c_[rows, waist, foot]
    np.savetxt(path, table, delimiter=",", header=",".join(names), comments="", fmt="%.7f")
    found = read_recording(path, Answers(axes="RFU"))
    assert [item.name for item in found.extra] == ["waist", "left foot"]
    np.testing.assert_allclose(found.extra[0].positions, waist, atol=1e-4)
    np.testing.assert_allclose(found.extra[0].rotations, np.tile([1.0, 0.0, 0.0, 0.0], (len(walk), 1)))
    half = np.sqrt(0.5)
    np.testing.assert_allclose(np.abs(found.extra[1].rotations[5]), [half, 0.0, 0.0, half], atol=1e-6)
    assert main(["inspect", str(path), "--axes", "RFU", "--json", "-"]) == 0
    shown = json.loads(capsys.readouterr().out)["files"][0]["other_trackers"]
    assert [item["name"] for item in shown] == ["waist", "left foot"]
    assert shown[0]["tracked"] == 1.0

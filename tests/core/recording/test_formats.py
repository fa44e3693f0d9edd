"""The registry of recording formats, and table layouts from the user's folder."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from footwork.core.errors import InputError
from footwork.core.maths import quat
from footwork.core.presets import SHIPPED, VARIABLE
from footwork.core.recording import formats, layouts
from footwork.core.recording.raw import RawRecording, Track
from footwork.core.recording.read import read_recording
from footwork.core.recording.reading.answers import Answers
from footwork.core.recording.recording import TRACKERS
from hypothesis import given, settings
from hypothesis import strategies as st

LAYOUT: dict[str, Any] = {
    "name": "Studio table",
    "time": "t",
    "time_unit": "us",
    "unit": "mm",
    "axes": "BLU",
    "on_floor": True,
    **{
        tracker: {
            "position": [f"{tracker}-column-{axis}-of-ours" for axis in "xyz"],
            "rotation": [f"{tracker}-column-{axis}-turned" for axis in "wxyz"],
        }
        for tracker in TRACKERS
    },
}


AS_STATED = Answers(eye_height=1.6, force=True)
"""The tables here are of no person."""


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The user's folder of recording layouts."""
    monkeypatch.setenv(VARIABLE, str(tmp_path / "presets"))
    folder = tmp_path / "presets" / layouts.KIND
    folder.mkdir(parents=True)
    return folder


def table(path: Path, layout: dict[str, Any], frames: int = 20) -> Path:
    """A file in a layout: after 20 i ms all at (100 i, 200, 1500) units, turned by 60 degrees about the third axis."""
    columns = [layout["time"], "note"]
    for tracker in TRACKERS:
        columns += [*layout[tracker]["position"], *layout[tracker]["rotation"]]
    turn = f"{np.sqrt(0.75)},0,0,0.5"
    step = {"us": 20000, "ms": 20}[layout["time_unit"]]
    rows = [f"{7 + step * i},x" + f",{100 * i},200,1500,{turn}" * len(TRACKERS) for i in range(frames)]
    path.write_text("\n".join([",".join(columns), *rows]))
    return path


def read_toy(content: bytes, file: str) -> RawRecording:
    """A toy format: heights of the head in centimetres, at 50 per second."""
    try:
        heights = np.array(content.split()[1:], dtype=float) / 100.0
    except ValueError:
        raise InputError(f"{file}: a height is no number; correct it") from None
    count = len(heights)
    positions = np.stack([0.003 * np.arange(count), np.zeros(count), heights], axis=-1)
    head = Track(
        np.arange(count) / 50.0, positions, np.tile([1.0, 0, 0, 0], (count, 1)), np.ones(count, bool)
    )
    none = Track(np.empty(0), np.empty((0, 3)), np.empty((0, 4)), np.empty(0, bool))
    return RawRecording((head, none, none), {"format": "Toy heights"})


def test_a_format_is_added_by_one_entry(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "heights.anything"
    heights = 160.0 + np.arange(50) % 5
    path.write_text("HEIGHTS " + " ".join(map(str, heights)))
    with pytest.raises(InputError, match="no known recording format"):
        read_recording(path)
    toy = formats.Format(
        "Toy heights", lambda content: content.startswith(b"HEIGHTS "), read_toy, (".heights", ".csv")
    )
    monkeypatch.setattr(formats, "FORMATS", (*formats.FORMATS, toy))
    recording = read_recording(path)
    np.testing.assert_allclose(recording.positions[:, 0, 2], heights / 100.0)
    assert recording.found["format"] == "Toy heights"
    assert not recording.valid[:, 1:].any()
    assert ".heights" in formats.suffixes() and formats.suffixes().count(".csv") == 1
    (tmp_path / "x").write_text("what else")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match="no known recording format"):
        read_recording("x")


def test_file_names_do_not_decide(tmp_path: Path) -> None:
    shipped = json.loads((SHIPPED / layouts.KIND / "who_is_alyx.json").read_text("utf-8"))
    recording = read_recording(table(tmp_path / "table.bsor", shipped), AS_STATED)
    assert recording.found["format"] == shipped["name"]


def test_the_shipped_suffixes() -> None:
    found = formats.suffixes()
    assert {".bsor", ".csv", ".json"} <= set(found) and len(set(found)) == len(found)


def test_every_layout_that_ships_is_sound() -> None:
    files = sorted((SHIPPED / layouts.KIND).glob("*.json"))
    assert len(files) == len(layouts.layouts().entries) >= 3
    assert layouts.layouts().skipped == ()


def test_a_layout_in_the_users_folder_is_read_at_once(tmp_path: Path, own: Path) -> None:
    path = table(tmp_path / "studio.csv", LAYOUT)
    with pytest.raises(InputError, match="no known recording format") as error:
        read_recording(path)
    assert str(own) in str(error.value)
    (own / "studio.json").write_text(json.dumps(LAYOUT))
    recording = read_recording(path, AS_STATED)
    assert recording.found["format"] == "Studio table"
    np.testing.assert_allclose(recording.times, 0.02 * np.arange(20), atol=1e-12)
    np.testing.assert_allclose(recording.positions[6, 1], [-0.2, -0.6, 1.5], atol=1e-12)
    # 60 degrees from x (backward) towards y (left) turn forward to the right: the axes are left-handed
    expected = [np.sqrt(0.75), 0.5, 0.0]
    np.testing.assert_allclose(
        quat.rotate(recording.rotations[3, 0], np.array([0.0, 1, 0])), expected, atol=1e-12
    )
    (own / "studio.json").unlink()
    with pytest.raises(InputError):
        read_recording(path, AS_STATED)


def test_a_layout_of_the_user_takes_the_place_of_one_that_ships(tmp_path: Path, own: Path) -> None:
    shipped = json.loads((SHIPPED / layouts.KIND / "who_is_alyx.json").read_text("utf-8"))
    path = table(tmp_path / "alyx.csv", shipped)
    assert read_recording(path, AS_STATED).positions[0, 0, 1] == pytest.approx(-15.0)
    (own / "mine.json").write_text(json.dumps({**shipped, "unit": "mm"}))
    assert read_recording(path, AS_STATED).positions[0, 0, 1] == pytest.approx(-1.5)
    assert [form.name for form in formats.formats()].count(shipped["name"]) == 1
    # another name comes before those that ship as well
    (own / "mine.json").write_text(json.dumps({**shipped, "name": "Metres", "unit": "m"}))
    assert read_recording(path, AS_STATED).found["format"] == "Metres"


def test_broken_layouts_leave_the_others_and_are_named_where_none_fits(tmp_path: Path, own: Path) -> None:
    (own / "a.json").write_text("[" * 10_000)
    (own / "b.json").write_text(json.dumps({**LAYOUT, "axes": "RUU"}))
    (own / "c.json").write_text(json.dumps(LAYOUT))
    path = table(tmp_path / "studio.csv", LAYOUT)
    recording = read_recording(path, AS_STATED)
    assert not [line for line in (*recording.doubts, *recording.found.values()) if ".json" in line]
    (own / "c.json").unlink()
    with pytest.raises(InputError) as error:
        read_recording(path)
    assert "nested too deeply" in str(error.value) and "and 1 more" in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"axes": "RUU"}, "'axes' 'RUU' is not one each"),
        ({"axes": "RU"}, "'axes'"),
        ({"axes": "RUX"}, "'axes'"),
        ({"axes": ["R", "U", "B"]}, "'axes'"),
        ({"unit": "yard"}, "'unit' 'yard' is none of m, cm, mm"),
        ({"unit": ["m"]}, "'unit'"),
        ({"time_unit": None}, "'time_unit' None is none of s, ms, us, ns"),
        ({"time": ""}, "'time'"),
        ({"time": 0}, "'time'"),
        ({"name": "a\nb"}, "'name'"),
        ({"on_floor": "false"}, "'on_floor' is neither true nor false"),
        ({"left": {"position": ["a"], "rotation": ["b"]}}, "'left': 'position' is not a list of 3 texts"),
        ({"left": {"position": ["a", "b", "c"], "rotation": "wxyz"}}, "'left': 'rotation'"),
        ({"right": {"position": ["a", "b", "c"]}}, "'right' has no 'rotation'"),
        ({"head": None}, "'head' is not an object"),
        ({"left": LAYOUT["head"]}, "'head-column-x-of-ours' is used twice"),
        ({"rate": 90}, "'rate'"),
    ],
)
def test_broken_layouts_say_what_is_wrong(tmp_path: Path, change: dict[str, Any], words: str) -> None:
    path = tmp_path / "bad.json"
    path.write_text(json.dumps({**LAYOUT, **change}))
    with pytest.raises(InputError) as error:
        layouts.read_layout(path)
    assert words in str(error.value) and str(path) in str(error.value)


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(0, 3) | st.floats() | st.sampled_from(["m", "RUB", "t", ""]),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.sampled_from("ab"), inner, max_size=2),
    max_leaves=5,
)


@settings(max_examples=150, deadline=None)
@given(st.dictionaries(st.sampled_from(sorted(LAYOUT)), VALUES, min_size=1, max_size=2))
def test_whatever_a_layout_holds_it_is_one_or_a_fault(
    tmp_path_factory: pytest.TempPathFactory, change: dict[str, Any]
) -> None:
    path = tmp_path_factory.mktemp("layouts") / "any.json"
    path.write_text(json.dumps({**LAYOUT, **change}))
    try:
        layout = layouts.read_layout(path)
    except InputError:
        return
    assert len(layout.columns) == len(set(layout.columns)) == 22
    assert layout.seconds > 0 and layout.metres > 0

"""Tables of numbers and their faults, layouts of tables, axes of files and what a replay's sections hold."""

from __future__ import annotations

import itertools
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from footwork.core.errors import InputError
from footwork.core.recording import bsor, layouts
from footwork.core.recording.aframe import read_aframe
from footwork.core.recording.aframe import recognise as is_aframe
from footwork.core.recording.csv_format import COLUMNS, read_csv
from footwork.core.recording.csv_format import recognise as is_csv
from footwork.core.recording.mounts import DEVICE_MOUNTS
from footwork.core.recording.raw import change_axes
from footwork.core.recording.reading.apply import applied
from footwork.core.recording.recording import TRACKERS
from footwork.core.recording.table import columns_of, decode, read_columns
from scipy.spatial.transform import Rotation


def test_lines_of_any_system_with_or_without_a_mark_at_the_start() -> None:
    for content in (b"a,b\n1,2\n", b"\xef\xbb\xbfa,b\r\n1,2\r\n", b"a,b\n1,2"):
        assert decode(content, "f") == ["a,b", "1,2"]
    assert decode("ü\n".encode(), "f") == ["ü"]


@pytest.mark.parametrize(("content", "line"), [(b"\xff", 1), (b"a\nb\n\xe9", 3), (b"a\n\xe9b\nc\n", 2)])
def test_bytes_that_are_no_text_are_named_by_their_line(content: bytes, line: int) -> None:
    with pytest.raises(InputError, match=f"^f: line {line}: not UTF-8 text; save the table as UTF-8$"):
        decode(content, "f")


def test_names_of_columns_may_be_quoted_and_spaced() -> None:
    assert columns_of(' time, "head x" ,y,') == ["time", "head x", "y", ""]


def test_wanted_columns_of_every_row_with_line_numbers() -> None:
    lines = ["# note", "b,text,a,c", "1,x,2,3", "", "  ", "4.5,y, 5e-1 ,6", "-7,,8,9", ""]
    values, numbers = read_columns(lines, 1, ("a", "b"), "f")
    np.testing.assert_array_equal(values, [[2, 1], [0.5, 4.5], [8, -7]])
    np.testing.assert_array_equal(numbers, [3, 6, 7])


def test_one_row_and_one_column_are_a_table() -> None:
    values, numbers = read_columns(["a", "3"], 0, ("a",), "f")
    assert values.shape == (1, 1) and values[0, 0] == 3.0 and numbers.tolist() == [2]


def test_empty_cells_are_nan_and_signs_in_other_columns_do_no_harm() -> None:
    values, _ = read_columns(["a,b,c", "1, ,#", ",2,'"], 0, ("a", "b"), "f")
    np.testing.assert_array_equal(values, [[1, np.nan], [np.nan, 2]])
    values, _ = read_columns(["a,b", "nan,inf", "-inf,NaN"], 0, ("a", "b"), "f")
    np.testing.assert_array_equal(values, [[np.nan, np.inf], [-np.inf, np.nan]])


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        (["x", "a,b", "1,2"], "line 2: no column 'c'; the table needs a, c"),
        (["x", "c,b", "1,2"], "line 2: no column 'a'; the table needs a, c"),
        (["x", "a,c"], "line 2: the table ends after its header; nothing was recorded"),
        (["x", "a,c", " ", ""], "line 2: the table ends after its header; nothing was recorded"),
        (["x", "a,c", "1,2", "", "3"], "line 5: 1 cells for 2 columns; complete or remove the line"),
        (["x", "a,c", "1,2", "3,4,5"], "line 4: 3 cells for 2 columns; complete or remove the line"),
        (["x", "a,c", "1,2", "", "3, four "], "line 5: 'four' is not a number; correct or remove the line"),
        (["x", "a,c", "1,2", ",4", "1,2;3"], "line 5: '2;3' is not a number; correct or remove the line"),
    ],
)
def test_faults_of_tables(lines: list[str], message: str) -> None:
    with pytest.raises(InputError) as raised:
        read_columns(lines, 1, ("a", "c"), "f")
    assert str(raised.value) == f"f: {message}"


AXES = {"R": (1, 0, 0), "L": (-1, 0, 0), "F": (0, 1, 0), "B": (0, -1, 0), "U": (0, 0, 1), "D": (0, 0, -1)}
EVERY = [
    "".join(letters)
    for pairs in itertools.permutations(("RL", "FB", "UD"))
    for letters in itertools.product(*pairs)
]


@pytest.mark.parametrize("axes", EVERY)
def test_poses_in_any_of_the_48_axes(axes: str) -> None:
    rng = np.random.default_rng(3)
    change = np.array([AXES[letter] for letter in axes], dtype=float).T
    positions, turns = rng.normal(size=(2, 3, 3)), Rotation.random(6, random_state=1)
    given = np.roll(turns.as_quat(), 1, axis=-1).reshape(2, 3, 4)
    places, rotations = change_axes(positions, given, axes)
    np.testing.assert_allclose(places, np.einsum("ij,...j->...i", change, positions), atol=1e-15)
    expected = change @ turns.as_matrix() @ change.T
    found = Rotation.from_quat(np.roll(rotations, -1, axis=-1).reshape(-1, 4)).as_matrix()
    np.testing.assert_allclose(found, expected, atol=1e-12)
    alone = change_axes(positions[0, 0], given[0, 0], axes)
    np.testing.assert_allclose(alone[0], places[0, 0], atol=1e-15)
    np.testing.assert_allclose(alone[1], rotations[0, 0], atol=1e-15)


def layout(**change: Any) -> dict[str, Any]:
    sides = {
        tracker: {
            "position": [f"{tracker} {axis}" for axis in "xyz"],
            "rotation": [f"{tracker} q{axis}" for axis in "wxyz"],
        }
        for tracker in TRACKERS
    }
    return {
        "name": "Studio", "time": "t", "time_unit": "ms", "unit": "cm", "axes": "RFU", "on_floor": False,
        **sides, **change,
    }  # fmt: skip


def parsed(folder: Path, **change: Any) -> layouts.TableLayout:
    path = folder / "layout.json"
    path.write_text(json.dumps(layout(**change)))
    return layouts.read_layout(path)


@pytest.mark.parametrize(("unit", "metres"), [("m", 1.0), ("cm", 0.01), ("mm", 0.001)])
@pytest.mark.parametrize(("time_unit", "seconds"), [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)])
def test_a_layout_says_units_and_columns_in_order(
    tmp_path: Path, unit: str, metres: float, time_unit: str, seconds: float
) -> None:
    found = parsed(tmp_path, unit=unit, time_unit=time_unit)
    assert (found.name, found.axes, found.on_floor) == ("Studio", "RFU", False)
    assert found.metres == metres and found.seconds == seconds
    parts = ("x", "y", "z", "qw", "qx", "qy", "qz")
    assert found.columns == ("t", *(f"{tracker} {part}" for tracker in TRACKERS for part in parts))
    assert parsed(tmp_path, on_floor=True).on_floor is True


@pytest.mark.parametrize("axes", EVERY[::7])
def test_a_table_is_read_as_its_layout_says(tmp_path: Path, axes: str) -> None:
    found = parsed(tmp_path, axes=axes)
    rng = np.random.default_rng(5)
    values = rng.normal(size=(4, 22))
    values[:, 0] = [1000.0, 1016.0, 1033.0, 1050.0]
    rows = [",".join(map(repr, row)) for row in values.tolist()]
    raw = layouts.read_table("\n".join([",".join(found.columns), *rows]).encode(), "f", found)
    raw = applied(raw, raw.reading)
    assert raw.found == {"format": "Studio"} and not raw.on_floor and not raw.states_validity
    assert raw.name == "" and raw.eye_height is None and raw.mounts is DEVICE_MOUNTS
    poses = values[:, 1:].reshape(4, 3, 7)
    for i, track in enumerate(raw.tracks):
        np.testing.assert_allclose(track.times, [0.0, 0.016, 0.033, 0.05], atol=1e-12)
        expected = change_axes(0.01 * poses[:, i, :3], poses[:, i, 3:], axes)
        np.testing.assert_allclose(track.positions, expected[0], atol=1e-15)
        np.testing.assert_allclose(track.rotations, expected[1], atol=1e-15)
        assert track.valid.all() and track.valid.dtype == np.bool_ and track.valid.shape == (4,)


def test_a_table_is_recognised_by_its_header_alone(tmp_path: Path) -> None:
    found = parsed(tmp_path)
    header = ",".join([*reversed(found.columns), "more"]).encode()
    for content in (
        header,
        header + b"\r\n\xff\xff",
        b"\n" + header,
        b"# note\n" + header,
        b"\xef\xbb\xbf" + header + b"\n1,2",
        header.replace(b",", b' ,"'),
    ):
        assert layouts.recognise(content, found)
    for content in (
        b"",
        header.replace(b"left qy", b"left q"),
        b"\xff\xfe" * 9,
    ):
        assert not layouts.recognise(content, found)
    # a header of any length within 16 KiB
    assert layouts.recognise(b"x" * 15_000 + b"," + header, found)
    assert not layouts.recognise(b"x" * 16_384 + b"," + header, found)


HEAD = struct.pack("<IB", 0x442D3D69, 1)


def texts(*given: bytes) -> bytes:
    return b"".join(struct.pack("<i", len(text)) + text for text in given)


def replay(count: int = 2, frames: int = 2, device: bytes = b"Some HMD", section: bytes = b"\x01") -> bytes:
    info = texts(
        b"1.2",
        b"1.29",
        b"0",
        b"id",
        b"A\xffB",
        b"oculus",
        b"t",
        device,
        b"c",
        b"hash",
        b"song",
        b"m",
        b"Hard",
    )
    info += (
        struct.pack("<i", 1234)
        + texts(b"Standard", b"env", b"")
        + struct.pack("<fBffff", 18, 0, 1.7, 0, 0, 1)
    )
    rows = b"".join(
        struct.pack("<fi", 0.5 + i, 90) + struct.pack("<21f", *(100 * i + np.arange(21)))
        for i in range(frames)
    )
    return HEAD + b"\x00" + info + section + struct.pack("<i", count) + rows


def test_a_replay_is_read_to_the_bit() -> None:
    raw = bsor.read_bsor(replay() + b"\x02 more", "f")
    raw = applied(raw, raw.reading)
    assert raw.found == {"format": "Beat Saber replay", "device": "Some HMD, c"}
    assert raw.on_floor and not raw.states_validity and raw.eye_height is None
    for i, track in enumerate(raw.tracks):
        np.testing.assert_array_equal(track.times, [0.5, 1.5])
        pose = 7.0 * i + np.arange(7) + 100.0 * np.arange(2)[:, None]
        # Unity: X right, Y up, Z forward, quaternion x y z w, left-handed
        np.testing.assert_array_equal(track.positions, pose[:, [0, 2, 1]])
        np.testing.assert_array_equal(track.rotations, pose[:, [6, 3, 5, 4]] * [1, -1, -1, -1])
        assert track.times.dtype == track.positions.dtype == track.rotations.dtype == np.float64
        assert track.valid.dtype == np.bool_ and track.valid.tolist() == [True, True]


@pytest.mark.parametrize(("count", "frames"), [(0, 0), (-5, 0), (1, 2), (0, 3)])
def test_a_replay_has_as_many_frames_as_it_says(count: int, frames: int) -> None:
    raw = bsor.read_bsor(replay(count, frames), "f")
    assert [len(track.times) for track in raw.tracks] == [max(count, 0)] * 3


def test_devices_of_replays_may_be_unknown_or_misspelt() -> None:
    assert bsor.read_bsor(replay(device=b""), "f").found["device"] == "c"
    assert bsor.read_bsor(replay(device=b"Q\xffest"), "f").found["device"] == "Q\ufffdest, c"


@pytest.mark.parametrize(
    "content",
    [
        replay(3),
        replay(section=b"\x02"),
        replay()[:-1],
        replay().replace(b"\x00" + texts(b"1.2"), b"\x03" + texts(b"1.2")),
        replay().replace(texts(b"1.29"), struct.pack("<i", -4) + b"1.29"),
        replay().replace(texts(b"1.29"), struct.pack("<i", 9000) + b"1.29"),
        HEAD,
        HEAD + b"\x00" + texts(b"1", b"2"),
        HEAD + b"\x00" + texts(b"1", b"2") + struct.pack("<i", -1) * 20,
        HEAD + b"\x00" + texts(*[b""] * 12) + struct.pack("<i", 3) + b"ab",
    ],
)
def test_garbled_replays_are_refused(content: bytes) -> None:
    with pytest.raises(
        InputError, match=r"^f: the replay ends early or is garbled; download or record it again$"
    ):
        bsor.read_bsor(content, "f")


@pytest.mark.parametrize(
    ("content", "version"), [(HEAD[:4], r"\?"), (HEAD[:4] + b"\x07", "7"), (HEAD[:4] + b"\x00x", "0")]
)
def test_replays_of_other_versions_are_refused(content: bytes, version: str) -> None:
    assert bsor.recognise(content)
    with pytest.raises(InputError, match=f"^f: replay version {version}; only version 1 is known$"):
        bsor.read_bsor(content, "f")


def poses(*rows: tuple[float, ...]) -> dict[str, Any]:
    return {
        "poses": [
            {"timestamp": t, "position": {"x": x, "y": y, "z": z}, "rotation": {"x": a, "y": b, "z": c}}
            for t, x, y, z, a, b, c in rows
        ]
    }


@pytest.mark.parametrize("wrapped", [False, True])
def test_browser_recordings_are_read_as_they_are(wrapped: bool) -> None:
    tracks = {
        "camera": poses((1500, 1, 2, 3, 10, 20, 30), (1750, 4, 5, 6, -40, 50, 160)),
        "right": {"poses": []},
    }
    content: Any = {"recording": tracks, "left": poses((0,) * 7)} if wrapped else tracks
    raw = read_aframe(json.dumps(content).encode(), "f")
    raw = applied(raw, raw.reading)
    assert raw.found == {"format": "A-Frame motion capture"} and raw.on_floor and not raw.states_validity
    head, left, right = raw.tracks
    np.testing.assert_allclose(head.times, [1.5, 1.75])
    np.testing.assert_allclose(head.positions, [[1, -3, 2], [4, -6, 5]])
    turn = Rotation.from_euler("YXZ", [[20, 10, 30], [50, -40, 160]], degrees=True)
    up = Rotation.from_euler("x", 90, degrees=True)
    found = Rotation.from_quat(np.roll(head.rotations, -1, axis=-1))
    assert (found * (up * turn * up.inv()).inv()).magnitude().max() < 1e-7
    assert head.valid.dtype == np.bool_ and head.valid.tolist() == [True, True]
    for track in (left, right):
        assert track.times.shape == (0,) and track.positions.shape == (0, 3)
        assert track.rotations.shape == (0, 4) and track.valid.shape == (0,)


CAMERA = {"camera": poses((0, 1, 2, 3, 0, 0, 0))}


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b'{"a": 1,\n"b": \xff}', r"not UTF-8 text; was the file cut short\? record it again"),
        (b'{"a": 1,\n"b": }', r"line 2: broken JSON \(Expecting value\); was the file cut short\? record it again"),
        (b"[1]", "no trackers in it; an A-Frame recording has camera, left and right"),
        (b'{"recording": 3}', "no trackers in it; an A-Frame recording has camera, left and right"),
        (b"{}", "no poses of the camera; record the headset as well as the controllers"),
        (b'{"camera": 5}', "no poses of the camera; record the headset as well as the controllers"),
        (b'{"camera": {}}', "no poses of the camera; record the headset as well as the controllers"),
        ({**CAMERA, "leftHand": {"poses": 5}}, "leftHand: poses is not a list; record it again"),
        ({**CAMERA, "left": {"poses": [None]}},
         "left: pose 0 lacks a number among timestamp, position and rotation; remove it"),
        ({**CAMERA, "right": {"poses": [*CAMERA["camera"]["poses"], 7]}}, "right: pose 1 lacks a number .*; remove it"),
        ({"head": {"poses": [{"timestamp": 0, "position": {}, "rotation": {}}]}}, "head: pose 0 lacks a number .*"),
        ({**CAMERA, "right": {"poses": [{**CAMERA["camera"]["poses"][0], "rotation": {"x": 1, "y": [2], "z": 3}}]}},
         "right: pose 0 lacks a number .*"),
    ],
)  # fmt: skip
def test_faults_of_browser_recordings(content: Any, message: str) -> None:
    given = content if isinstance(content, bytes) else json.dumps(content).encode()
    with pytest.raises(InputError, match=f"^f: {message}$"):
        read_aframe(given, "f")


def test_browser_recordings_are_recognised_by_their_words() -> None:
    good = b' \n{"camera": {"poses": [{"rotation": 1}]}}'
    assert is_aframe(good)
    for content in (b"", b"[" + good, good.replace(b"poses", b"pose"), good.replace(b"rotation", b"turn")):
        assert not is_aframe(content)


def own(*comments: str, rows: int = 2, **cells: str) -> bytes:
    """A table of ours: comments, and some columns of the last row set."""
    lines = [["0.5", *["0.1", "0.2", "1.6", "1", "0", "0", "0", "1"] * 3] for _ in range(rows)]
    for i, line in enumerate(lines):
        line[0] = str(0.5 + i)
    for column, value in cells.items():
        lines[-1][COLUMNS.index(column)] = value
    table = [",".join(COLUMNS), *(",".join(line) for line in lines)]
    return "\n".join(["# footwork-recording 1", *comments, *table]).encode()


def test_comments_of_our_tables_are_read() -> None:
    raw = read_csv(own("# name:  Take 3: again ", "#eye_height:1.625", "# a note", "", "# other: 7"), "f")
    assert raw.name == "Take 3: again" and raw.eye_height == 1.625
    assert raw.found == {"format": "Footwork CSV"} and raw.states_validity and raw.on_floor
    assert raw.mounts is DEVICE_MOUNTS
    for track in raw.tracks:
        np.testing.assert_array_equal(track.times, [0.5, 1.5])
        np.testing.assert_array_equal(track.positions, [[0.1, 0.2, 1.6]] * 2)
        np.testing.assert_array_equal(track.rotations, [[1, 0, 0, 0]] * 2)
        assert track.valid.tolist() == [True, True]
    bare = read_csv(own(), "f")
    assert bare.name == "" and bare.eye_height is None
    assert is_csv(own()) and is_csv(b"\xef\xbb\xbf" + own()) and not is_csv(b"\n" + own())


def test_mounts_of_our_tables_are_made_unit() -> None:
    raw = read_csv(
        own(
            "# mount_head: 0.1 0.2 0.3 0 2 0 0",
            "# mount_left: 1 2 3 0.3 0 0 -0.4",
            "# mount_right: 4 5 6 1 0 0 0",
        ),
        "f",
    )
    np.testing.assert_array_equal(raw.mounts.offsets, [[0.1, 0.2, 0.3], [1, 2, 3], [4, 5, 6]])
    np.testing.assert_allclose(raw.mounts.turns, [[0, 1, 0, 0], [0.6, 0, 0, -0.8], [1, 0, 0, 0]])


MOUNTS = [f"# mount_{tracker}: 0 0 0 1 0 0 0" for tracker in TRACKERS]


@pytest.mark.parametrize(
    ("comments", "message"),
    [
        (["# eye_height: 1.6 1.7"], "line 2: eye_height is '1.6 1.7', not 1 finite number"),
        (["#", "# eye_height:"], "line 3: eye_height is '', not 1 finite number"),
        (["# eye_height: inf"], "line 2: eye_height is 'inf', not 1 finite number"),
        (["# eye_height: 0.29"], "line 2: eye height 0.29 m is no person's; correct it"),
        (["# eye_height: 3.01"], "line 2: eye height 3.01 m is no person's; correct it"),
        (MOUNTS[:2], "no mount_right beside the other mounts; state all three or none"),
        (MOUNTS[2:], "no mount_head beside the other mounts; state all three or none"),
        ([*MOUNTS[:2], MOUNTS[2] + " 0"], "line 4: mount_right is '0 0 0 1 0 0 0 0', not 7 finite numbers"),
        (
            [*MOUNTS[:2], MOUNTS[2].replace("1", "nan")],
            "line 4: mount_right is '0 0 0 nan 0 0 0', not 7 finite numbers",
        ),
        (
            [MOUNTS[0].replace("1", "0.49"), *MOUNTS[1:]],
            "line 2: mount_head's rotation is no unit quaternion w x y z",
        ),
    ],
)
def test_faults_of_comments(comments: list[str], message: str) -> None:
    with pytest.raises(InputError) as raised:
        read_csv(own(*comments), "f")
    assert str(raised.value) == f"f: {message}"


@pytest.mark.parametrize("height", [0.3, 3.0, 1.0])
def test_eye_heights_of_children_and_on_stilts_are_read(height: float) -> None:
    assert read_csv(own(f"# eye_height: {height}"), "f").eye_height == height


@pytest.mark.parametrize(
    ("cells", "message"),
    [
        ({"head_qw": "0.09"}, "head has a zero quaternion; set head_valid to 0 where it was not tracked"),
        ({"left_qw": "0.11"}, ""),
        ({"right_px": "10000"}, "right has a value past 10000; set right_valid to 0 where it was not tracked"),
        ({"right_py": "-10000"}, "right has a value past 10000; set right_valid to 0 where it was not tracked"),
        ({"right_px": "9999"}, ""),
        ({"left_qz": "-inf"}, "left has an empty or infinite value; set left_valid to 0 where it was not tracked"),
        ({"left_qz": "nan", "left_valid": "0"}, ""),
        ({"left_px": "1e9", "left_valid": "0"}, ""),
        ({"head_qw": "0", "head_valid": "0"}, ""),
        ({"head_qw": "0", "head_valid": "0.5"},
         "head has a zero quaternion; set head_valid to 0 where it was not tracked"),
        ({"time": "0.5"}, "time does not run forward; sort the rows and drop repeated ones"),
        ({"time": "0.25"}, "time does not run forward; sort the rows and drop repeated ones"),
        ({"time": "inf"}, "time is not a finite number; give every row its seconds"),
    ],
)  # fmt: skip
def test_faults_of_the_last_row(cells: dict[str, str], message: str) -> None:
    content = own("# a note", **cells)
    if message:
        with pytest.raises(InputError) as raised:
            read_csv(content, "f")
        assert str(raised.value) == f"f: line 5: {message}"
    else:
        valid = [cells.get(f"{tracker}_valid", "1") != "0" for tracker in TRACKERS]
        assert [bool(track.valid[-1]) for track in read_csv(content, "f").tracks] == valid


def test_of_many_faults_the_first_row_is_named() -> None:
    text = own(rows=4).decode().splitlines()
    for line, old, new in ((5, "0.1,0.2", "inf,0.2"), (4, ",1,0,0,0,1", ",0,0,0,0,1"), (3, "1.5,", "9.5,")):
        text[line] = text[line].replace(old, new)
    with pytest.raises(InputError, match=r"^f: line 5: time does not run forward"):
        read_csv("\n".join(text).encode(), "f")


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("# footwork-recording 2", "line 1: version 2 is newer than 1, the last known; update Footwork"),
        ("# footwork-recording 1.0", "line 1: the format's version is '1.0', not a whole number such as 1"),
        ("# footwork-recording ", "line 1: the format's version is '', not a whole number such as 1"),
    ],
)
def test_versions_of_our_tables(line: str, message: str) -> None:
    content = own().decode().splitlines()
    with pytest.raises(InputError) as raised:
        read_csv("\n".join([line, *content[1:]]).encode(), "f")
    assert str(raised.value) == f"f: {message}"
    assert len(read_csv("\n".join(["# footwork-recording 0", *content[1:]]).encode(), "f").tracks) == 3


def test_a_table_of_comments_alone() -> None:
    with pytest.raises(InputError, match=r"^f: line 3: no table after the comments; nothing was recorded$"):
        read_csv(b"# footwork-recording 1\n# a: b\n\n", "f")

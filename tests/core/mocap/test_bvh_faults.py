"""Broken BVH files: one clear line with the line's number, and nothing built."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from footwork.core.errors import InputError
from footwork.core.mocap.bvh import BvhFile, parse_bvh, read_bvh, write_bvh
from hypothesis import given, settings
from hypothesis import strategies as st

pytestmark = pytest.mark.filterwarnings("error")

LINES = """HIERARCHY
ROOT Hips
{
	OFFSET 0.0 0.0 0.0
	CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
	JOINT Spine
	{
		OFFSET 0.0 10.0 0.0
		CHANNELS 3 Zrotation Xrotation Yrotation
		End Site
		{
			OFFSET 0.0 5.0 0.0
		}
	}
}
MOTION
Frames: 3
Frame Time: 0.033333
1 2 3 4 5 6 7 8 9
1 2 3 4 5 6 7 8 9
1 2 3 4 5 6 7 8 9
""".splitlines()
VALID = "\n".join(LINES) + "\n"


def with_line(number: int, text: str | None) -> str:
    """The valid file with one line, counted from 1, replaced or (None) taken out."""
    lines = list(LINES)
    lines[number - 1 : number] = [] if text is None else [text]
    return "\n".join(lines) + "\n"


FAULTS = {
    "empty": ("", 1, "empty"),
    "only white space": (" \n\n\t", 1, "empty"),
    "not BVH": ("solid cube\nfacet normal 0 0 0\n", 1, "not BVH"),
    "binary": ("\x00\xff\x13PNG" * 50, 1, "not BVH"),
    "negative frames": (with_line(17, "Frames: -3"), 17, "-3"),
    "frames not a number": (with_line(17, "Frames: three"), 17, "three"),
    "frames missing": (with_line(17, None), 17, "Frames: is missing"),
    "frame time missing": (with_line(18, None), 18, "Frame Time: is missing"),
    "frame time zero": (with_line(18, "Frame Time: 0"), 18, "positive"),
    "frame time with a comma": (with_line(18, "Frame Time: 0,0333"), 18, "0,0333"),
    "frame time nan": (with_line(18, "Frame Time: nan"), 18, "nan"),
    "short row": (with_line(20, "1 2 3 4 5 6 7 8"), 20, "8 numbers where 9"),
    "long row": (with_line(20, "1 2 3 4 5 6 7 8 9 10"), 20, "10 numbers where 9"),
    "row short, next one long": (
        with_line(20, "1 2 3 4 5 6 7 8").replace("1 2 3 4 5 6 7 8 9\n1", "1 2 3 4 5 6 7 8 9\n1", 1)[:-1]
        + " 9\n",
        20,
        "8 numbers where 9",
    ),
    "every row short": (VALID.replace("1 2 3 4 5 6 7 8 9", "1 2 3 4 5 6 7 8"), 19, "8 numbers where 9"),
    "nan": (with_line(21, "1 2 3 nan 5 6 7 8 9"), 21, "'nan'"),
    "infinity": (with_line(19, "1 2 3 4 5 -inf 7 8 9"), 19, "'-inf'"),
    "overflow": (with_line(19, "1 2 3 4 5 1e999 7 8 9"), 19, "'1e999'"),
    "word among numbers": (with_line(21, "1 2 3 4 5 six 7 8 9"), 21, "'six'"),
    "two numbers run together": (with_line(21, "1 2 3 4 5 6.5.5 7 8 9"), 21, "'6.5.5'"),
    "decimal commas": (with_line(19, "1,5 2 3 4 5 6 7 8 9"), 19, "'1,5'"),
    "too few rows": (with_line(21, None), 20, "after 2 of 3 frames"),
    "no rows": ("\n".join(LINES[:18]) + "\n", 18, "after 0 of 3 frames"),
    "too many rows": (with_line(17, "Frames: 2"), 21, "more rows than the 2"),
    "cut off in a row": (VALID[:-8], 21, "5 numbers where 9"),
    "cut off in the hierarchy": ("\n".join(LINES[:8]) + "\n", 8, "ends before MOTION"),
    "unknown channel": (with_line(9, "CHANNELS 3 Zrotation Xscale Yrotation"), 9, "'Xscale'"),
    "channel missing": (with_line(9, "CHANNELS 3 Zrotation Xrotation"), 9, "2 of 3 channels"),
    "channel too many": (with_line(9, "CHANNELS 2 Zrotation Xrotation Yrotation"), 9, "'Yrotation'"),
    "channel twice": (with_line(5, "CHANNELS 2 Xposition Xposition"), 5, "twice"),
    "channels twice": (with_line(8, "CHANNELS 3 Zrotation Xrotation Yrotation"), 9, "second CHANNELS"),
    "offset of two": (with_line(8, "OFFSET 0.0 10.0"), 8, "OFFSET"),
    "offset not a number": (with_line(8, "OFFSET 0.0 ten 0.0"), 8, "'ten'"),
    "offset nan": (with_line(12, "OFFSET 0.0 nan 0.0"), 12, "'nan'"),
    "offset outside": (with_line(2, "OFFSET 0 0 0"), 2, "outside"),
    "opening brace missing": (with_line(3, None), 3, "opening brace"),
    "closing brace missing": (with_line(15, None), 15, "closed"),
    "closing brace too many": (with_line(16, "}"), 16, "too many"),
    "joint without parent": (with_line(2, "JOINT Hips"), 2, "outside"),
    "second root": (with_line(16, "ROOT Other"), 16, "second ROOT"),
    "no joints": ("HIERARCHY\nMOTION\nFrames: 1\nFrame Time: 0.1\n", 2, "without joints"),
    "out of all bounds": (with_line(20, "1 2 3 4 1e300 6 7 8 9"), 20, "'1e300'"),
    "offset out of all bounds": (with_line(8, "OFFSET 0 -1e40 0"), 8, "'-1e40'"),
    "stray words": (with_line(8, "OFFSET 0 10 0 0"), 8, "'0'"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_told_in_one_line_with_its_number(fault: str, tmp_path: Path):
    text, line, words = FAULTS[fault]
    path = tmp_path / "take.bvh"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(InputError) as error:
        read_bvh(path)
    message = str(error.value)
    assert message.startswith(f"{path}: line {line}: "), message
    assert words in message
    assert "\n" not in message
    assert len(message) < len(str(path)) + 160
    with pytest.raises(InputError, match=f"^memory: line {line}: "):
        parse_bvh(text.encode("latin-1"), "memory")


def test_fault_in_a_file_with_windows_line_ends_and_blank_lines(tmp_path: Path):
    path = tmp_path / "take.bvh"
    path.write_bytes(with_line(20, "\r\n\r\n1 2 3 4 5 x 7 8 9").replace("\n", "\r\n").encode())
    with pytest.raises(InputError, match="'x' is not a finite number"):
        read_bvh(path)


def test_missing_file_and_folder(tmp_path: Path):
    with pytest.raises(InputError, match="No such file"):
        read_bvh(tmp_path / "none.bvh")
    with pytest.raises(InputError, match="is a folder"):
        read_bvh(tmp_path)


def test_huge_noise_is_refused_by_its_first_bytes(tmp_path: Path):
    path = tmp_path / "noise.bvh"
    with path.open("wb") as file:
        file.write(os.urandom(64))
        file.truncate(8 << 30)  # sparse: 8 GB that would not fit if they were read
    with pytest.raises(InputError, match="line 1: is not BVH"):
        read_bvh(path)


def test_huge_noise_after_a_good_start_is_refused(tmp_path: Path):
    path = tmp_path / "noise.bvh"
    for start, words in [
        ("HIERARCHY\n", "not expected here"),
        (VALID, "line 17: .* bytes are too many for the 3 frames"),
    ]:
        with path.open("wb") as file:
            file.write(start.encode())
            file.truncate(8 << 30)
        with pytest.raises(InputError, match=words):
            read_bvh(path)


def test_nothing_is_left_where_writing_fails(tmp_path: Path):
    bvh = parse_bvh(VALID.encode(), "x")
    with pytest.raises(InputError, match="no folder"):
        write_bvh(tmp_path / "missing" / "x.bvh", bvh)
    assert list(tmp_path.iterdir()) == []


@settings(max_examples=300, deadline=None)
@given(st.integers(0, len(VALID) - 1), st.integers(0, 30), st.binary(max_size=12))
def test_damaged_files_are_read_or_refused_but_never_break(start: int, length: int, junk: bytes):
    data = VALID.encode()[:start] + junk + VALID.encode()[start + length :]
    try:
        bvh = parse_bvh(data, "x.bvh")
    except InputError as error:
        assert str(error).startswith("x.bvh: line ")
        assert "\n" not in str(error)
    else:
        assert isinstance(bvh, BvhFile)
        assert bvh.values.shape == (len(bvh), sum(map(len, bvh.channels)))

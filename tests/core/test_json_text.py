"""One reader for JSON from anywhere."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path
from typing import Any

import pytest
from footwork.core.errors import FaultError, InputError
from footwork.core.json_text import parse_json, read_json, to_json
from hypothesis import given, settings
from hypothesis import strategies as st

VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(10**20), 10**20)
    | st.floats(allow_nan=False, allow_infinity=False),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
)
PAD = b" " * (1 << 20)
"""Pushes what follows into another piece of the text."""


@settings(max_examples=200, deadline=None)
@given(value=VALUES | st.text(), small=st.booleans(), pad=st.booleans(), plain=st.booleans())
def test_what_json_writes_is_read(value: Any, small: bool, pad: bool, plain: bool) -> None:
    content = json.dumps(value, ensure_ascii=plain).encode()
    assert parse_json(PAD * pad + content, small=small) == value


FAULTS = {
    b"": "line 1: broken JSON",
    b'{"a": 1,\n\n "b" 2}': "line 3: broken JSON",
    b"\xff\xfe[\x00]\x00": "not UTF-8",
    b"[" * 100_000: "nested too deeply",
    b"[" * 65 + b"]" * 65: "nested too deeply",
    b'{"a": ' * 65 + b"1" + b"}" * 65: "nested too deeply",
    b"[" * 40 + PAD + b"[" * 40: "nested too deeply",
    b"9" * 400: "more than 300 digits",
    b"9" * 5000: "more than 300 digits",
    b"[0." + b"1" * 301 + b"]": "more than 300 digits",
    PAD[:-150] + b"7" * 301: "more than 300 digits",
    b"NaN": "NaN",
    b"[-Infinity]": "-Infinity",
    b'"\\ud800"': "half of a letter",
    b'["a", {"b\\udc80": 1}]': "half of a letter",
}


@pytest.mark.parametrize("small", [False, True])
@pytest.mark.parametrize("content", FAULTS, ids=range(len(FAULTS)))
def test_faults(content: bytes, small: bool) -> None:
    with pytest.raises(FaultError) as caught:
        parse_json(content, small=small)
    assert FAULTS[content] in str(caught.value)


@pytest.mark.parametrize("content", [b'{"a": 1, "a": 2}', b"1e999", b"[-1e400]"])
def test_of_small_texts_more_is_asked(content: bytes) -> None:
    with pytest.raises(FaultError):
        parse_json(content)
    parse_json(content, small=False)


@pytest.mark.parametrize("text", ["[" * 1000, "9" * 1000, 'a"' * 500 + "[" * 200, "\\" * 501, '"\\"[['])
def test_texts_may_hold_any_brackets_and_digits(text: str) -> None:
    for pad in (b"", PAD):
        assert parse_json(b"[" + pad + json.dumps(text).encode() + b"]") == [text]


def test_letters_of_two_halves_and_a_mark_at_the_start() -> None:
    assert parse_json(b'\xef\xbb\xbf"\\ud83d\\ude00"') == "\N{GRINNING FACE}"


def test_files(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    with pytest.raises(InputError, match=r"a.json: not a file; a toy is a JSON file"):
        read_json(path, "toy")
    path.write_text("[1, 2]")
    assert read_json(path, "toy") == [1, 2]
    path.write_bytes(PAD * 2)
    with pytest.raises(InputError, match=r"a.json: larger than 1 MB; no toy is"):
        read_json(path, "toy", 1_000_000)
    with pytest.raises(FaultError, match="larger than 1 MB"):
        parse_json(PAD * 2, 1_000_000)


@given(value=VALUES, sort_keys=st.booleans())
def test_what_is_written_is_json_that_is_read_again(value: Any, sort_keys: bool) -> None:
    assert parse_json(to_json(value, sort_keys=sort_keys).encode()) == value


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
def test_numbers_that_json_does_not_know_are_not_written(number: float) -> None:
    for value, where in (
        (number, "the value"),
        ({"metrics": {"root_error_cm": {"mean": 1.0, "p95": number}}}, "metrics.root_error_cm.p95"),
        ({"series": [0.0, (1.0, number)]}, r"series\[1\]\[1\]"),
    ):
        with pytest.raises(ValueError, match=f"^{where} is not finite"):
            to_json(value)


def test_names_that_are_no_letters_can_be_written() -> None:
    name = os.fsdecode(b"take-\xff.bvh")
    assert parse_json(to_json({"file": name}).encode()) == {"file": "take-?.bvh"}

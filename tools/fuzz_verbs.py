"""Changed files through the verbs of the command line, as `main` runs them: how they end, what they say and leave."""

from __future__ import annotations

import contextlib
import importlib.util
import io
import shutil
from pathlib import Path

from footwork.cli import main
from footwork.core.errors import LONGEST

WITH_BPY = importlib.util.find_spec("bpy") is not None


def run_verb(text: str, path: Path) -> int:
    """Run a verb over an input and check all of it.

    Args:
        text: the words of a command; INPUT is the input, OUT/ an empty folder, and what lies beside the input is
            called by its name.
        path: the input.

    Returns:
        The exit code: 0, 2 or 3.

    Raises:
        AssertionError: it ended or said what it must not, or left something behind.
    """
    out = path.parent / "out"
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir()
    words = [_word(word, path, out) for word in text.split()]
    error = io.StringIO()
    with contextlib.redirect_stderr(error), contextlib.redirect_stdout(io.StringIO()) as said:
        code = main(words)
    lines = error.getvalue().splitlines()
    left = sorted(str(item.relative_to(out)) for item in out.rglob("*"))
    assert code in (0, 2, 3), f"{text}: code {code}, {lines[-1:]}"
    for line in (*error.getvalue().split("\n"), *said.getvalue().split("\n")):
        assert line.isprintable() and len(line) <= LONGEST, f"{text}: said {line!r}"
    if code == 2:
        faults = [line for line in lines if line.startswith(f"footwork {words[0]}: ")]
        assert faults and len(set(faults)) == len(faults), f"{text}: faults {faults}"
        assert not left, f"{text}: code 2, and {left} written"
    else:
        for word in words:
            assert not word.startswith(str(out)) or Path(word).exists(), f"{text}: {word} is missing"
    return code


def _word(word: str, path: Path, out: Path) -> str:
    if word == "INPUT":
        return str(path)
    if word.startswith("OUT/"):
        return str(out / word.removeprefix("OUT/"))
    beside = path.parent / word
    return str(beside) if beside.is_file() else word

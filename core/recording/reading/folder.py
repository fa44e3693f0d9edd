"""Folders with a file for each device, trial by trial, as UXF writes them: joined into one table."""

from __future__ import annotations

from pathlib import Path

from ...bounds import RECORDING_BYTES
from ...errors import InputError
from .dress import header_line, plain_table, unpacked
from .meaning import whose, words_of

_TABLES = (".csv", ".tsv", ".txt")
_MOST = 4000
"""Files."""


def joined(folder: Path) -> bytes:
    """One table with a row a device of all tables in a folder, and those below, whose names tell a tracker.

    Raises:
        InputError: there are none of the headset, they cannot be read, or are too large.
    """
    header, rows, names, total = "", list[str](), set[str](), 0
    for path in sorted(folder.rglob("*"))[:_MOST]:
        tracker = whose(words_of(path.stem))[0]
        if path.suffix.lower() not in _TABLES or not tracker or not path.is_file():
            continue
        total += path.stat().st_size
        if total > RECORDING_BYTES:
            raise InputError(f"{folder}: larger than {RECORDING_BYTES // 1_000_000} MB; cut the recording")
        content = plain_table(unpacked(path.read_bytes(), str(path)))
        lines = content.decode("utf-8", "replace").removeprefix("\ufeff").splitlines()
        start = header_line(lines)
        if not lines or (header and lines[start] != header):
            continue
        header = lines[start]
        names.add(tracker)
        rows += [f"{tracker},{line}" for line in lines[start + 1 :] if line.strip()]
    if "head" not in names:
        raise InputError(f"{folder}: no table of the headset in it; let a file's name have head or hmd in it")
    return "\n".join([f"device,{header}", *rows, ""]).encode()

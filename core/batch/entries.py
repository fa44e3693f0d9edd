"""The recordings of a batch: a folder, a pattern of names, or a table with one row for each."""

from __future__ import annotations

import csv
import glob
import io
import os
import tomllib
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any, cast

from ..bounds import TABLE_BYTES
from ..errors import FaultError, InputError
from ..files import first_bytes
from ..json_text import read_json
from ..recording.formats import suffixes
from ..staging import is_staging

TABLES = (".csv", ".toml", ".json")
SUMMARY = "summary"
"""Name of the batch's own files, which no recording's may have."""
_MOST_FAULTS = 20


@dataclass(frozen=True, slots=True)
class Entry:
    """One recording of a batch."""

    recording: str
    """Path of its file."""
    name: str
    """Of its outputs, without an ending; "/" between folders."""
    place: str = ""
    """Where it is said, for messages: table and line or row."""
    values: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """Further cells of its row, by column, as the table has them."""
    folder: Path = Path()
    """From where files in these cells are looked for."""


def find_entries(jobs: str) -> tuple[Entry, ...]:
    """The recordings that `jobs` stands for, each with a name of its own.

    Args:
        jobs: a folder, a pattern such as "day?/**/*.bsor", or a table (`TABLES`). Files in a table are looked for from
            the table's own folder.

    Raises:
        InputError: nothing is found, the table cannot be read, or two recordings have the same name.
    """
    path = Path(jobs)
    if path.is_dir():
        known = suffixes()
        files = [file for file in _inside(path) if file.suffix.lower() in known]
        return _named(files, path, jobs)
    if not path.exists() and glob.has_magic(jobs):
        files = [Path(file) for file in glob.glob(jobs, recursive=True) if Path(file).is_file()]  # noqa: PTH207 - may be absolute
        return _named(files, _fixed(path), jobs)
    if path.suffix.lower() not in TABLES:
        raise InputError(f"{jobs}: no folder, pattern or table; give one of these ({', '.join(TABLES)})")
    entries = _read_table(path)
    _check_names(entries)
    return entries


def _inside(folder: Path) -> Iterable[Path]:
    """All files below a folder, hidden ones left out."""
    for place, folders, files in os.walk(folder):
        folders[:] = [name for name in folders if not name.startswith(".")]
        yield from (Path(place) / name for name in files if not name.startswith("."))


def _fixed(pattern: Path) -> Path:
    """The part of a pattern that is the same for all that it finds."""
    parts: list[str] = []
    for part in pattern.parts[:-1]:
        if glob.has_magic(part):
            break
        parts.append(part)
    return Path(*parts)


def _named(files: Sequence[Path], folder: Path, jobs: str) -> tuple[Entry, ...]:
    """Entries named as their files are; where that gives two the same name, the ending belongs to it."""
    if not files:
        raise InputError(f"{jobs}: no recordings found; known endings are {', '.join(suffixes())}")
    files = sorted(files)
    places = [file.relative_to(folder) for file in files]
    short = [place.with_suffix("").as_posix() for place in places]
    times = Counter(name.casefold() for name in [*short, SUMMARY])
    names = [
        name if times[name.casefold()] == 1 else place.as_posix()
        for name, place in zip(short, places, strict=True)
    ]
    entries = tuple(Entry(str(file), name, str(file)) for file, name in zip(files, names, strict=True))
    _check_names(entries)
    return entries


def _read_table(path: Path) -> tuple[Entry, ...]:
    entries: list[Entry] = []
    faults: list[str] = []
    for place, row in _rows(path):
        try:
            entries.append(_entry(row, path.parent, f"{path} {place}"))
        except FaultError as fault:
            faults.append(f"{path} {place}: {fault}; correct the table")
    if faults:
        raise InputError(*faults[:_MOST_FAULTS])
    if not entries:
        raise InputError(f"{path}: names no recording; give one in each row")
    return tuple(entries)


def _entry(row: Mapping[str, Any], folder: Path, place: str) -> Entry:
    values = dict(row)
    recording, name = values.pop("recording", None), values.pop("output", None)
    if not isinstance(recording, str) or not recording.strip():
        raise FaultError("no recording")
    if isinstance(values.get("settings"), dict):
        inner = cast(dict[str, Any], values.pop("settings"))
        twice = sorted(set(inner) & set(values))
        if twice:
            raise FaultError(f"{twice[0]} is said twice")
        values |= inner
    file = folder / recording.strip()
    if name is None or name == "":
        name = file.with_suffix("").name
    if not isinstance(name, str):
        raise FaultError("output is no name")
    return Entry(str(file), name.strip(), place, values, folder)


def _rows(path: Path) -> list[tuple[str, Mapping[str, Any]]]:
    """The rows of a table with their places.

    Raises:
        InputError: it cannot be read.
    """
    kind = path.suffix.lower()
    try:
        if kind == ".csv":
            return _csv_rows(_text(path))
        rows = read_json(path, "table of jobs", TABLE_BYTES) if kind == ".json" else _toml_rows(_text(path))
        if not isinstance(rows, list):
            raise FaultError("is no list of rows")
        found = [(f"row {number}", row) for number, row in enumerate(cast(list[Any], rows), 1)]
        for place, row in found:
            if not isinstance(row, dict):
                raise FaultError(f"{place} has no names")
    except FaultError as fault:
        raise InputError(f"{path}: {fault}; docs/batch.md shows such a table") from None
    return found


def _text(path: Path) -> str:
    content = first_bytes(path, TABLE_BYTES)
    if len(content) > TABLE_BYTES:
        raise FaultError(f"larger than {TABLE_BYTES // 1_000_000} MB")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise FaultError("not UTF-8 text") from None


def _csv_rows(text: str) -> list[tuple[str, Mapping[str, Any]]]:
    reader = csv.DictReader(io.StringIO(text, newline=""), restkey="", skipinitialspace=True)
    rows: list[tuple[str, Mapping[str, Any]]] = []
    try:
        names = [name.strip() for name in reader.fieldnames or []]
        if "recording" not in names:
            raise FaultError(f"line 1: no column 'recording' (it has: {', '.join(names)[:80] or 'nothing'})")
        if len(set(names)) < len(names):
            raise FaultError("line 1: two columns have the same name")
        reader.fieldnames = names
        for row in reader:
            if row.get(""):
                raise FaultError(f"line {reader.line_num}: more cells than columns")
            rows.append(
                (f"line {reader.line_num}", {name: row[name] for name in names if name and row[name]})
            )
    except csv.Error as error:
        raise FaultError(f"line {reader.line_num}: {error}") from None
    return rows


def _toml_rows(text: str) -> Any:
    try:
        found = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise FaultError(f"broken TOML ({error})") from None
    if set(found) != {"job"}:
        raise FaultError("has not [[job]] tables alone")
    return found["job"]


def _check_names(entries: Sequence[Entry]) -> None:
    """Raise for names that lead elsewhere, and for two that are the same where cases are not told apart."""
    faults: list[str] = []
    places: dict[str, str] = {SUMMARY: "the batch's own files"}
    for entry in entries:
        key = str(PurePosixPath(entry.name)).casefold()
        if not _is_inside(entry.name):
            faults.append(
                f"{entry.place}: {entry.name!r} is no name for outputs inside of the folder; choose another"
            )
        elif key in places:
            faults.append(
                f"{entry.place}: {entry.name!r} is taken by {places[key]}; give it an output name of its own"
            )
        places.setdefault(key, entry.place)
    if faults:
        raise InputError(*faults[:_MOST_FAULTS])


def _is_inside(name: str) -> bool:
    """Whether a name can be that of a file in the folder of outputs or below, on any system."""
    parts = name.split("/")
    return name.isprintable() and all(
        part not in ("", ".", "..") and not set(part) & set('\\:*?"<>|') and not is_staging(part)
        for part in parts
    )


def in_folder(entries: Sequence[Entry], folder: Path) -> Entry | None:
    """The first entry whose recording lies in the folder of outputs, which would write over it."""
    whole = folder.resolve()
    inside: dict[str, bool] = {}
    for entry in entries:
        parent = os.path.dirname(entry.recording)  # noqa: PTH120 - a path for each of millions
        if parent not in inside:
            inside[parent] = Path(parent or ".").resolve().is_relative_to(whole)
        if inside[parent]:
            return entry
    return None


def largest_first(entries: Sequence[Entry]) -> list[tuple[Entry, int]]:
    """Entries with the bytes of their files, 0 for those that are not there.

    The largest come first: no worker is left with a long one when all others are done.
    """
    sized = [(entry, _size(entry.recording)) for entry in entries]
    return sorted(sized, key=lambda pair: -pair[1])


def _size(path: str) -> int:
    try:
        return os.stat(path).st_size  # noqa: PTH116 - as above
    except OSError:
        return 0

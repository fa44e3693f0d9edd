"""Presets: small JSON files that teach Footwork new names and tables, without code.

Each kind ("bone_maps", "recording_layouts") is a sub-folder of the presets that ship and of the user's own folder.
A file of the user's counts before those that ship and takes the place of one with the same name. A broken file is
skipped and reported; it never disables the others. Reading creates nothing.
"""

from __future__ import annotations

import functools
import json
import os
import sys
from collections.abc import Callable, Collection, Generator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar, cast

from .bounds import PRESET_BYTES
from .errors import FaultError, InputError, one_line
from .json_text import read_json
from .transaction import write_atomically

SHIPPED = Path(__file__).resolve().parents[1] / "presets"
"""The presets that ship."""
_given: ContextVar[dict[str, tuple[str, ...]]] = ContextVar("given presets", default={})  # noqa: B039
VARIABLE = "FOOTWORK_PRESETS"
"""Environment variable that names the user's folder of presets."""


class _Named(Protocol):
    @property
    def name(self) -> str: ...


Preset = TypeVar("Preset", bound=_Named)


@dataclass(frozen=True, slots=True, eq=False)
class Presets(Generic[Preset]):
    """All presets of one kind. The same object is returned until a file changes."""

    entries: tuple[Preset, ...]
    """The user's, then those that ship, each by file name; every name once."""
    skipped: tuple[str, ...]
    """One line for each file that cannot be used: which, why, what to do."""

    @property
    def note(self) -> str:
        """What a message adds in which no entry fits: the first of the skipped files; "" for none."""
        if not self.skipped:
            return ""
        first, *others = self.skipped
        return f"; {first}" + (f" (and {len(others)} more)" if others else "")


@dataclass(frozen=True, slots=True)
class _Listing:
    """What can be seen of a folder without reading its files."""

    files: tuple[tuple[str, int, int, int], ...] = ()
    """Path, time of change, size and inode of each preset file, by name."""
    fault: str = ""
    """Why the folder cannot be listed."""


def user_folder(kind: str) -> Path:
    """Where the user's presets of a kind belong, whether it exists or not."""
    return _own_folder() / kind


def configuration_folder(platform: str, environment: Mapping[str, str], home: Path) -> Path:
    """Footwork's folder among the settings of a platform (as `sys.platform`) for a user."""
    if platform == "win32":
        return Path(environment.get("APPDATA") or home / "AppData" / "Roaming") / "Footwork"
    if platform == "darwin":
        return home / "Library" / "Application Support" / "Footwork"
    base = environment.get("XDG_CONFIG_HOME", "")
    # a relative one is to be ignored, says the XDG specification
    return (Path(base) if Path(base).is_absolute() else home / ".config") / "footwork"


def keep_preset(kind: str, name: str, content: Mapping[str, Any]) -> Path:
    """Write a preset into the user's folder, which is made where it is missing, over an older one of its name.

    Raises:
        InputError: it cannot be written.
    """
    folder = user_folder(kind)
    stem = "".join(letter if letter.isalnum() or letter in "-_ " else "_" for letter in name).strip() or "own"
    path = folder / f"{stem}.json"
    text = json.dumps(content, indent=2, ensure_ascii=False) + "\n"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made ({error.strerror}); check its rights") from error
    write_atomically(path, lambda stream: stream.write(text.encode()))
    return path


def load_presets(kind: str, read: Callable[[Path], Preset]) -> Presets[Preset]:
    """All presets of a kind. Files are read again only after one was added, changed or removed.

    Args:
        kind: the sub-folder.
        read: reads one file, a function of a module; raises InputError for a broken one.
    """
    own = _list(user_folder(kind))
    given = tuple((path, *_stamp(Path(path))) for path in _given.get().get(kind, ()))
    return cast("Presets[Preset]", _load(kind, read, replace(own, files=(*given, *own.files))))


@contextmanager
def given_presets(kind: str, files: Sequence[str]) -> Generator[None]:
    """A time in which further files count, before all others; they have been read by `read_preset` already."""
    token = _given.set({**_given.get(), kind: tuple(str(Path(file).resolve()) for file in files)})
    try:
        yield
    finally:
        _given.reset(token)


def read_preset(path: str | os.PathLike[str], parse: Callable[[Any], Preset], what: str) -> Preset:
    """One preset from its file.

    Args:
        path: a JSON file.
        parse: makes the preset of the file's content; raises ValueError with what is wrong.
        what: what it should be, such as "bone map".

    Raises:
        InputError: unreadable, too large, not JSON, or not such a preset.
    """
    try:
        data = read_json(path, what, PRESET_BYTES)
    except FaultError as fault:
        raise InputError(f"{path}: {fault}; correct it") from None
    try:
        return parse(data)
    except ValueError as error:
        raise InputError(f"{path}: not a {what}: {error}; compare it with those that ship") from error


def check_keys(
    data: Any, needed: Collection[str], optional: Collection[str] = (), where: str = "it"
) -> dict[str, Any]:
    """`data` as a dictionary with exactly these keys; ValueError where it is not."""
    if not isinstance(data, dict):
        raise ValueError(f"{where} is not an object {{...}}")
    found = cast("dict[str, Any]", data)
    missing = [key for key in needed if key not in found]
    if missing:
        raise ValueError(f"{where} has no {missing[0]!r}")
    unknown = [key for key in found if key not in needed and key not in optional]
    if unknown:
        raise ValueError(f"{where} has {unknown[0]!r}, which is none of {', '.join((*needed, *optional))}")
    return found


def check_text(value: Any, where: str) -> str:
    """`value` as a text of one line with something in it; ValueError where it is not."""
    if (
        not isinstance(value, str)
        or len(value.strip().splitlines()) != 1
        or not "".join(value.split()).isprintable()
    ):
        raise ValueError(f"{where} is not a text of one line")
    return value


def check_texts(value: Any, where: str, count: int | None = None) -> tuple[str, ...]:
    """`value` as texts, `count` of them if given; ValueError where it is not a list of these."""
    size = "" if count is None else f"{count} "
    if not isinstance(value, list) or (count is not None and len(cast("list[Any]", value)) != count):
        raise ValueError(f"{where} is not a list of {size}texts")
    return tuple(check_text(item, f"an item of {where}") for item in cast("list[Any]", value))


def _own_folder() -> Path:
    """The user's folder of presets of every kind."""
    given = os.environ.get(VARIABLE)
    if given:
        return Path(given)
    try:
        home = Path.home()
    except RuntimeError:
        # some containers know no home for their user; no such folder exists then
        home = Path("~")
    return configuration_folder(sys.platform, os.environ, home)


def _list(folder: Path) -> _Listing:
    files: list[tuple[str, int, int, int]] = []
    try:
        with os.scandir(folder) as items:
            for item in items:
                if item.name.lower().endswith(".json") and not item.name.startswith("."):
                    files.append((item.path, *_stamp(item)))
    except FileNotFoundError:
        if os.environ.get(VARIABLE) and not folder.parent.is_dir():
            return _Listing(
                fault=f"{VARIABLE}: there is no folder {folder.parent}; create it or unset the variable"
            )
    except OSError as error:
        return _Listing(fault=f"{folder}: cannot be listed ({error.strerror}); check its rights")
    return _Listing(tuple(sorted(files)))


def _stamp(item: os.DirEntry[str] | Path) -> tuple[int, int, int]:
    try:
        found = item.stat()
    except OSError:
        # a link to nowhere; reading it says so
        return 0, 0, 0
    return found.st_mtime_ns, found.st_size, found.st_ino


@functools.lru_cache(maxsize=16)
def _load(kind: str, read: Callable[[Path], Any], own: _Listing) -> Presets[Any]:
    skipped = [own.fault] if own.fault else []
    entries: dict[str, Any] = {}
    sources: dict[str, str] = {}
    for path, *_ in own.files:
        try:
            preset = read(Path(path))
            if preset.name in sources:
                raise InputError(
                    f"{path}: {sources[preset.name]} has the same name {preset.name!r}; rename one"
                )
        except InputError as error:
            skipped.append(f"skipped {error}")
            continue
        entries[preset.name], sources[preset.name] = preset, Path(path).name
    for path in sorted((SHIPPED / kind).glob("*.json")):
        preset = read(path)
        entries.setdefault(preset.name, preset)
    return Presets(tuple(entries.values()), tuple(map(one_line, skipped)))

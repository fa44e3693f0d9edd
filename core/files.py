"""Files written whole or not at all, and their fingerprints."""

from __future__ import annotations

import contextlib
import glob
import hashlib
import os
import tempfile
from collections.abc import Callable, Generator, Mapping
from pathlib import Path
from typing import BinaryIO

from .errors import InputError


def check_target(path: str | os.PathLike[str]) -> Path:
    """Where `path` leads, links followed, after a look at whether a file can be written there.

    Raises:
        InputError: the folder is missing or cannot be written to, or `path` is a folder.
    """
    with _explained(path):
        target = Path(path).resolve()
        if not target.parent.is_dir():
            raise InputError(f"{path}: there is no folder {target.parent}; create it or choose another place")
        if target.is_dir():
            raise InputError(f"{path}: is a folder; give the name of a file to write")
        with tempfile.TemporaryFile(dir=target.parent):
            return target


def write_atomically(path: str | os.PathLike[str], writer: Callable[[BinaryIO], object]) -> None:
    """Write a file so that its name never stands for half of it.

    `writer` is given a binary file beside the target, which takes the target's name once it is complete.
    Whatever goes wrong, an older file of that name stays as it was and nothing is left behind.
    Links are followed.

    Args:
        path: the file to write; its folder must exist.
        writer: called once with the open file.

    Raises:
        InputError: the folder is missing or cannot be written to, `path` is a folder, or the disk is full.
    """
    target = check_target(path)
    part = target.with_name(f".{target.name[:64]}.{os.getpid()}.part")
    try:
        with _explained(path):
            with part.open("wb") as file:
                writer(file)
                file.flush()
                os.fsync(file.fileno())
            part.replace(target)
    finally:
        # gone already when all went well; a folder that forbids it has said so above
        with contextlib.suppress(OSError):
            part.unlink()


def remove_parts(path: str | os.PathLike[str]) -> None:
    """Remove what processes that were killed while they wrote `path` left beside it."""
    target = Path(path).resolve()
    for part in target.parent.glob(f".{glob.escape(target.name[:64])}.[0-9]*.part"):
        # what cannot be removed is in nobody's way
        with contextlib.suppress(OSError):
            part.unlink()


def write_together(writers: Mapping[str | os.PathLike[str], Callable[[Path], object]]) -> None:
    """As `write_atomically`, for several files that are all written or none, by writers that want a file name.

    Each writer is given a path of its target's name in a fresh folder beside the target, and must write there.

    Raises:
        InputError: a folder is missing or cannot be written to, or a target is a folder.
    """
    with contextlib.ExitStack() as folders:
        parts: list[tuple[Path, Path]] = []
        for path, writer in writers.items():
            target = check_target(path)
            folders.enter_context(_explained(path))
            folder = tempfile.TemporaryDirectory(prefix=f".{target.name[:64]}.", dir=target.parent)
            parts.append((Path(folders.enter_context(folder)) / target.name, target))
            writer(parts[-1][0])
        for part, target in parts:
            part.replace(target)


@contextlib.contextmanager
def _explained(path: str | os.PathLike[str]) -> Generator[None]:
    """What the system objects to in writing `path`, as an InputError."""
    try:
        yield
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(f"{path}: cannot be written ({reason}); free the place or choose another") from error


def sha256_of(path: str | os.PathLike[str]) -> str:
    """The SHA-256 of a file's bytes, 64 hexadecimal digits; InputError where it cannot be read."""
    try:
        with Path(path).open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise InputError(
            f"{path}: cannot be read ({error.strerror or error}); check its name and rights"
        ) from error

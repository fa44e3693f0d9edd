"""Paths of files to write, and fingerprints of files."""

from __future__ import annotations

import contextlib
import hashlib
import os
import stat
import tempfile
from collections.abc import Generator
from pathlib import Path

from .errors import InputError


def check_target(path: str | os.PathLike[str]) -> Path:
    """Where `path` leads, links followed, after a look at whether a file can be written there.

    Raises:
        InputError: the folder is missing or cannot be written to, `path` is a folder, or its links lead nowhere.
    """
    target = followed(path)
    with explained(path):
        if not target.parent.is_dir():
            raise InputError(f"{path}: there is no folder {target.parent}; create it or choose another place")
        if target.is_dir():
            raise InputError(f"{path}: is a folder; give the name of a file to write")
        # a name that the file system cannot hold is told by the look-up, too
        with contextlib.suppress(FileNotFoundError):
            if not stat.S_ISREG(target.stat().st_mode):
                raise InputError(f"{path}: is no ordinary file; give the name of one to write")
        with tempfile.TemporaryFile(dir=target.parent):
            return target


def followed(path: str | os.PathLike[str]) -> Path:
    """The absolute path of the file that `path` leads to; InputError where its links go round in a circle."""
    with explained(path):
        try:
            target = Path(path).resolve()
        except RuntimeError:
            target = None
        except ValueError as error:
            raise InputError(f"{str(path)!r}: is no name of a file ({error}); choose another") from error
        if target is None or target.is_symlink():
            raise InputError(f"{path}: is a link that leads back to itself; choose another place")
        return target


@contextlib.contextmanager
def explained(path: str | os.PathLike[str]) -> Generator[None]:
    """What the system objects to in writing `path`, as an InputError."""
    try:
        yield
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(f"{path}: cannot be written ({reason}); free the place or choose another") from error


def first_bytes(path: str | os.PathLike[str], most: int) -> bytes:
    """A file's bytes, `most` + 1 of a larger one; InputError where it cannot be read."""
    try:
        with Path(path).open("rb") as file:
            # asked for more, Python would take memory for as much
            return file.read(min(os.fstat(file.fileno()).st_size, most) + 1)
    except OSError as error:
        raise InputError(
            f"{path}: cannot be read ({error.strerror or error}); check its name and rights"
        ) from error


def sha256_of(path: str | os.PathLike[str]) -> str:
    """The SHA-256 of a file's bytes, 64 hexadecimal digits; InputError where it cannot be read."""
    try:
        with Path(path).open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise InputError(
            f"{path}: cannot be read ({error.strerror or error}); check its name and rights"
        ) from error

"""Folders beside the files to come, and the journal by which a change that was cut short is ended.

A staging folder lies beside its targets, so that one rename brings a file there. Its name cannot be guessed, it is
made anew and for its owner alone, so nobody can plant anything in it. As long as its process lives it holds a lock on
the file `owner`; a folder without that lock is left over. The first folder of a transaction is its main one: the others
name it in `owner`, and the journal, once it is there, is in it.
"""

from __future__ import annotations

import contextlib
import errno
import json
import os
import secrets
import shutil
import stat
from collections.abc import Generator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

from .errors import InputError

PREFIX = ".footwork-"
_DIGITS = 16
_OWNER, _JOURNAL, _BACK = "owner", "journal", "rollback"
_ATTEMPTS = 16
_BEYOND = 1 << 30
"""A byte that no file has: Windows lets nobody read what is locked."""


@dataclass(frozen=True, slots=True)
class Change:
    """One file to be replaced."""

    new: Path
    """The complete file, in a staging folder."""
    target: Path
    existed: bool
    """Whether there is an older file."""

    @property
    def old(self) -> Path:
        """Where the older file is kept until all is done."""
        return self.new.with_name(f"old-{self.new.name}")


class StagingFolder:
    """A new folder in `parent` for one process; `main` is the transaction's first one, None for that itself."""

    def __init__(self, parent: Path, main: Path | None) -> None:
        for _ in range(_ATTEMPTS):
            self.path = parent / f"{PREFIX}{secrets.token_hex(_DIGITS // 2)}"
            self.path.mkdir(mode=0o700)
            try:
                if self._own(main):
                    return
            except OSError:
                shutil.rmtree(self.path, ignore_errors=True)
                raise
        raise OSError(f"no folder can be made in {parent}")

    def _own(self, main: Path | None) -> bool:
        """Whether it is locked; False where somebody who tidies up has taken it for a left-over."""
        try:
            self._owner = (self.path / _OWNER).open("xb")
        except (FileExistsError, FileNotFoundError):
            return False
        if _lock(self._owner) is False or not _owner_is_there(self._owner, self.path):
            self._owner.close()
            return False
        if main is not None:
            self._owner.write(os.fsencode(_relative(main, self.path)))
            self._owner.flush()
        return True

    @property
    def has_journal(self) -> bool:
        """Whether a change has begun that is neither complete nor undone."""
        return any((self.path / name).exists() for name in (_JOURNAL, _BACK))

    def release(self) -> None:
        """Leave it to the next run."""
        self._owner.close()

    def remove(self) -> None:
        """Remove it with all that is in it."""
        _remove(self.path, self._owner)


def is_staging(name: str) -> bool:
    """Whether a file name is one of a staging folder."""
    digits = name.removeprefix(PREFIX)
    return name.startswith(PREFIX) and len(digits) == _DIGITS and not set(digits) - set("0123456789abcdef")


def recover(parent: Path) -> None:
    """End what processes that are gone left in a folder: complete or undo their changes, remove their files.

    Raises:
        InputError: a change can neither be completed nor undone.
    """
    try:
        places = sorted(path for path in parent.iterdir() if is_staging(path.name))
    except OSError:
        return  # whoever writes there will hear of it
    for place in places:
        _recover(place)


def _recover(place: Path) -> None:
    others: set[Path] = set()
    with _claimed(place) as owner:
        if owner is None:
            return
        named = os.fsdecode(owner.read(4096))
        if not named:
            others = _finish(place)
        else:
            main = _absolute(named, place)
            if is_staging(main.name) and main.is_dir():
                with _claimed(main) as owner_of_main:
                    if owner_of_main is None:
                        return
                    others = _finish(main)
                    _remove(main, owner_of_main)
        _remove(place, owner)
    for other in others:
        _recover(other)


def write_journal(main: Path, changes: Sequence[Change], made: Sequence[Path]) -> None:
    """From here on the changes are certain: what cuts them short, the next run completes.

    Args:
        main: the transaction's main staging folder.
        changes: all of them.
        made: folders that are made for them, outer ones first.
    """
    content = {
        "changes": [
            [_relative(change.new, main), _relative(change.target, main), change.existed]
            for change in changes
        ],
        "made": [_relative(folder, main) for folder in made],
    }
    part = main / f"{_JOURNAL}.part"
    with part.open("xb") as file:
        file.write(json.dumps(content).encode())
        file.flush()
        os.fsync(file.fileno())
    part.replace(main / _JOURNAL)
    sync_folder(main)


def complete(main: Path, changes: Sequence[Change], made: Sequence[Path]) -> None:
    """Make the changes that a journal tells of, or undo them all where one cannot be made.

    Raises:
        OSError: of the change that could not be made.
    """
    try:
        for folder in made:
            folder.mkdir(exist_ok=True)
        for change in changes:
            if change.new.exists():
                _replace(change)
    except OSError:
        (main / _JOURNAL).replace(main / _BACK)
        _undo(main, changes, made)
        raise
    for parent in dict.fromkeys(change.target.parent for change in changes):
        sync_folder(parent)
    (main / _JOURNAL).unlink()


def sync_folder(folder: Path) -> None:
    """Bring a folder's names to the disk, where the system knows of that."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _replace(change: Change) -> None:
    if change.target.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    if change.existed and not change.old.exists():
        try:
            os.link(change.target, change.old)
        except OSError:  # a file system without hard links, or a file that may not have more
            change.target.replace(change.old)
    change.new.replace(change.target)


def _undo(main: Path, changes: Sequence[Change], made: Sequence[Path]) -> None:
    for change in changes:
        if change.old.exists():
            change.old.replace(change.target)
        elif not change.existed and not change.new.exists():
            change.target.unlink(missing_ok=True)
    for folder in reversed(made):
        with contextlib.suppress(OSError):  # somebody else's files are in it
            folder.rmdir()
    (main / _BACK).unlink()


def _finish(main: Path) -> set[Path]:
    """Complete what a left-over journal tells of, or undo it where that cannot be done; all its staging folders."""
    for name in (_JOURNAL, _BACK):
        try:
            content = json.loads((main / name).read_bytes())
            changes, made = _read_journal(main, content)
        except FileNotFoundError:
            continue
        except (OSError, ValueError, KeyError, TypeError, RecursionError):
            break  # no journal of ours
        try:
            if name == _BACK:
                _undo(main, changes, made)
            else:
                _complete_or_undo(main, changes, made)
        except OSError as error:
            names = ", ".join(change.target.name for change in changes)
            raise InputError(
                f"{main}: a run that was cut short can neither be completed nor undone "
                f"({error.strerror or error}); make the place writable, or delete it to give up {names}"
            ) from error
        return {change.new.parent for change in changes}
    return set()


def _complete_or_undo(main: Path, changes: Sequence[Change], made: Sequence[Path]) -> None:
    try:
        complete(main, changes, made)
    except OSError:
        if any((main / name).exists() for name in (_JOURNAL, _BACK)):
            raise


def _read_journal(main: Path, content: Any) -> tuple[list[Change], list[Path]]:
    """What a journal says; ValueError where it reaches beyond the folders that staging folders of ours lie in."""
    changes: list[Change] = []
    for new, target, existed in content["changes"]:
        change = Change(_absolute(new, main), _absolute(target, main), bool(existed))
        place = change.new.parent
        if not (_is_ours(place) and change.target.is_relative_to(place.parent)):
            raise ValueError(target)
        changes.append(change)
    return changes, [_absolute(folder, main) for folder in content["made"]]


@contextlib.contextmanager
def _claimed(place: Path) -> Generator[BinaryIO | None]:
    """The file `owner` of a left-over staging folder, locked; None where its process lives or it is not ours."""
    owner = _claim(place) if _is_ours(place) else None
    try:
        yield owner
    finally:
        if owner is not None:
            owner.close()


def _claim(place: Path) -> BinaryIO | None:
    try:
        handle = os.open(place / _OWNER, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o600)
    except OSError:
        return None
    owner = os.fdopen(handle, "r+b")
    if _lock(owner) is True and _owner_is_there(owner, place):
        return owner
    owner.close()
    return None


def _owner_is_there(owner: BinaryIO, place: Path) -> bool:
    """Whether the open file is still the one in the folder."""
    try:
        return os.path.samestat(os.fstat(owner.fileno()), (place / _OWNER).stat())
    except OSError:
        return False


def _is_ours(place: Path) -> bool:
    """Whether a path is a staging folder that nobody else has made or may write to."""
    try:
        found = place.lstat()
    except OSError:
        return False
    if not (is_staging(place.name) and stat.S_ISDIR(found.st_mode)):
        return False
    return not hasattr(os, "geteuid") or (found.st_uid == os.geteuid() and not found.st_mode & 0o022)


def _remove(place: Path, owner: BinaryIO) -> None:
    """Remove a staging folder; `owner` goes last, so that it counts as somebody's until then."""
    with contextlib.suppress(OSError):
        for path in list(place.iterdir()):
            if path.name == _OWNER:
                continue
            if path.is_dir() and not path.is_symlink():
                shutil.rmtree(path, ignore_errors=True)
            else:
                path.unlink()
    if os.name == "nt":  # an open file cannot be removed there
        owner.close()
    with contextlib.suppress(OSError):
        (place / _OWNER).unlink()
        place.rmdir()
    owner.close()


def _lock(file: BinaryIO) -> bool | None:
    """Whether the file is locked for this process now; None where the file system has no locks."""
    try:
        if os.name == "nt":
            import msvcrt

            file.seek(_BEYOND)
            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
            file.seek(0)
        else:
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):
        return False
    except OSError:
        return None
    return True


def _relative(path: Path, main: Path) -> str:
    """A path as the journal has it: it stays true when all the folders are moved together."""
    try:
        return os.path.relpath(path, main)
    except ValueError:  # another drive
        return str(path)


def _absolute(path: str, main: Path) -> Path:
    return Path(os.path.normpath(main / path))

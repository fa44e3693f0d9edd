"""Outputs that replace older files all together or not at all, whatever ends the process."""

from __future__ import annotations

import contextlib
import os
import signal
import stat
import threading
from collections.abc import Callable, Generator, Iterable
from pathlib import Path
from types import FrameType, TracebackType
from typing import Any, BinaryIO

from .errors import InputError
from .files import check_target, explained, followed
from .staging import Change, StagingFolder, complete, recover, sync_folder, write_journal

_LONGEST_SUFFIX = 16


class Transaction:
    """Files that are written beside their targets first and take their names together at the end.

    As a context manager it commits where the block ends well, and leaves everything as it was where it does not. A
    process that is killed leaves the old files, or the new ones once the next run over the same targets has begun: that
    completes or undoes the change (`recover`).

    A target keeps its mode. Where it is a link, the file that it leads to is replaced. A file with several names (hard
    links) is replaced under the target's name alone; its other names keep the older content.

    Args:
        inputs: files and folders that must not be overwritten.
    """

    def __init__(self, inputs: Iterable[str | os.PathLike[str]] = ()) -> None:
        self._inputs = [followed(path) for path in inputs]
        self._folders: dict[Path, StagingFolder] = {}
        self._files: dict[Path, tuple[Path, str]] = {}
        """The new file of each target, and what the target was called."""
        self._made: list[Path] = []
        self._afterwards: list[Callable[[], object]] = []
        self.committed = False

    def __enter__(self) -> Transaction:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if kind is None:
                self.commit()
        finally:
            self._remove_folders()

    def check(self, path: str | os.PathLike[str]) -> Path:
        """Where `path` leads, after a look at whether it can be written and is no input.

        What an earlier run left half done there is ended first.

        Raises:
            InputError: it cannot be written, or would overwrite an input.
        """
        target = followed(path)
        if any(target.is_relative_to(folder) for folder in self._made):
            return target
        recover(target.parent)
        target = check_target(path)
        for known in self._inputs:
            if _is_same(target, known) or (known.is_dir() and target.is_relative_to(known)):
                raise InputError(f"{path}: is one of the files to read; write to another one")
        return target

    def folder(self, path: str | os.PathLike[str]) -> None:
        """Have a folder made at the end where it is missing, with those above it.

        Raises:
            InputError: there is a file of that name.
        """
        missing: list[Path] = []
        folder = followed(path)
        with explained(path):
            while not folder.exists():
                missing.append(folder)
                folder = folder.parent
        if not folder.is_dir():
            raise InputError(f"{path}: {folder} is a file; choose another folder")
        self._made += [made for made in reversed(missing) if made not in self._made]

    @contextlib.contextmanager
    def staging(self, path: str | os.PathLike[str]) -> Generator[Path]:
        """The path at which to write the new file, complete when the block ends.

        It has the suffix of `path` but another, short name, and nothing is there yet.

        Raises:
            InputError: it cannot be written, or would overwrite an input.
        """
        target = self.check(path)
        with explained(path):
            suffix = target.suffix if len(target.suffix) <= _LONGEST_SUFFIX else ""
            new = self._folder_for(target).path / f"new-{len(self._files)}{suffix}"
            yield new
            with new.open("r+b") as file:
                os.fsync(file.fileno())
            if target.exists():
                new.chmod(stat.S_IMODE(target.stat().st_mode) & 0o777)
        if target in self._files:
            self._files[target][0].unlink()
        self._files[target] = new, str(path)

    def write(self, path: str | os.PathLike[str], writer: Callable[[BinaryIO], object]) -> None:
        """Write a new file by a function that is given it open.

        Raises:
            InputError: it cannot be written, or would overwrite an input.
        """
        with self.staging(path) as new, new.open("xb") as file:
            writer(file)

    def sizes(self) -> dict[str, int]:
        """Bytes of each new file so far, by what its target was called."""
        return {name: new.stat().st_size for new, name in self._files.values()}

    def afterwards(self, call: Callable[[], object]) -> None:
        """Have a function called once all files are in place."""
        self._afterwards.append(call)

    def commit(self) -> None:
        """Give all files their names; InputError, and all as it was, where one cannot get its own."""
        if self._files:
            main = next(iter(self._folders.values())).path
            changes = [Change(new, target, target.exists()) for target, (new, _) in self._files.items()]
            first, *more = [name for _, name in self._files.values()]
            with explained(f"{first} (and {len(more)} more)" if more else first), _undisturbed():
                for folder in self._folders.values():
                    sync_folder(folder.path)
                write_journal(main, changes, self._made)
                complete(main, changes, self._made)
                self.committed = True
        self.committed = True
        for call in self._afterwards:
            call()

    def _folder_for(self, target: Path) -> StagingFolder:
        """The staging folder beside a target, or beside the folder to be made that will hold it."""
        parent = target.parent
        while parent in self._made:
            parent = parent.parent
        if parent not in self._folders:
            main = next(iter(self._folders.values()), None)
            self._folders[parent] = StagingFolder(parent, None if main is None else main.path)
        return self._folders[parent]

    def _remove_folders(self) -> None:
        # the main one last: the others lead to it
        for folder in reversed(self._folders.values()):
            if next(iter(self._folders.values())).has_journal:
                folder.release()  # what could not be undone now is for the next run
            else:
                folder.remove()
        self._folders.clear()
        self._files.clear()


@contextlib.contextmanager
def joined(outputs: Transaction | None) -> Generator[Transaction]:
    """The transaction given, or one of its own that ends with the block."""
    if outputs is not None:
        yield outputs
        return
    with Transaction() as own:
        yield own


def write_atomically(
    path: str | os.PathLike[str], writer: Callable[[BinaryIO], object], outputs: Transaction | None = None
) -> None:
    """Write a file so that its name never stands for half of it.

    Args:
        path: the file to write; its folder must exist.
        writer: called once with the open file.
        outputs: the transaction that the file is part of; None to replace it at once.

    Raises:
        InputError: the folder is missing or cannot be written to, `path` is a folder, or the disk is full.
    """
    with joined(outputs) as transaction:
        transaction.write(path, writer)


def _is_same(path: Path, other: Path) -> bool:
    if path == other:
        return True
    try:
        return path.samefile(other)  # where the file system does not tell cases apart
    except OSError:
        return False


@contextlib.contextmanager
def _undisturbed() -> Generator[None]:
    """Have Ctrl-C and SIGTERM wait until the block is done."""
    if threading.current_thread() is not threading.main_thread():
        yield  # signals reach the main thread alone
        return
    came: list[int] = []

    def note(number: int, _: FrameType | None) -> None:
        came.append(number)

    kept: dict[int, Any] = {}
    try:
        for number in (signal.SIGINT, signal.SIGTERM):
            handler = signal.getsignal(number)
            if handler is not None:  # one that was not set from Python cannot be put back
                kept[number] = handler
                signal.signal(number, note)
        yield
    finally:
        for number, handler in kept.items():
            signal.signal(number, handler)
        for number in came:
            signal.raise_signal(number)

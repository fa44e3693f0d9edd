"""Standard output and error that may be closed or full, and signals that end a verb."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import threading
from collections.abc import Generator
from types import FrameType
from typing import Any, TextIO

from ..core.errors import InputError


class _Forgiving:
    """A stream that swallows what nobody can take any more: what is said to people must not cost a file."""

    def __init__(self, stream: TextIO) -> None:
        self.stream = stream

    def write(self, text: str) -> int:
        """As the stream does."""
        try:
            return self.stream.write(text)
        except OSError:
            self._give_up()
            return len(text)

    def flush(self) -> None:
        """As the stream does."""
        try:
            self.stream.flush()
        except OSError:
            self._give_up()

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)

    def _give_up(self) -> None:
        with contextlib.suppress(OSError, ValueError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self.stream.fileno())
            os.close(nowhere)


@contextlib.contextmanager
def forgiving_streams() -> Generator[None]:
    """While it lasts, a closed pipe or a full disk behind standard output or error is no fault."""
    kept = sys.stdout, sys.stderr
    out, error = (None if stream is None else _Forgiving(stream) for stream in kept)
    sys.stdout, sys.stderr = out, error  # pyright: ignore[reportAttributeAccessIssue]
    try:
        yield
    finally:
        for stream in (out, error):
            if stream is not None:
                stream.flush()
        sys.stdout, sys.stderr = kept


def send(text: str) -> None:
    """Write a report to standard output.

    Raises:
        InputError: it cannot be written; that nobody wants to read it any more is no fault.
    """
    stream = getattr(sys.stdout, "stream", sys.stdout)
    try:
        stream.write(text)
        stream.flush()
    except BrokenPipeError:
        sys.stdout.flush()  # which gives up
    except OSError as error:
        raise InputError(
            f"standard output: cannot be written ({error.strerror or error}); send it elsewhere"
        ) from error


@contextlib.contextmanager
def quiet_stdout(wanted: bool) -> Generator[None]:
    """While it lasts, and if `wanted`, whatever Blender prints goes to standard error, not into a report."""
    if not wanted:
        yield
        return
    sys.stdout.flush()
    kept = os.dup(1)
    os.dup2(2, 1)
    try:
        yield
    finally:
        sys.stdout.flush()
        os.dup2(kept, 1)
        os.close(kept)


@contextlib.contextmanager
def ended_by_sigterm() -> Generator[None]:
    """While it lasts, SIGTERM ends the work as Ctrl-C does, where nobody else handles it."""
    mine = threading.current_thread() is threading.main_thread()
    if not mine or signal.getsignal(signal.SIGTERM) is not signal.SIG_DFL:
        yield
        return

    def end(_: int, __: FrameType | None) -> None:
        raise KeyboardInterrupt

    signal.signal(signal.SIGTERM, end)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)

"""What Blender objects to, as one line for people."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Generator

from ..core.errors import InputError


@contextlib.contextmanager
def writing(path: str | os.PathLike[str]) -> Generator[None]:
    """What Blender objects to in writing `path`, as an InputError; the bugs of an exporter stay what they are."""
    try:
        yield
    except RuntimeError as error:
        reason = first_line(error)
        if "Traceback" in str(error):
            reason = str(error).strip().splitlines()[-1]
            kind = reason.partition(":")[0]
            if kind not in _OF_THE_SYSTEM:
                raise
            reason = reason.removeprefix(f"{kind}: ")
        raise InputError(
            f"{path}: Blender cannot write it ({reason}); free the place or choose another"
        ) from error


def first_line(error: BaseException) -> str:
    """The first line of what Blender says, without "Error: "."""
    lines = str(error).strip().splitlines()
    return lines[0].removeprefix("Error: ") if lines else type(error).__name__


_OF_THE_SYSTEM = {"OSError", "PermissionError", "FileNotFoundError", "BlockingIOError", "TimeoutError"}
"""Errors that a full or forbidden place ends in."""

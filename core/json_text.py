"""JSON from anywhere: presets, recordings, reports, and the descriptions inside other files."""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Iterator
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from .bounds import JSON_BYTES, JSON_DEPTH, JSON_DIGITS
from .errors import FaultError, InputError
from .files import first_bytes

_CHUNK = 1 << 20
_STEPS = np.zeros(256, np.int8)
_STEPS[np.frombuffer(b"[{", np.uint8)] = 1
_STEPS[np.frombuffer(b"]}", np.uint8)] = -1
_TEXT = re.compile(rb'"(?:[^"\\]|\\.)*+(?:"|\Z)', re.DOTALL)
_HALF = re.compile(rb"\\u[dD][89a-fA-F]")
"""Of a letter that JSON writes as two."""


def parse_json(content: bytes, most: int = JSON_BYTES, *, small: bool = True) -> Any:
    """The value of a JSON text.

    Args:
        content: UTF-8, with or without a mark at its start.
        most: bytes at most.
        small: whether keys that stand twice, and numbers too large to be one, are looked for, too; slow.

    Raises:
        FaultError: it is longer, no JSON, or JSON that no program writes; says what and where possible the line.
    """
    if len(content) > most:
        raise FaultError(f"larger than {max(most // 1_000_000, 1)} MB")
    _check_size(content)
    try:
        value = json.loads(
            content.decode("utf-8-sig"),
            object_pairs_hook=_without_repeats if small else None,
            parse_float=_finite if small else None,
            parse_constant=_refuse_constant,
        )
        if _HALF.search(content):
            json.dumps(value, ensure_ascii=False).encode()
    except UnicodeEncodeError:
        raise FaultError("broken JSON (half of a letter, which cannot be shown)") from None
    except UnicodeDecodeError:
        raise FaultError("not UTF-8 text") from None
    except json.JSONDecodeError as error:
        raise FaultError(f"line {error.lineno}: broken JSON ({error.msg})") from None
    except (RecursionError, MemoryError):
        raise FaultError("lists nested too deeply") from None
    except ValueError as error:
        raise FaultError(f"broken JSON ({error})") from None
    return value


def read_json(path: str | os.PathLike[str], what: str, most: int = JSON_BYTES) -> Any:
    """The value of a small JSON file.

    Args:
        path: the file.
        what: what it should be, for messages, such as "bone map".
        most: bytes at most.

    Raises:
        InputError: it cannot be read or is larger.
        FaultError: it is no JSON; says what and where.
    """
    if not os.path.isfile(path):  # noqa: PTH113 - Path.is_file raises where a name is too long
        raise InputError(f"{path}: not a file; a {what} is a JSON file")
    content = first_bytes(path, most)
    if len(content) > most:
        raise InputError(f"{path}: larger than {most // 1_000_000} MB; no {what} is")
    return parse_json(content, most)


def to_json(value: Any, indent: int | None = None, *, sort_keys: bool = False) -> str:
    """A value as JSON text; what is no letter in names of files becomes "?".

    Raises:
        ValueError: a number in it is NaN or infinite, which JSON does not know; says where it is.
    """
    try:
        text = json.dumps(value, indent=indent, sort_keys=sort_keys, ensure_ascii=False, allow_nan=False)
    except ValueError:
        where = next(_not_finite(value, ""), None)
        if where is None:
            raise
        raise ValueError(f"{where} is not finite: JSON has no such number") from None
    return text.encode(errors="replace").decode()


def _not_finite(value: Any, where: str) -> Iterator[str]:
    """The places of all numbers that are NaN or infinite."""
    if isinstance(value, dict):
        for key, item in cast("dict[Any, Any]", value).items():
            yield from _not_finite(item, f"{where}.{key}" if where else str(key))
    elif isinstance(value, (list, tuple)):
        for number, item in enumerate(cast("list[Any]", value)):
            yield from _not_finite(item, f"{where}[{number}]")
    elif isinstance(value, float) and not math.isfinite(value):
        yield where or "the value"


def _check_size(content: bytes) -> None:
    """Refuse what would make the parser go too deep, or take too long over one number."""
    if _within(content):
        return
    # brackets and digits in texts do no harm
    bare = _TEXT.sub(b'""', content)
    if max(_depths(bare), default=0) > JSON_DEPTH:
        raise FaultError("lists nested too deeply")
    if max(_runs(bare), default=0) > JSON_DIGITS:
        raise FaultError(f"broken JSON (a number of more than {JSON_DIGITS} digits)")


def _within(content: bytes) -> bool:
    return max(_depths(content), default=0) <= JSON_DEPTH and max(_runs(content), default=0) <= JSON_DIGITS


def _chunks(content: bytes) -> Iterator[NDArray[np.uint8]]:
    values = np.frombuffer(content, np.uint8)
    return (values[start : start + _CHUNK] for start in range(0, len(values), _CHUNK))


def _depths(content: bytes) -> Iterator[int]:
    """The greatest depth of brackets in each piece of a text."""
    depth = 0
    for chunk in _chunks(content):
        depths = np.cumsum(_STEPS[chunk], dtype=np.int32)
        yield depth + int(depths.max())
        depth += int(depths[-1])


def _runs(content: bytes) -> Iterator[int]:
    """The longest run of digits that ends in each piece of a text."""
    run = 0
    for chunk in _chunks(content):
        others = np.flatnonzero((chunk < ord("0")) | (chunk > ord("9")))
        if len(others) == 0:
            run += len(chunk)
            yield run
            continue
        inner = int(np.diff(others).max()) - 1 if len(others) > 1 else 0
        yield max(run + int(others[0]), inner)
        run = len(chunk) - 1 - int(others[-1])
    yield run


def _without_repeats(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in pairs:
        if key in found:
            raise ValueError(f"{key!r} stands twice in one object")
        found[key] = value
    return found


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text[:20]} is larger than any number here")
    return value


def _refuse_constant(name: str) -> Any:
    raise ValueError(f"{name} is no JSON value")

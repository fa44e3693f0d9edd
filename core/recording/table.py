"""Text tables of numbers: a header line of column names, then one row a sample."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from .recording import Array


def decode(content: bytes, file: str) -> list[str]:
    """The lines of a UTF-8 text file; InputError with the line that is not text."""
    try:
        return content.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise InputError(f"{file}: line {line}: not UTF-8 text; save the table as UTF-8") from None


def columns_of(line: str) -> list[str]:
    """The column names of a header line."""
    return [name.strip().strip('"') for name in line.split(",")]


def read_columns(
    lines: Sequence[str], header: int, wanted: Sequence[str], file: str
) -> tuple[Array, NDArray[np.intp]]:
    """The wanted columns of every row as `(N, len(wanted))`, and each row's line number in the file.

    Empty cells are NaN; columns that are not wanted may hold anything.

    Args:
        lines: all lines of the file.
        header: index in `lines` of the line with the column names.
        wanted: column names.
        file: its name, for messages.

    Raises:
        InputError: a missing column, a short or long row, a cell that is no number, no rows; with the line
            number.
    """
    names = columns_of(lines[header])
    missing = [name for name in wanted if name not in names]
    if missing:
        raise InputError(
            f"{file}: line {header + 1}: no column {missing[0]!r}; the table needs {', '.join(wanted)}"
        )
    numbers = [i for i in range(header + 1, len(lines)) if lines[i].strip()]
    if not numbers:
        raise InputError(f"{file}: line {header + 1}: the table ends after its header; nothing was recorded")
    rows = [lines[i] for i in numbers]
    places = [names.index(name) for name in wanted]
    for row, i in zip(rows, numbers, strict=True):
        if row.count(",") + 1 != len(names):
            raise InputError(
                f"{file}: line {i + 1}: {row.count(',') + 1} cells for {len(names)} columns; "
                "complete or remove the line"
            )
    try:
        values = np.loadtxt(rows, delimiter=",", usecols=places, comments=None, ndmin=2)
    except ValueError:
        # slow, and only for tables with empty cells or with a fault to be named
        values = np.array(
            [_numbers(row, places, f"{file}: line {i + 1}") for row, i in zip(rows, numbers, strict=True)]
        )
    return values, np.array(numbers) + 1


def _numbers(row: str, places: Sequence[int], where: str) -> list[float]:
    cells = row.split(",")
    out: list[float] = []
    for place in places:
        cell = cells[place].strip()
        try:
            out.append(float(cell) if cell else math.nan)
        except ValueError:
            raise InputError(f"{where}: {cell!r} is not a number; correct or remove the line") from None
    return out

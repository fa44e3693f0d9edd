"""Where a table's names and rows are among all that recorders write above, between and below them."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

from .meaning import DEGREES, METRES, SECONDS

_LOOKED_AT = 60
"""Lines above a table that may be of something else."""
_NUMBER = re.compile(r"[-+]?(?:[\d.,'\u2019\u00a0 ]*\d[.,]?(?:[eE][-+]?\d+)?|nan|inf)", re.IGNORECASE)
_DIGITS = r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?"
_VECTOR = re.compile(rf"\w*[\[({{]\s*({_DIGITS}(?:[\s,;]+{_DIGITS}){{1,15}})\s*[\])}}]")
_THREE = rf"\(\s*{_DIGITS}\s*,\s*{_DIGITS}\s*,\s*{_DIGITS}\s*\)"
_AXES = re.compile(rf"\[X:\s*{_THREE},\s*Y:\s*{_THREE},\s*Z:\s*{_THREE},\s*O:\s*{_THREE}\]")
"""A transform as Godot prints it, by columns."""
_TYPES = frozenset(
    ("float", "int", "double", "string", "str", "number", "float32", "float64", "int64", "bool")
)
_NO_UNITS = frozenset(("", "-", "1", "quat", "quaternion", "unitless", "none", "n/a"))


def is_number(cell: str) -> bool:
    """Whether a cell holds a number, in whatever way it is written."""
    return _NUMBER.fullmatch(cell.strip()) is not None


def tidied(
    lines: list[str], cells_of: Callable[[str], Sequence[str]], comments: tuple[str, ...]
) -> list[str]:
    """Lines with all but a table's names and rows left empty; those of no table as they are.

    Names in two rows are joined, units below names are put behind them.

    Args:
        lines: of a file.
        cells_of: a line's cells.
        comments: what lines begin with that hold neither.
    """
    first = _first_row(lines, cells_of)
    if first < 0:
        return lines
    width = len(cells_of(lines[first]))
    above = [
        number
        for number in range(first - 1, max(first - 6, -1), -1)
        if lines[number].strip()
        and not lines[number].lstrip().startswith(comments)
        and abs(len(cells_of(lines[number])) - width) <= 1
    ]
    out = [
        "" if number < first and not line.lstrip().startswith("#") else line
        for number, line in enumerate(lines)
    ]
    if above:
        names, place = _names([list(cells_of(lines[number])) for number in above[:3]], above)
        out[place] = names if names else lines[place]
        header = lines[above[0]].strip()
        for number in range(first, len(out)):
            if out[number].strip() == header:
                out[number] = ""
    return _without_totals(out, first, width, cells_of)


def _first_row(lines: Sequence[str], cells_of: Callable[[str], Sequence[str]]) -> int:
    """Index of the first of two lines alike that hold mostly numbers; -1 for none."""
    before = -1
    seen = 0
    for number, line in enumerate(lines):
        if not line.strip():
            continue
        seen += 1
        cells = cells_of(line)
        count = sum(is_number(cell) or cell.strip()[:1] in "[(" for cell in cells if cell.strip())
        filled = sum(bool(cell.strip()) for cell in cells)
        if len(cells) >= 4 and filled > 2 and count >= 0.6 * filled:
            if before >= 0 and len(cells_of(lines[before])) == len(cells):
                return before
            before = number
        else:
            before = -1
        if seen > _LOOKED_AT:
            return -1
    return -1


def _names(rows: list[list[str]], places: list[int]) -> tuple[str, int]:
    """The line of names that one to three rows above a table make, "" for the row itself, and which line that is."""
    units = [cell.strip().strip("[]()").lower() for cell in rows[0]]
    known = {*METRES, *DEGREES, *SECONDS, *_TYPES, *_NO_UNITS}
    if len(rows) > 1 and all(unit in known for unit in units) and any(units):
        named = [
            f"{name.strip()} ({unit})" if unit in {*METRES, *DEGREES, *SECONDS} else name.strip()
            for name, unit in zip(rows[1], [*units, ""], strict=False)
        ]
        return "\x1f".join(named), places[1]
    if len(rows) > 1 and places[0] - places[1] == 1 and len(set(units)) < len(units):
        groups: list[str] = []
        for cell in rows[1]:
            groups.append(cell.strip() or (groups[-1] if groups else ""))
        groups += groups[-1:] * (len(rows[0]) - len(groups))
        joined = [f"{group} {name.strip()}".strip() for group, name in zip(groups, rows[0], strict=False)]
        return "\x1f".join(joined), places[0]
    return "", places[0]


def _without_totals(
    lines: list[str], first: int, width: int, cells_of: Callable[[str], Sequence[str]]
) -> list[str]:
    """Lines without those of words that follow a table's last row."""
    numeric = is_number(cells_of(lines[first])[0])
    for number in range(len(lines) - 1, first + 1, -1):
        if not lines[number].strip():
            continue
        cells = cells_of(lines[number])
        word = not is_number(cells[0])
        if not word or (len(cells) == width and not numeric) or not re.search(r"[A-Za-z]", cells[0]):
            break
        lines[number] = ""
    return lines


def spread(cell: str) -> list[tuple[str, str]]:
    """The numbers of a vector or of Godot's transforms in one cell, each with its place in it; empty for others."""
    found = _VECTOR.fullmatch(cell.strip())
    if found:
        values = re.split(r"[\s,;]+", found[1])
        if len(values) == 12 and cell.lstrip()[:9] == "Transform":
            names = [f"basis.{r}{c}" for r in range(3) for c in range(3)] + [
                "origin.x",
                "origin.y",
                "origin.z",
            ]
            return list(zip(names, values, strict=True))
        return [(str(place), value) for place, value in enumerate(values)]
    found = _AXES.fullmatch(cell.strip())
    if not found:
        return []
    values = re.findall(_DIGITS, cell)
    names = [f"basis.{r}{c}" for c in range(3) for r in range(3)] + ["origin.x", "origin.y", "origin.z"]
    return list(zip(names, values, strict=True))

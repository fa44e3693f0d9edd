"""Text tables in any dress: compressed, in other encodings, with other separators, decimal commas, quotes, comments."""

from __future__ import annotations

import codecs
import csv
import re
import zlib

from ...bounds import RECORDING_BYTES
from ...errors import InputError

_GZIP = b"\x1f\x8b"
_UTF16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
COMMENT = ("#", "//", "%")
_DECIMAL_COMMA = re.compile(r"\s*[-+]?\d*,\d+(?:[eE][-+]?\d+)?\s*")
_VECTOR = re.compile(r"[\[({]\s*([-+0-9.eE]+(?:[\s,;]+[-+0-9.eE]+){2,15})\s*[\])}]")
_EMPTY = frozenset(
    ("-nan(ind)", "-nan", "1.#qnan", "-1.#ind", "null", "none", "nan", "n/a", "na", "-", "undefined")
)
_LOOKED_AT = 65536
"""Bytes that tell how a table is written."""
LEAST_COLUMNS = 7


def unpacked(content: bytes, file: str) -> bytes:
    """What a file holds: gzip is unpacked, UTF-16 becomes UTF-8; anything else is returned as it is.

    Raises:
        InputError: it is damaged, or larger unpacked than any recording.
    """
    if content.startswith(_GZIP):
        unpacker = zlib.decompressobj(wbits=31)
        try:
            content = unpacker.decompress(content, RECORDING_BYTES + 1)
        except zlib.error:
            raise InputError(f"{file}: its compression is damaged; copy it again") from None
        if len(content) > RECORDING_BYTES:
            raise InputError(
                f"{file}: larger than {RECORDING_BYTES // 1_000_000} MB unpacked; cut the recording"
            )
        if not unpacker.eof:
            raise InputError(f"{file}: its compression breaks off; copy it again")
    mark = _unmarked(content[:400])
    content = mark + content
    if content.startswith(_UTF16):
        try:
            return content.decode("utf-16").encode()
        except UnicodeError:
            raise InputError(f"{file}: not UTF-16 text, though it begins so; save it as UTF-8") from None
    return content


def _unmarked(start: bytes) -> bytes:
    """The mark of UTF-16 that a text in it lacks; nothing for anything else."""
    if len(start) < 40 or start.startswith(_UTF16):
        return b""
    for mark, letters, blanks in ((_UTF16[0], start[::2], start[1::2]), (_UTF16[1], start[1::2], start[::2])):
        if not any(blanks) and all(9 <= letter < 127 for letter in letters):
            return mark
    return b""


def header_line(lines: list[str]) -> int:
    """Index of the first line that is neither empty nor a comment; 0 where there is none."""
    for number, line in enumerate(lines):
        if line.strip() and not line.lstrip().startswith(COMMENT):
            return number
    return 0


def plain_table(content: bytes) -> bytes:
    """A table with commas between cells, decimal points, and neither quotes, vectors in a cell nor empty last cells.

    Line numbers stay as they are. What is no table, or is written so already, is returned as it is.
    """
    head = content[:_LOOKED_AT].removeprefix(codecs.BOM_UTF8)
    if head.lstrip()[:1] in (b"{", b"[") or b"\0" in head:
        return content
    lines = head.decode("utf-8", "replace").splitlines()
    if not lines:
        return content
    start = header_line(lines)
    separator = _separator(lines[start])
    if not separator or (separator == "," and not _is_odd(lines, start)):
        return content
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content
    lines = text.splitlines()
    widths = _widths(lines, start, separator)
    out = [
        line
        if number < start or not line.strip() or line.lstrip().startswith(COMMENT)
        else _plain(line, separator, widths, number == start)
        for number, line in enumerate(lines)
    ]
    return ("\n".join(out) + "\n").encode()


def _separator(header: str) -> str:
    """What stands between a table's cells, "" where the line is none."""
    found = max(",;\t|", key=header.count)
    if header.count(found) + 1 >= LEAST_COLUMNS or '"' in header or _VECTOR.search(header):
        return found if header.count(found) else ""
    if header.count(found) >= 2:
        return found
    return " " if len(header.split()) >= LEAST_COLUMNS else ""


def _is_odd(lines: list[str], start: int) -> bool:
    """Whether a table with commas is written in an unusual way."""
    rows = [line for line in lines[start:-1] or lines[start:] if line.strip()]
    names = rows[0].count(",")
    ragged = rows[0].rstrip().endswith(",") or any(
        row.rstrip().endswith(",") and row.count(",") > names for row in rows[1:3]
    )
    words = (
        any(cell.strip().lower() in _EMPTY for row in rows[1:] for cell in row.split(","))
        if len(rows) > 1
        else False
    )
    return ragged or words or any('"' in row or "(" in row or "[" in row for row in rows[:3])


def _cells(line: str, separator: str) -> list[str]:
    if separator == " ":
        return line.split()
    if '"' not in line:
        return line.split(separator)
    return next(csv.reader([line], delimiter=separator), list[str]())


def _widths(lines: list[str], start: int, separator: str) -> list[int]:
    """How many numbers each column's cells hold: more than 1 for vectors."""
    row = next(
        (line for line in lines[start + 1 :] if line.strip() and not line.lstrip().startswith(COMMENT)), ""
    )
    return [len(_vector(cell)) or 1 for cell in _cells(row, separator)]


def _vector(cell: str) -> list[str]:
    found = _VECTOR.fullmatch(cell.strip())
    return re.split(r"[\s,;]+", found[1]) if found else []


def _plain(line: str, separator: str, widths: list[int], header: bool) -> str:
    cells = _cells(line, separator)
    while cells and not cells[-1].strip() and len(cells) > 1:
        cells.pop()
    out: list[str] = []
    for number, cell in enumerate(cells):
        width = widths[number] if number < len(widths) else 1
        if width > 1:
            values = [f"{cell.strip()}.{part}" for part in range(width)] if header else _vector(cell)
            out += values or [""] * width
            continue
        cell = cell.strip()
        if separator != "," and _DECIMAL_COMMA.fullmatch(cell):
            cell = cell.replace(",", ".")
        out.append("" if cell.lower() in _EMPTY else cell.replace(",", " "))
    return ",".join(out)

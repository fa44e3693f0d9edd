"""Text tables in any dress: compressed, in other encodings, with other separators, decimal commas, quotes, comments."""

from __future__ import annotations

import codecs
import csv
import re
import zlib

from ...bounds import RECORDING_BYTES
from ...errors import InputError
from .rows import spread, tidied

_GZIP = b"\x1f\x8b"
_UTF16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
COMMENT = ("#", "//", "%")
_DECIMAL_COMMA = re.compile(r"\s*[-+]?\d*,\d+(?:[eE][-+]?\d+)?\s*")
_JSON = re.compile(rb"\s*(?:\{|\[\s*[\[{\"\-\d\]])")
_BRACKETS = re.compile(r"[\[({][^\])}]*[\])}]")
_OWN = b"# footwork-recording "
_THOUSANDS = re.compile(r"[-+]?\d{1,3}(?:(?P<mark>[,.'\u2019 \u00a0\u202f])\d{3})+(?:(?!(?P=mark))[.,]\d+)?")
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
    content = content.rstrip(b"\0\x1a") if content[-1:] in (b"\0", b"\x1a") and is_text(content) else content
    mark = _unmarked(content[:400])
    content = mark + content
    if content.startswith(_UTF16):
        try:
            return content.decode("utf-16").encode()
        except UnicodeError:
            raise InputError(f"{file}: not UTF-16 text, though it begins so; save it as UTF-8") from None
    if is_text(content):
        try:
            content.decode()
        except UnicodeDecodeError:
            # whatever Western code page it is: the names that count are alike in all
            return content.decode("cp1252", "replace").encode()
    return content


def is_text(content: bytes) -> bool:
    """Whether a file begins as text in some one-byte code or UTF-8."""
    head = content[:_LOOKED_AT].rstrip(b"\0\x1a")
    return (
        len(head) > 0
        and not content.startswith(_UTF16)
        and not any(byte < 9 or 13 < byte < 27 for byte in head[:4096])
    )


def is_json(content: bytes) -> bool:
    """Whether a file begins as JSON does."""
    return _JSON.match(content[:_LOOKED_AT].removeprefix(codecs.BOM_UTF8)) is not None


def _unmarked(start: bytes) -> bytes:
    """The mark of UTF-16 that a text in it lacks; nothing for anything else."""
    if len(start) < 40 or start.startswith(_UTF16):
        return b""
    for mark, letters, blanks in ((_UTF16[0], start[::2], start[1::2]), (_UTF16[1], start[1::2], start[::2])):
        if blanks.count(0) > 0.9 * len(blanks) and all(letter >= 9 for letter in letters):
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
    if is_json(head) or b"\0" in head or head.startswith(_OWN):
        return content
    lines = head.decode("utf-8", "replace").splitlines()
    if not lines:
        return content
    separator = _separator_of(lines)
    if not separator:
        return content
    start = header_line(lines)
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content
    before = text.splitlines()
    lines = tidied(before, lambda line: _cells(line, separator), COMMENT)
    start = header_line(lines)
    if separator == "," and lines == before and not _is_odd(lines, start):
        return content
    widths = _widths(lines, start, separator)
    mark = _thousands(lines[start + 1 : start + 400], separator)
    out = [
        line
        if number < start or not line.strip() or line.lstrip().startswith(COMMENT)
        else _plain(line, separator, widths, mark, number == start)
        for number, line in enumerate(lines)
    ]
    return ("\n".join(out) + "\n").encode()


def _separator_of(lines: list[str]) -> str:
    """What stands between the cells of the table among lines; "" for none."""
    start = header_line(lines)
    named = re.fullmatch(r"sep=(.)", lines[start].strip())
    if named:
        return named[1]
    found = [_separator(line) for line in lines[start : start + 40] if line.strip()]
    # rows are many, what stands above them is not
    counts = {separator: found.count(separator) for separator in found if separator}
    return max(counts, key=lambda separator: counts[separator], default="")


def _thousands(rows: list[str], separator: str) -> str:
    """What stands between the thousands of a table's numbers; "" for nothing."""
    marks: dict[str, int] = {}
    for row in rows:
        for cell in _cells(row, separator):
            found = _THOUSANDS.fullmatch(cell.strip())
            # one group may as well be a fraction
            if found and (
                found[0].count(found["mark"]) > 1 or found["mark"] not in ",." or _has_both(found[0])
            ):
                marks[found["mark"]] = marks.get(found["mark"], 0) + 1
    return max(marks, key=lambda mark: marks[mark], default="")


def _has_both(number: str) -> bool:
    return "," in number and "." in number


def _separator(header: str) -> str:
    """What stands between a table's cells, "" where the line is none."""
    vectors = "(" in header or "[" in header
    header = _BRACKETS.sub("", header)
    # decimal commas are as many as what stands between them
    found = max(
        "\t;|,",
        key=lambda mark: (mark != "," and header.count(mark) + 1 >= LEAST_COLUMNS, header.count(mark)),
    )
    if header.count(found) + 1 >= LEAST_COLUMNS or '"' in header or vectors:
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
    if "\x1f" in line:
        return line.split("\x1f")
    if '"' not in line:
        return line.split(separator)
    return next(csv.reader([line], delimiter=separator), list[str]())


def _widths(lines: list[str], start: int, separator: str) -> list[list[str]]:
    """The places of the numbers in each column's cells: more than one for vectors."""
    row = next(
        (line for line in lines[start + 1 :] if line.strip() and not line.lstrip().startswith(COMMENT)), ""
    )
    return [[place for place, _ in spread(cell)] for cell in _cells(row, separator)]


def _spread(cell: str, places: list[str], header: bool) -> list[tuple[str, str]]:
    return [(place, "") for place in places] if header else spread(cell)


def _plain(line: str, separator: str, widths: list[list[str]], mark: str, header: bool) -> str:
    cells = _cells(line, separator)
    while cells and not cells[-1].strip() and len(cells) > 1:
        cells.pop()
    out: list[str] = []
    for number, cell in enumerate(cells):
        places = widths[number] if number < len(widths) else []
        if places:
            values = [
                f"{cell.strip()}.{place}" if header else text for place, text in _spread(cell, places, header)
            ]
            out += values if len(values) == len(places) else [""] * len(places)
            continue
        cell = cell.strip()
        if mark and _THOUSANDS.fullmatch(cell):
            cell = cell.replace(mark, "")
        if (separator != "," or mark == ".") and _DECIMAL_COMMA.fullmatch(cell):
            cell = cell.replace(",", ".")
        out.append("" if cell.lower() in _EMPTY else cell.replace(",", " "))
    return ",".join(out)

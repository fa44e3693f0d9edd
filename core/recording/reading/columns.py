"""Tables whose columns tell by their names what they are, wide or with one row a device; axes are left open."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ..raw import STATED, Extra, RawRecording, Reading, Track
from ..recording import TRACKERS, Array
from ..table import columns_of, decode, read_columns
from .dress import COMMENT, header_line
from .meaning import Columns, Understood, understand, whose, words_of
from .rotations import KINDS, WIDTHS

_HEADER_BYTES = 16384
NAME = "table, by the names of its columns"
_EMPTY = Track(np.empty(0), np.empty((0, 3)), np.empty((0, 4)), np.empty(0, dtype=np.bool_))
_CLOCK = re.compile(r"(?:(\d+):)?(\d{1,2}):(\d{1,2}(?:[.,]\d+)?)\s*$")
_USUAL_RATE = 72.0
_BARE = ("px", "py", "pz", "q_0", "q_1", "q_2", "q_3")
"""Columns of a tracker in a table without names."""


@dataclass(frozen=True, slots=True, eq=False)
class Sheet:
    """Rows of numbers under names."""

    names: tuple[str, ...]
    values: Array
    """`(N, C)`; NaN for what is no number."""
    texts: tuple[tuple[str, ...], ...]
    """Columns that hold texts, by index in `names`; () for the others."""
    lines: NDArray[np.intp]
    """`(N,)` line of each row in its file."""


def recognise(content: bytes) -> bool:
    """Whether a file is a table with the headset's pose in columns that tell so."""
    head = content[:_HEADER_BYTES].removeprefix(b"\xef\xbb\xbf")
    if head.lstrip()[:1] in (b"{", b"[") or b"\0" in head:
        return False
    lines = head.decode("utf-8", "replace").splitlines()
    if not lines:
        return False
    names = columns_of(lines[header_line(lines)])
    return bool(_bare_names(names)) or is_posed(understand(names))


def is_posed(found: Understood) -> bool:
    """Whether names tell of the headset's pose, in columns of its own or in rows that a device's name goes before."""
    return "head" in found.trackers or ("" in found.trackers and found.device >= 0)


def read(content: bytes, file: str) -> RawRecording:
    """Samples of such a table, in its own axes and unit.

    Raises:
        InputError: a short row, a cell that is no number, or times that do not tell seconds.
    """
    lines = decode(content, file)
    header = header_line(lines)
    names = columns_of(lines[header])
    bare = _bare_names(names)
    if bare:
        # the table's first row stands where names would
        names, lines, header = bare, [",".join(bare), *lines[header:]], 0
    found = understand(names)
    if not is_posed(found):
        raise InputError(f"{file}: line {header + 1}: no columns of a headset's position and rotation")
    lines = [
        line if number <= header or not line.lstrip().startswith(COMMENT) else ""
        for number, line in enumerate(lines)
    ]
    wanted = sorted({i for pose in found.trackers.values() for i in (*pose.place, *pose.turn)})
    values, numbers = read_columns(lines, header, [names[i] for i in wanted], file)
    whole = np.full((len(values), len(names)), np.nan)
    whole[:, wanted] = values
    texts: list[tuple[str, ...]] = [()] * len(names)
    for column in (found.time, found.number, found.device, *found.times.values()):
        if column >= 0:
            rows = [lines[int(number) - 1] for number in numbers]
            texts[column] = tuple(row.split(",")[column].strip() for row in rows)
    return to_raw(Sheet(tuple(names), whole, tuple(texts), numbers), found, file, NAME)


def to_raw(sheet: Sheet, found: Understood, file: str, name: str) -> RawRecording:
    """The samples of a sheet's trackers.

    Args:
        sheet: the rows.
        found: what its names say.
        file: its file's name, for messages.
        name: of the format.

    Raises:
        InputError: times that are none.
    """
    times, counted = _times(sheet, found, file)
    own = _own_times(sheet, found, times, file)
    tracks: dict[str, Track] = {}
    kinds: dict[str, Columns] = {}
    for tracker, pose, rows in _groups(sheet, found):
        values = sheet.values[rows]
        pose = _by_rows(pose, values)
        tracks.setdefault(
            tracker,
            Track(
                own.get(tracker, times)[rows],
                values[:, pose.place],
                values[:, pose.turn],
                np.ones(len(values), dtype=np.bool_),
            ),
        )
        kinds.setdefault(tracker, pose)
    if "head" not in tracks:
        raise InputError(f"{file}: no row tells of the headset; name it hmd or head")
    kind = kinds["head"].kind
    same = {t: track for t, track in tracks.items() if kinds[t].kind == kind}
    none = replace(_EMPTY, rotations=np.empty((0, WIDTHS[kind])))
    stated = {"sides", "unit"} if found.metres else {"sides"}
    rotation = KINDS[kind][0]
    if kind == "quaternion":
        rotation = "wxyz" if kinds["head"].ordered else "xyzw"
        stated |= {"rotation"} if kinds["head"].ordered else set()
    elif found.angles:
        rotation = rotation.replace("degrees", found.angles)
    head, left, right = (same.get(tracker, none) for tracker in TRACKERS)
    return RawRecording(
        tracks=(head, left, right),
        found={"format": name},
        reading=Reading(axes="RUF", metres=found.metres or 1.0, rotation=rotation),
        stated=frozenset(stated) & STATED,
        extra=tuple(Extra(t, track) for t, track in same.items() if t not in TRACKERS),
        counted=counted,
        doubts=tuple(
            f"there are several poses of {tracker}: the one in {sheet.names[kinds[tracker].place[0]]!r} is read"
            for tracker in found.several
            if tracker in TRACKERS
        ),
    )


def _by_rows(pose: Columns, values: Array) -> Columns:
    """The columns of a pose whose matrices are written row by row, also of those written column by column."""
    if not pose.last or not np.all(np.nan_to_num(values[:, pose.place]) == 0.0):
        return pose
    turn = [pose.turn[3 * c + r] for r in range(3) for c in range(3)]
    return replace(pose, place=pose.last, turn=turn)


def _groups(sheet: Sheet, found: Understood) -> list[tuple[str, Columns, NDArray[np.intp]]]:
    """Trackers, the columns of their poses and the rows that are theirs."""
    every = np.arange(len(sheet.values))
    if "head" in found.trackers:
        return [(tracker, pose, every) for tracker, pose in found.trackers.items() if tracker]
    devices = np.array(sheet.texts[found.device])
    groups: list[tuple[str, Columns, NDArray[np.intp]]] = []
    for device in dict.fromkeys(devices.tolist()):
        tracker = whose(words_of(device))[0]
        if tracker:
            groups.append((tracker, found.trackers[""], np.flatnonzero(devices == device)))
    return groups


def _times(sheet: Sheet, found: Understood, file: str) -> tuple[Array, bool]:
    """Seconds `(N,)` from the first sample on, or, True, the samples' numbers where there are no times."""
    if found.time < 0:
        if found.number >= 0:
            numbers = np.array([_number(text) for text in sheet.texts[found.number]])
            if np.isfinite(numbers).all():
                return numbers - (numbers[0] if len(numbers) else 0.0), True
        return np.arange(len(sheet.values), dtype=np.float64), True
    values, dated = _clock(sheet, found.time, file)
    known = values[np.isfinite(values)]
    values -= known[0] if len(known) else 0.0
    return values * (1.0 if dated else found.seconds or _unit(values, file)), False


def _own_times(sheet: Sheet, found: Understood, times: Array, file: str) -> dict[str, Array]:
    """Seconds `(N,)` of the trackers that have columns of times of their own, on the clock of `times`."""
    if not found.times or found.time < 0:
        return {}
    common, _ = _clock(sheet, found.time, file)
    span, seconds = np.nanmax(common) - np.nanmin(common), np.nanmax(times) - np.nanmin(times)
    unit = float(seconds / span) if span > 0.0 else 1.0
    return {
        tracker: times + (_clock(sheet, column, file)[0] - common) * unit
        for tracker, column in found.times.items()
    }


def _clock(sheet: Sheet, column: int, file: str) -> tuple[Array, bool]:
    """What a column of times says `(N,)`, NaN where nothing, and whether these are seconds of dates."""
    texts = sheet.texts[column]
    values, dated = np.empty(len(texts)), False
    for row, text in enumerate(texts):
        values[row] = _number(text)
        if np.isnan(values[row]) and text.strip():
            values[row], dated = _date(text, f"{file}: line {int(sheet.lines[row])}"), True
    return values, dated


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return float("nan")


def _date(text: str, where: str) -> float:
    """Seconds of a date and time in ISO 8601, or of hours, minutes and seconds."""
    clock = _CLOCK.search(text)
    if clock is not None and "-" not in text and "/" not in text:
        return 3600.0 * float(clock[1] or 0) + 60.0 * float(clock[2]) + float(clock[3])
    try:
        return datetime.fromisoformat(text.replace("Z", "+00:00")).timestamp()
    except (ValueError, OverflowError, OSError):
        raise InputError(f"{where}: {text!r} is no time; correct or remove it") from None


def _unit(values: Array, file: str) -> float:
    """Seconds in the unit of times that do not say it: recorders take 9 to 500 samples a second."""
    steps: Any = np.diff(values)
    steps = steps[steps > 0.0]
    step = float(np.median(steps)) if len(steps) else 0.0
    fitting = [unit for unit in (1.0, 1e-3, 1e-6, 1e-7, 1e-9) if 0.002 <= step * unit <= 0.115]
    if fitting:
        return min(fitting, key=lambda unit: abs(math.log(step * unit * _USUAL_RATE)))
    if step == 0.0:
        return 1.0
    raise InputError(f"{file}: its times tell no unit; call their column time_s, time_ms, time_us or time_ns")


def _bare_names(cells: Sequence[str]) -> list[str]:
    """Names for the columns of a table without any: a time or none, then three poses of seven; empty for others."""
    if len(cells) not in (21, 22) or any(np.isnan(_number(cell)) for cell in cells):
        return []
    poses = [f"{tracker}_{part}" for tracker in TRACKERS for part in _BARE]
    return (["time"] if len(cells) == 22 else []) + poses

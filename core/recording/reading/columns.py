"""Tables whose columns tell by their names what they are, wide or with one row a device; axes are left open."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...maths import quat
from ..raw import STATED, Extra, RawRecording, Reading, Track
from ..recording import TRACKERS, Array
from ..table import columns_of, decode, read_columns
from .clock import Sheet, clock_of, number, own_times
from .dress import COMMENT, LEAST_COLUMNS, header_line, is_json
from .kept import NOTHING, RecordingMap, completed, map_for
from .meaning import HANDS, Columns, Understood, understand, whose, words_of
from .rotations import KINDS, WIDTHS

_HEADER_BYTES = 16384
NAME = "table, by the names of its columns"
_EMPTY = Track(np.empty(0), np.empty((0, 3)), np.empty((0, 4)), np.empty(0, dtype=np.bool_))
_BARE = ("px", "py", "pz", "q_0", "q_1", "q_2", "q_3")
"""Columns of a tracker in a table without names."""


def recognise(content: bytes) -> bool:
    """Whether a file is a table with the headset's pose in columns that tell so."""
    head = content[:_HEADER_BYTES].removeprefix(b"\xef\xbb\xbf")
    if is_json(head) or b"\0" in head:
        return False
    lines = head.decode("utf-8", "replace").splitlines()
    if not lines:
        return False
    names = columns_of(lines[header_line(lines)])
    return bool(_bare_names(names)) or is_posed(understand(names)) or is_kept(content)


def is_kept(content: bytes) -> bool:
    """Whether a file is a table with columns of which a person has said what they are."""
    head = content[:_HEADER_BYTES].removeprefix(b"\xef\xbb\xbf")
    if is_json(head) or b"\0" in head:
        return False
    names, _, _ = named_columns(head.decode("utf-8", "replace").splitlines())
    return map_for(names) is not None


def named_columns(lines: list[str]) -> tuple[list[str], list[str], int]:
    """A table's names, its lines with the names among them, and which line that is; numbered where it has none."""
    if not lines:
        return [], lines, 0
    header = header_line(lines)
    cells = columns_of(lines[header])
    bare = _bare_names(cells)
    if not bare and len(cells) >= LEAST_COLUMNS and all(not np.isnan(number(cell)) for cell in cells):
        bare = [f"column {place}" for place in range(1, len(cells) + 1)]
    if not bare:
        return cells, lines, header
    # the table's first row stands where names would
    return bare, [",".join(bare), *lines[header:]], 0


def is_posed(found: Understood) -> bool:
    """Whether names tell of the headset's pose, in columns of its own or in rows that a device's name goes before."""
    return "head" in found.trackers or ("" in found.trackers and found.device >= 0)


def read(content: bytes, file: str, told: RecordingMap | None = None) -> RawRecording:
    """Samples of such a table, in its own axes and unit.

    Args:
        content: of the file, in plain dress.
        file: its name, for messages.
        told: what a person says of its columns; by default what is kept for them.

    Raises:
        InputError: a short row, a cell that is no number, or times that do not tell seconds.
    """
    names, lines, header = named_columns(decode(content, file))
    told = told or map_for(names)
    found = understand(names, told.said if told else None)
    if not is_posed(found):
        raise InputError(f"{file}: line {header + 1}: no columns of a headset's position and rotation")
    lines = [
        line if index <= header or not line.lstrip().startswith(COMMENT) else ""
        for index, line in enumerate(lines)
    ]
    wanted = sorted({i for pose in found.trackers.values() for i in (*pose.place, *pose.turn)})
    values, numbers = read_columns(lines, header, [names[i] for i in wanted], file)
    whole = np.full((len(values), len(names)), np.nan)
    whole[:, wanted] = values
    rows = zip(*(lines[int(line) - 1].split(",") for line in numbers), strict=True)
    texts = [
        () if column in wanted else tuple(cell.strip() for cell in cells) for column, cells in enumerate(rows)
    ]
    return to_raw(Sheet(tuple(names), whole, tuple(texts), numbers), found, file, NAME, told)


def to_raw(
    sheet: Sheet, found: Understood, file: str, name: str, told: RecordingMap | None = None
) -> RawRecording:
    """The samples of a sheet's trackers.

    Args:
        sheet: the rows.
        found: what its names say.
        file: its file's name, for messages.
        name: of the format.
        told: what a person says of its columns.

    Raises:
        InputError: times that are none.
    """
    clock = clock_of(sheet, found, file)
    own = own_times(sheet, found, clock.times, file)
    tracks: dict[str, Track] = {}
    kinds: dict[str, Columns] = {}
    for tracker, pose, rows in _groups(sheet, found, told.said if told else {}):
        values = sheet.values[rows]
        pose = _by_rows(pose, values)
        tracks.setdefault(
            tracker,
            Track(
                own.get(tracker, clock.times)[rows],
                values[:, pose.place],
                values[:, pose.turn] if pose.turn else np.tile(quat.IDENTITY, (len(values), 1)),
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
    known = {"times": clock.told, "columns": f"as kept under {told.name!r}" if told and told.name else ""}
    raw = RawRecording(
        tracks=(head, left, right),
        found={"format": name, **{key: text for key, text in known.items() if text}},
        reading=Reading(axes="RUF", metres=found.metres or 1.0, rotation=rotation),
        stated=frozenset(stated) & STATED,
        extra=tuple(
            Extra(t, track, "" if t in same else _usual(kinds[t]))
            for t, track in tracks.items()
            if t and t not in TRACKERS
        ),
        counted=clock.counted,
        doubts=tuple(
            f"there are several poses of {tracker}: the one in {sheet.names[kinds[tracker].place[0]]!r} is read"
            for tracker in found.several
            if tracker in TRACKERS
        ),
    )
    return completed(raw, told.answers) if told else raw


def _usual(pose: Columns) -> str:
    """How rotations of a kind are usually written."""
    if pose.kind == "none":
        return "wxyz"
    return "xyzw" if pose.kind == "quaternion" and not pose.ordered else KINDS[pose.kind][0]


def _by_rows(pose: Columns, values: Array) -> Columns:
    """The columns of a pose whose matrices are written row by row, also of those written column by column."""
    if not pose.last or not np.all(np.nan_to_num(values[:, pose.place]) == 0.0):
        return pose
    turn = [pose.turn[3 * c + r] for r in range(3) for c in range(3)]
    return replace(pose, place=pose.last, turn=turn)


def _groups(
    sheet: Sheet, found: Understood, said: Mapping[str, str]
) -> list[tuple[str, Columns, NDArray[np.intp]]]:
    """Trackers, the columns of their poses and the rows that are theirs."""
    every = np.arange(len(sheet.values))
    if "head" in found.trackers:
        return [(tracker, pose, every) for tracker, pose in found.trackers.items() if tracker]
    texts = list(zip(*(sheet.texts[column] for column in found.labels or [found.device]), strict=True))
    rows: dict[tuple[str, ...], list[int]] = {}
    for row, label in enumerate(texts):
        rows.setdefault(label, []).append(row)
    trackers = named(list(rows), said)
    return [
        (tracker, found.trackers[""], np.array(rows[label])) for label, tracker in trackers.items() if tracker
    ]


def named(
    labels: Sequence[tuple[str, ...]], said: Mapping[str, str] | None = None
) -> dict[tuple[str, ...], str]:
    """The trackers that rows' labels name, or that a person says they do; by elimination where one is missing."""
    out = {label: whose(words_of(" ".join(label)))[0] for label in labels}
    for label in labels:
        told = next((said[text] for text in (" ".join(label), *label) if said and text in said), "")
        if told:
            out[label] = "" if told == NOTHING else told
    if "head" in out.values() and said:
        return out
    left = [label for label, tracker in out.items() if not tracker]
    hands = [label for label in left if HANDS & set(words_of(" ".join(label)))]
    if len(hands) == 2 and not {"left", "right"} & set(out.values()):
        # which is which the movement has to tell
        out |= dict(zip(hands, ("left", "right"), strict=True))
    left = [label for label in left if label not in hands]
    if len(left) == 1 and "head" not in out.values():
        out[left[0]] = "head"
    return out


def _bare_names(cells: Sequence[str]) -> list[str]:
    """Names for the columns of a table without any: a time or none, then three poses of seven; empty for others."""
    if len(cells) not in (21, 22) or any(np.isnan(number(cell)) for cell in cells):
        return []
    poses = [f"{tracker}_{part}" for tracker in TRACKERS for part in _BARE]
    return (["time"] if len(cells) == 22 else []) + poses

"""The mapping assistant: what each column of a file was taken for, and the three poses that come of it."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import InputError
from ..maths import quat
from . import aframe, layouts
from .read import content_of, read_recording, to_recording
from .reading import columns, objects
from .reading.answers import NO_ANSWERS, Answers
from .reading.dress import is_json, plain_table, unpacked
from .reading.kept import NOTHING, RecordingMap, check_said, map_for
from .reading.meaning import ANGLES, PARTS, Columns, Understood, understand
from .reading.shapes import rows_of
from .recording import TRACKERS, Array, Recording

_LABELS_SHOWN = 24
_PARTS: Mapping[str, Sequence[str]] = {
    "quaternion": ("qw", "qx", "qy", "qz"),
    "euler": ("rx", "ry", "rz"),
    "rotator": ANGLES,
    "matrix": tuple(part for part in PARTS if part[0] == "m"),
    "none": (),
    "sixd": tuple(part for part in PARTS if part.startswith("sixd")),
}


@dataclass(frozen=True, slots=True)
class Column:
    """One column of a file, or one name of a device whose rows are its own."""

    name: str
    example: str
    """What it holds first, "" for a device."""
    said: str
    """What it was taken for, as in `kept.check_said`."""
    by: str = ""
    """"you" or "kept" where a person says so; "" where its name does."""


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """A file as the assistant shows it."""

    columns: tuple[Column, ...]
    """Empty where the file has none that could be told otherwise."""
    names: frozenset[str]
    """Of the file's columns."""
    recording: Recording | None
    fault: str
    """Why there is no recording; "" where there is."""

    def to_keep(self, name: str, said: Mapping[str, str], answers: Answers) -> RecordingMap:
        """What to keep under a name: what a person says, over what is kept already."""
        kept = map_for(tuple(self.names))
        return RecordingMap(name, self.names, {**(kept.said if kept else {}), **said}, answers)


def look(path: str | os.PathLike[str], said: Mapping[str, str], answers: Answers = NO_ANSWERS) -> Look:
    """What each column of a recording's file was taken for, and the recording that comes of it.

    Args:
        path: a file.
        said: what a person says of columns, or of devices' names in rows of their own, by name.
        answers: as for `read_recording`.

    Raises:
        InputError: the file cannot be read at all, or what is said names no column of it.
    """
    answers.check()
    content = content_of(path)
    digest = hashlib.sha256(content).hexdigest()
    plain = plain_table(unpacked(content, str(path)))
    names, rows = _cells(plain)
    kept = map_for(names)
    before = dict(kept.said) if kept else _laid_out(plain)
    told = {name: check_said(text) for name, text in said.items()}
    found = understand(names, {**before, **told})
    labels = _labels(names, rows, found)
    unknown = [name for name in told if name not in names and name not in labels]
    if unknown:
        raise InputError(
            f"{path}: no column or device is called {unknown[0]!r}; it has {_some([*names, *labels])}"
        )
    taken = _taken(found, len(names))
    by = {**dict.fromkeys(kept.said if kept else (), "kept"), **dict.fromkeys(told, "you")}
    shown = [
        Column(name, rows[0][place] if rows else "", taken[place], by.get(name, ""))
        for place, name in enumerate(names)
    ]
    for label, tracker in columns.named([(label,) for label in labels], {**before, **told}).items():
        shown.append(Column(label[0], "", tracker or NOTHING, by.get(label[0], "")))
    try:
        if not told:
            recording = read_recording(path, answers)
        else:
            everything = RecordingMap(
                "", frozenset(names), {**before, **told}, kept.answers if kept else NO_ANSWERS
            )
            reader = objects.read if is_json(plain) else columns.read
            recording = to_recording(reader(plain, str(path), everything), str(path), digest, answers)
    except InputError as error:
        return Look(tuple(shown), frozenset(names), None, str(error))
    return Look(tuple(shown), frozenset(names), recording, "")


def poses_in_words(recording: Recording) -> dict[str, str]:
    """What the three poses do, in words, by tracker; for a person who knows what was recorded."""
    head, turns = recording.positions[:, 0], recording.rotations
    heading = np.unwrap(quat.heading(turns[:, 0]))
    walked = float(
        np.linalg.norm(np.diff(head[:: max(1, round(recording.fps / 4))], axis=0)[:, :2], axis=-1).sum()
    )
    upright = float(np.median(quat.to_matrix(turns[:, 0])[:, 2, 2]))
    out = {
        "head": f"{np.median(head[:, 2]):.2f} m over the floor, {head[:, 2].min():.2f} to {head[:, 2].max():.2f} m; "
        f"upright by {upright:.2f}; goes {walked:.1f} m, turns {np.degrees(np.ptp(heading)):.0f} degrees"
    }
    back = quat.conjugate(quat.from_yaw(heading))
    for index, tracker in enumerate(TRACKERS[1:], 1):
        known = recording.valid[:, index]
        if not known.any():
            out[tracker] = "never tracked"
            continue
        place = np.median(quat.rotate(back, recording.positions[:, index] - head)[known], axis=0)
        points = np.median(
            quat.rotate(quat.multiply(back, turns[:, index]), np.array([0.0, 1.0, 0.0]))[known], axis=0
        )
        words = _sides(place, ("right", "left"), ("ahead", "behind"), ("above", "below"))
        out[tracker] = (
            f"{words} of the head; points {_strongest(points)}; tracked {known.mean():.0%} of the time"
        )
    return out


def _sides(place: Array, *pairs: tuple[str, str]) -> str:
    return ", ".join(f"{abs(x):.2f} m {pair[int(x < 0.0)]}" for x, pair in zip(place, pairs, strict=True))


def _strongest(direction: Array) -> str:
    """The one of six directions that a vector in the head's axes lies nearest to."""
    axis = int(np.argmax(np.abs(direction)))
    return (("right", "left"), ("ahead", "back"), ("up", "down"))[axis][int(direction[axis] < 0.0)]


def _cells(plain: bytes) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Names of the columns, and rows of texts; nothing for a file that has none."""
    if is_json(plain):
        rows = rows_of(objects.parsed(plain, "")) if _is_table(plain) else []
        names = objects.names_in(rows) if rows else ()
        return names, [tuple(str(row.get(name, "")) for name in names) for row in rows]
    if b"\0" in plain[:4096]:
        return (), []
    names, lines, header = columns.named_columns(
        plain.decode("utf-8", "replace").removeprefix("\ufeff").splitlines()
    )
    cells = [
        tuple(cell.strip() for cell in line.split(","))
        for line in lines[header + 1 :]
        if line.strip() and not line.startswith(("#", "//", "%"))
    ]
    return tuple(names), [row for row in cells if len(row) == len(names)]


def _is_table(plain: bytes) -> bool:
    """Whether JSON is of no format with names of its own; broken JSON is left to its reader."""
    return not aframe.recognise(plain) and not (b'"schema"' in plain and b'"frames"' in plain)


def _laid_out(plain: bytes) -> dict[str, str]:
    """What a layout says of the columns of a table, by name; nothing where none fits."""
    layout = next((entry for entry in layouts.layouts().entries if layouts.recognise(plain, entry)), None)
    if layout is None or is_json(plain):
        return {}
    parts = ("px", "py", "pz", "qw", "qx", "qy", "qz")
    meanings = ["time", *(f"{tracker}.{part}" for tracker in TRACKERS for part in parts)]
    return dict(zip(layout.columns, meanings, strict=True))


def _labels(names: Sequence[str], rows: Sequence[tuple[str, ...]], found: Understood) -> list[str]:
    """What the devices are called whose rows are their own."""
    if "head" in found.trackers or found.device < 0:
        return []
    places = found.labels or [found.device]
    seen = dict.fromkeys(" ".join(row[place] for place in places) for row in rows)
    return list(seen)[:_LABELS_SHOWN]


def _taken(found: Understood, count: int) -> list[str]:
    """What each of `count` columns was taken for."""
    out = [NOTHING] * count
    for tracker, pose in found.trackers.items():
        if not tracker and "head" in found.trackers:
            continue
        prefix = f"{tracker}." if tracker else ""
        for column, part in zip(
            (*pose.place, *pose.turn), ("px", "py", "pz", *_turn_parts(pose)), strict=True
        ):
            out[column] = prefix + part
    for tracker, column in found.times.items():
        out[column] = f"time of {tracker}"
    for column in found.labels:
        out[column] = "device"
    for column, text in ((found.device, "device"), (found.number, "frame"), (found.time, "time")):
        if column >= 0:
            out[column] = text
    return out


def _turn_parts(pose: Columns) -> Sequence[str]:
    return _PARTS[pose.kind] if pose.ordered else [f"q{place}" for place in range(4)]


def _some(names: Sequence[str]) -> str:
    return ", ".join(repr(name) for name in names[:8]) + (" ..." if len(names) > 8 else "")

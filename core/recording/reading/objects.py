"""JSON of other recorders - one object, or one a line - with the trackers' poses in a list of frames."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, cast

import numpy as np

from ...bounds import RECORDING_BYTES
from ...errors import FaultError, InputError
from ...json_text import parse_json
from ..raw import RawRecording, Reading, Track
from .clock import Sheet, number
from .columns import is_posed, to_raw
from .dress import is_json
from .kept import RecordingMap, map_for
from .meaning import understand
from .shapes import rows_of

_MOST_NAMES = 600
NAME = "JSON, by the names in it"
_WEBXR = Reading(axes="RUB", rotation="xyzw")


def recognise(content: bytes) -> bool:
    """Whether a file is JSON, which may hold frames."""
    return is_json(content)


def read(content: bytes, file: str, told: RecordingMap | None = None) -> RawRecording:
    """Samples of such a file, in its own axes and unit; `told` as in `columns.read`.

    Raises:
        InputError: broken JSON, or no frames with the headset's position and rotation in it.
    """
    data = parsed(content, file)
    if isinstance(data, dict) and {"schema", "frames"} <= cast(dict[str, Any], data).keys():
        return _read_webxr(cast(dict[str, Any], data), file)
    rows = rows_of(data)
    if rows:
        names = names_in(rows)
        told = told or map_for(names)
        found = understand(names, told.said if told else None)
        if is_posed(found):
            posed = {i for pose in found.trackers.values() for i in (*pose.place, *pose.turn, *pose.last)}
            sheet = _sheet(names, rows, posed)
            return to_raw(sheet, found, file, NAME, told)
    raise InputError(
        f"{file}: JSON without frames that tell a headset's position and rotation; name them head, left and right"
    )


def names_in(rows: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    """The names in frames."""
    return tuple(dict.fromkeys(name for row in (*rows[:50], rows[-1]) for name in row))[:_MOST_NAMES]


def parsed(content: bytes, file: str) -> Any:
    """The JSON value; a list of values where there is one a line."""
    try:
        return parse_json(content, RECORDING_BYTES, small=False)
    except FaultError as fault:
        lines = content.removeprefix(b"\xef\xbb\xbf").splitlines()
        rows = [line for line in lines if line.strip()]
        if len(rows) < 2 or not all(row.strip()[:1] in (b"{", b"[") for row in rows[:2]):
            raise InputError(f"{file}: {fault}; was the file cut short? record it again") from None
    out: list[Any] = []
    for place, line in enumerate(lines, 1):
        if line.strip():
            try:
                out.append(parse_json(line, RECORDING_BYTES, small=False))
            except FaultError:
                raise InputError(f"{file}: line {place}: broken JSON; correct or remove the line") from None
    return out


def _sheet(names: Sequence[str], rows: Sequence[Mapping[str, Any]], posed: set[int]) -> Sheet:
    values = np.full((len(rows), len(names)), np.nan)
    written: list[tuple[str, ...]] = [()] * len(names)
    for column, name in enumerate(names):
        cells = [row.get(name) for row in rows]
        if column not in posed:
            written[column] = tuple("" if cell is None else str(cell) for cell in cells)
            continue
        values[:, column] = [
            float(cell)
            if isinstance(cell, int | float)
            else number(cell)
            if isinstance(cell, str)
            else np.nan
            for cell in cells
        ]
    return Sheet(tuple(names), values, tuple(written), np.arange(1, len(rows) + 1))


def _read_webxr(data: Mapping[str, Any], file: str) -> RawRecording:
    """Samples of a recording of WebXR inputs by IWER: a schema of inputs, and frames as lists of numbers."""
    try:
        hands = {
            int(number): (str(kind["handedness"]), bool(kind["hasGrip"])) for number, kind in data["schema"]
        }
        head: list[list[float]] = []
        inputs: dict[str, list[list[float]]] = {"left": [], "right": []}
        for frame in data["frames"]:
            time = float(frame[0]) / 1000.0
            head.append([time, *(float(x) for x in frame[1:8])])
            for entry in frame[8:]:
                side, grip = hands[int(entry[0])]
                if side in inputs:
                    inputs[side].append([time, *(float(x) for x in _grip(entry, grip))])
        tracks = [_track(rows) for rows in (head, inputs["left"], inputs["right"])]
    except (KeyError, TypeError, ValueError, IndexError, OverflowError):
        raise InputError(f"{file}: a recording of WebXR inputs whose frames do not fit its schema") from None
    found = {"format": "WebXR inputs (IWER)"}
    profiles: list[Any] = [kind.get("profiles") for _, kind in data["schema"]]
    named = next(
        (cast(list[Any], profile)[0] for profile in profiles if profile and isinstance(profile, list)), ""
    )
    if isinstance(named, str) and named:
        found["device"] = named
    return RawRecording((tracks[0], tracks[1], tracks[2]), found, reading=_WEBXR)


def _grip(entry: Sequence[Any], grip: bool) -> Sequence[Any]:
    """The pose of the grip, else of the pointer; the grip stands in a list of its own or right behind."""
    if grip and len(entry) > 8:
        return cast(Sequence[Any], entry[8]) if isinstance(entry[8], list) else entry[8:15]
    return entry[1:8]


def _track(rows: list[list[float]]) -> Track:
    values = np.array(rows, dtype=np.float64).reshape(-1, 8)
    return Track(values[:, 0], values[:, 1:4], values[:, 4:], np.ones(len(values), dtype=np.bool_))

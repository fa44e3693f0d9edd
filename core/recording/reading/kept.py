"""What a person said of a recorder's columns, kept in the user's folder for files with the same columns."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, cast

from ...bounds import RECORDING_RATE
from ...errors import InputError
from ...presets import Presets, check_keys, check_text, check_texts, keep_preset, load_presets, read_preset
from ..raw import RawRecording
from .answers import NO_ANSWERS, Answers
from .meaning import PARTS, words_of
from .rotations import kind_of
from .scores import UNITS

KIND = "recording_maps"
"""Sub-folder of the presets."""
NOTHING = "nothing"
COLUMNS = ("time", "time ms", "time us", "time ns", "frame", "device", NOTHING)
"""What a column may be that is of no pose."""
_OPTIONAL = ("axes", "unit", "rotation", "rate", "swap_hands")


@dataclass(frozen=True, slots=True)
class RecordingMap:
    """What a person said of one recorder's columns."""

    name: str = ""
    columns: frozenset[str] = frozenset()
    """The names of all columns of the files that it holds for."""
    said: Mapping[str, str] = field(default_factory=dict[str, str])
    """What columns are, by name: "head.px", "time", "nothing"; what a tracker's rows are called: "head"."""
    answers: Answers = NO_ANSWERS
    """Axes, unit, rotation, rate and sides."""


def maps() -> Presets[RecordingMap]:
    """The maps in the user's folder."""
    return load_presets(KIND, read_map)


def map_for(names: Sequence[str]) -> RecordingMap | None:
    """The map kept for files with just these columns, None where there is none."""
    columns = frozenset(names)
    return next((entry for entry in maps().entries if entry.columns == columns), None)


def keep_map(kept: RecordingMap) -> Path:
    """Write a map into the user's folder, over an older one of its name.

    Raises:
        InputError: it cannot be written.
    """
    given = kept.answers
    answers = {
        "axes": given.axes,
        "unit": given.unit,
        "rotation": given.rotation,
        "rate": given.rate,
        "swap_hands": given.swap_hands,
    }
    content = {
        "name": kept.name,
        "columns": sorted(kept.columns),
        "said": dict(kept.said),
        **{name: value for name, value in answers.items() if value},
    }
    return keep_preset(KIND, kept.name, content)


def read_map(path: str | os.PathLike[str]) -> RecordingMap:
    """A map from its JSON file.

    Raises:
        InputError: the file is no map; the line says what is wrong.
    """
    return read_preset(path, _parse, "recording map")


def check_said(text: str) -> str:
    """What a person says of a column, as it is kept; ValueError where nothing is called so."""
    text = " ".join(text.split())
    tracker, point, part = text.rpartition(".")
    if text in COLUMNS or (point and part in PARTS and words_of(tracker)):
        return text
    if not point and text and " ".join(words_of(text)) == text.lower():
        # whose rows are called so
        return text
    raise ValueError(
        f"{text!r} is none of {', '.join(COLUMNS)}, nor a tracker and a part of its pose, such as head.px, left.qw, "
        "right.rx, head.yaw, head.m00"
    )


def completed(raw: RawRecording, answers: Answers) -> RawRecording:
    """The samples with what a map answers, as though the file stated it."""
    reading, stated = raw.reading, set(raw.stated)
    if answers.axes:
        reading = replace(reading, axes=answers.axes, devices="")
        stated.add("axes")
    if answers.unit:
        reading = replace(reading, metres=UNITS[answers.unit])
        stated.add("unit")
    if answers.rotation and kind_of(answers.rotation) == kind_of(reading.rotation):
        reading = replace(reading, rotation=answers.rotation)
        stated.add("rotation")
    if answers.swap_hands:
        raw = replace(raw, tracks=(raw.tracks[0], raw.tracks[2], raw.tracks[1]))
    if raw.counted and answers.rate:
        tracks = [replace(track, times=track.times / answers.rate) for track in raw.tracks]
        extra = [
            replace(item, track=replace(item.track, times=item.track.times / answers.rate))
            for item in raw.extra
        ]
        raw = replace(raw, tracks=(tracks[0], tracks[1], tracks[2]), extra=tuple(extra), counted=False)
    return replace(raw, reading=reading, stated=frozenset(stated))


def _parse(content: Any) -> RecordingMap:
    data = check_keys(content, ("name", "columns", "said"), _OPTIONAL)
    columns = check_texts(data["columns"], "'columns'")
    if not isinstance(data["said"], dict):
        raise ValueError("'said' is not an object {...}")
    said = {
        column: check_said(check_text(text, f"'said' of {column!r}"))
        for column, text in cast("dict[str, Any]", data["said"]).items()
    }
    texts = {
        name: check_text(data[name], f"{name!r}") for name in ("axes", "unit", "rotation") if name in data
    }
    rate, swap = data.get("rate"), data.get("swap_hands", False)
    if rate is not None and not (
        isinstance(rate, int | float) and RECORDING_RATE[0] <= rate <= RECORDING_RATE[1]
    ):
        raise ValueError("'rate' is no number of samples per second")
    if not isinstance(swap, bool):
        raise ValueError("'swap_hands' is neither true nor false")
    answers = Answers(
        axes=texts.get("axes", ""),
        unit=texts.get("unit", ""),
        rotation=texts.get("rotation", ""),
        rate=rate,
        swap_hands=swap,
    )
    try:
        answers.check()
    except InputError as error:
        raise ValueError(str(error)) from None
    return RecordingMap(check_text(data["name"], "'name'"), frozenset(columns), said, answers)

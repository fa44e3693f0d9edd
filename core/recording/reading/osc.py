"""Logs of OSC messages, VMC's among them: one message a line, as text or JSON, with or without times."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np

from ...errors import InputError
from ..raw import STATED, Extra, RawRecording, Reading, Track
from ..recording import TRACKERS
from .clock import date, fitting, number
from .columns import named
from .dress import is_json

NAME = "OSC messages"
_HEAD_BYTES = 16384
_MESSAGE = re.compile(r"(?P<before>[^/]*?)(?P<address>/[A-Za-z][\w\-]*(?:/[\w\-]+)*)(?P<rest>.*)")
_BETWEEN = re.compile(r"[\s,;:()\[\]{}\"'=]+")
_NTP = re.compile(r"\b([0-9a-f]{8})\.([0-9a-f]{8})\b")
_OTHER = re.compile(r"/(?:Bone|Root|Blend|Local)\b|/Local$")
"""VMC's messages of an avatar's bones, and poses told from elsewhere."""


def recognise(content: bytes) -> bool:
    """Whether most of a file's first lines are messages with numbers."""
    head = content[:_HEAD_BYTES]
    if b"\0" in head or (
        is_json(head) and b'"addr' not in head and not re.match(rb"\s*\[[\d.]+\]\s*/", head)
    ):
        return False
    lines = [line for line in head.decode("utf-8", "replace").splitlines()[:40] if len(line.strip()) > 1]
    found = [_MESSAGE.match(line) for line in lines]
    told = [one for one in found if one and len(_split(one["rest"])[0]) >= 3]
    return len(told) >= max(2, 0.5 * len(lines))


def read(content: bytes, file: str) -> RawRecording:
    """Samples of such a log, in its own axes and unit.

    Raises:
        InputError: no message tells of the headset.
    """
    rows: dict[tuple[str, ...], list[list[float]]] = {}
    places: dict[tuple[str, ...], list[float]] = {}
    now, vmc = math.nan, False
    for line in content.decode("utf-8", "replace").splitlines():
        found = _MESSAGE.match(line)
        if not found or _OTHER.search(found["address"]):
            continue
        values, text = _split(found["rest"])
        address = found["address"]
        if len(values) == 1 and address.endswith(("/T", "/time")):
            now = values[0]
        if len(values) < 3:
            continue
        time = _time(found["before"])
        now = now if math.isnan(time) else time
        if len(values) >= 7:
            rows.setdefault((text, address), []).append([now, *values[-7:]])
            vmc = vmc or address.startswith("/VMC/")
            continue
        # places and rotations of a tracker come one after the other
        key = (text, address.rpartition("/")[0])
        if len(values) == 4 and key in places:
            rows.setdefault(key, []).append([now, *places.pop(key), *values])
        elif len(values) == 3:
            places[key] = values
    trackers = named(list(rows))
    tracks = {trackers[label]: _track(rows[label]) for label in reversed(rows) if trackers[label]}
    if "head" not in tracks:
        raise InputError(f"{file}: no message tells of the headset; let its address have hmd or head in it")
    times = tracks["head"].times
    counted = not bool(np.isfinite(times).any())
    unit = 1.0 if counted else fitting(times) or 1.0
    tracks = {name: _timed(track, unit, counted) for name, track in tracks.items()}
    none = Track(np.empty(0), np.empty((0, 3)), np.empty((0, 4)), np.empty(0, dtype=np.bool_))
    head, left, right = (tracks.get(tracker, none) for tracker in TRACKERS)
    return RawRecording(
        tracks=(head, left, right),
        found={"format": "VMC messages" if vmc else NAME},
        reading=Reading(axes="RUF", rotation="xyzw"),
        stated=STATED - {"origin"} if vmc else frozenset(("sides",)),
        extra=tuple(Extra(name, track) for name, track in tracks.items() if name not in TRACKERS),
        counted=counted,
    )


def _split(text: str) -> tuple[list[float], str]:
    """The numbers at the end of a message, and its words."""
    values: list[float] = []
    words: list[str] = []
    for token in _BETWEEN.split(text):
        value = number(token) if token else math.nan
        if not math.isnan(value):
            values.append(value)
        elif token:
            words.append(token)
    return values, " ".join(word for word in words if not re.fullmatch(r"[sifTFh]+|args|values|types", word))


def _time(before: str) -> float:
    """What stands before a message's address as a time; NaN for none."""
    ntp = _NTP.search(before)
    if ntp:
        return int(ntp[1], 16) + int(ntp[2], 16) / 2.0**32
    text = before.strip(" \t,;[]|")
    dated = date(text) if ":" in text else math.nan
    if not math.isnan(dated):
        return dated
    values, _ = _split(before)
    return values[-1] if values else math.nan


def _track(rows: list[list[float]]) -> Track:
    values = np.array(rows, dtype=np.float64)
    return Track(values[:, 0], values[:, 1:4], values[:, 4:], np.ones(len(values), dtype=np.bool_))


def _timed(track: Track, unit: float, counted: bool) -> Track:
    times: Any = np.arange(len(track.times), dtype=np.float64) if counted else track.times * unit
    return Track(times, track.positions, track.rotations, track.valid)

"""Footwork's own recording format: a CSV table under a few comments (docs/recording-format.md)."""

from __future__ import annotations

import os
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from ..bounds import EYE_HEIGHT, FARTHEST
from ..errors import InputError, one_line
from ..maths import quat
from ..transaction import Transaction, write_atomically
from .mounts import DEVICE_MOUNTS
from .raw import Extra, RawRecording, Track
from .reading.meaning import words_of
from .recording import TRACKERS, Array, Mounts, Recording
from .table import columns_of, decode, read_columns

_MAGIC = "# footwork-recording "
_VERSION = 1
_SHORT = 0.1
"""A quaternion shorter than this is none."""
_PARTS = ("px", "py", "pz", "qw", "qx", "qy", "qz", "valid")
COLUMNS = ("time", *(f"{tracker}_{part}" for tracker in TRACKERS for part in _PARTS))
"""Columns in the order in which they are written; any order is read."""


def write_csv(path: str | os.PathLike[str], recording: Recording, outputs: Transaction | None = None) -> None:
    """Write a recording as CSV: times to a nanosecond, positions to a micrometre, rotations to 1e-8.

    It is written at once, or as part of a transaction.

    Raises:
        InputError: the file cannot be written.
    """
    lines = [
        f"{_MAGIC}{_VERSION}",
        f"# name: {one_line(' '.join(recording.name.split()))}",
        f"# eye_height: {recording.eye_height!r}",
        *(
            f"# mount_{tracker}: {' '.join(repr(float(x)) for x in (*offset, *turn))}"
            for tracker, offset, turn in zip(
                TRACKERS, recording.mounts.offsets, recording.mounts.turns, strict=True
            )
        ),
        "# seconds; metres in Blender's world (Z up, floor at 0); device axes X right, Y forward, Z up",
        ",".join((*COLUMNS, *_columns_of(recording))),
    ]
    poses = [recording.positions, recording.rotations, recording.valid[..., None]]
    table = np.concatenate(
        [recording.times[:, None], np.concatenate(poses, axis=-1).reshape(len(recording), -1)], 1
    )
    others = [(item.positions, item.rotations, item.valid[:, None]) for item in recording.extra]
    table = np.concatenate([table, *(part for parts in others for part in parts)], axis=1)
    row = ["%.9f", *(["%.6f"] * 3 + ["%.8f"] * 4 + ["%d"]) * (len(TRACKERS) + len(others))]

    def write(file: BinaryIO) -> None:
        file.write(("\n".join(lines) + "\n").encode())
        np.savetxt(file, table, fmt=",".join(row))

    write_atomically(path, write, outputs)


def _columns_of(recording: Recording) -> list[str]:
    """Names of the columns of other trackers, each once."""
    names: list[str] = []
    for item in recording.extra:
        name = "_".join(words_of(item.name)) or "tracker"
        while name in names or name in TRACKERS:
            name += "_2"
        names.append(name)
    return [f"{name}_{part}" for name in names for part in _PARTS]


def _extra(lines: list[str], header: int, file: str) -> tuple[Extra, ...]:
    """Trackers besides the three, whose columns are all there."""
    columns = columns_of(lines[header])
    names = [column.removesuffix("_px") for column in columns if column.endswith("_px")]
    whole = [n for n in names if n not in TRACKERS and all(f"{n}_{part}" in columns for part in _PARTS)]
    extra: list[Extra] = []
    for name in whole:
        values, _ = read_columns(lines, header, ["time", *(f"{name}_{part}" for part in _PARTS)], file)
        extra.append(
            Extra(
                name.replace("_", " "),
                Track(values[:, 0], values[:, 1:4], values[:, 4:8], values[:, 8] != 0.0),
            )
        )
    return tuple(extra)


def read_csv(content: bytes, file: str) -> RawRecording:
    """Samples of a CSV of ours.

    Raises:
        InputError: with the line number: a newer version, a missing column, a short row, a cell that is no
            number, a valid sample with NaN or a zero quaternion, time that does not run forward, no rows.
    """
    lines = decode(content, file)
    _check_version(lines[0], file)
    header = next((i for i, line in enumerate(lines) if line.strip() and not line.startswith("#")), None)
    if header is None:
        raise InputError(f"{file}: line {len(lines)}: no table after the comments; nothing was recorded")
    fields = _fields(lines[:header])
    values, numbers = read_columns(lines, header, COLUMNS, file)
    times, poses = values[:, 0], values[:, 1:].reshape(len(values), len(TRACKERS), len(_PARTS))
    _check_rows(times, poses, numbers, file)
    head, left, right = (
        Track(times, poses[:, i, :3], poses[:, i, 3:7], poses[:, i, 7] != 0.0) for i in range(len(TRACKERS))
    )
    return RawRecording(
        tracks=(head, left, right),
        found={"format": "Footwork CSV"},
        states_validity=True,
        name=fields["name"][1] if "name" in fields else "",
        mounts=_mounts(fields, file),
        eye_height=_eye_height(fields, file) if "eye_height" in fields else None,
        extra=_extra(lines, header, file),
    )


def _check_version(line: str, file: str) -> None:
    version = line.removeprefix(_MAGIC).strip()
    if not version.isdecimal():
        raise InputError(
            f"{file}: line 1: the format's version is {version!r}, not a whole number such as {_VERSION}"
        )
    if len(version) > 9 or int(version) > _VERSION:
        raise InputError(
            f"{file}: line 1: version {version[:9]} is newer than {_VERSION}, the last known; update Footwork"
        )


def _fields(comments: list[str]) -> dict[str, tuple[int, str]]:
    """The `# key: value` lines: line number and value of each key."""
    split = ((number, *line.lstrip("#").partition(":")) for number, line in enumerate(comments, 1))
    return {key.strip(): (number, value.strip()) for number, key, colon, value in split if colon}


def _floats(fields: dict[str, tuple[int, str]], key: str, count: int, file: str) -> list[float]:
    number, text = fields[key]
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        values = []
    if len(values) != count or not np.isfinite(values).all():
        raise InputError(
            f"{file}: line {number}: {key} is {text!r}, not {count} finite number{'s' * (count > 1)}"
        )
    return values


def _eye_height(fields: dict[str, tuple[int, str]], file: str) -> float:
    (height,) = _floats(fields, "eye_height", 1, file)
    if not EYE_HEIGHT[0] <= height <= EYE_HEIGHT[1]:
        number = fields["eye_height"][0]
        raise InputError(f"{file}: line {number}: eye height {height:g} m is no person's; correct it")
    return height


def _mounts(fields: dict[str, tuple[int, str]], file: str) -> Mounts:
    """The mounts that the comments state; those of real devices where they state none."""
    keys = [f"mount_{tracker}" for tracker in TRACKERS]
    if not any(key in fields for key in keys):
        return DEVICE_MOUNTS
    for key in keys:
        if key not in fields:
            raise InputError(f"{file}: no {key} beside the other mounts; state all three or none")
    values = np.array([_floats(fields, key, 7, file) for key in keys])
    for key, turn in zip(keys, values[:, 3:], strict=True):
        if np.linalg.norm(turn) < 0.5:
            raise InputError(f"{file}: line {fields[key][0]}: {key}'s rotation is no unit quaternion w x y z")
    return Mounts(offsets=values[:, :3], turns=quat.normalize(values[:, 3:]))


def _check_rows(times: Array, poses: Array, numbers: NDArray[np.intp], file: str) -> None:
    """Raise for the first row whose content cannot stand."""
    valid = poses[..., 7] != 0.0
    faults = {
        "time is not a finite number; give every row its seconds": ~np.isfinite(times),
        "time does not run forward; sort the rows and drop repeated ones": np.r_[
            False, np.diff(times) <= 0.0
        ],
    }
    for i, tracker in enumerate(TRACKERS):
        pose, ok = poses[:, i, :7], valid[:, i]
        finite = np.asarray(np.isfinite(pose).all(axis=-1))
        length = np.linalg.norm(np.where(finite[:, None], pose[:, 3:], 1.0), axis=-1)
        advice = f"set {tracker}_valid to 0 where it was not tracked"
        faults[f"{tracker} has an empty or infinite value; {advice}"] = ok & ~finite
        faults[f"{tracker} has a value past {FARTHEST:g}; {advice}"] = (
            ok & finite & ~(np.abs(pose) < FARTHEST).all(-1)
        )
        faults[f"{tracker} has a zero quaternion; {advice}"] = ok & (length < _SHORT)
    first = min(
        faults, key=lambda fault: int(np.argmax(faults[fault])) if faults[fault].any() else len(times)
    )
    if faults[first].any():
        raise InputError(f"{file}: line {numbers[np.argmax(faults[first])]}: {first}")


def recognise(content: bytes) -> bool:
    """Whether a file looks like a CSV of ours, whatever its version."""
    return content.removeprefix(b"\xef\xbb\xbf").startswith(_MAGIC.encode())

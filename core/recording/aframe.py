"""A-Frame motion-capture recordings: JSON of poses with Euler angles in degrees, made in the browser."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, cast

import numpy as np

from ..bounds import RECORDING_BYTES
from ..errors import FaultError, InputError
from ..json_text import parse_json
from ..maths import quat
from .raw import RawRecording, Track, change_axes

_KEYS = (("camera", "head"), ("left", "leftHand"), ("right", "rightHand"))
"""The names under which versions of the component store head, left and right."""


def read_aframe(content: bytes, file: str) -> RawRecording:
    """Samples of an A-Frame motion-capture file, with the controllers' keys of any of its versions.

    Axes are X right, Y up, -Z forward for world and devices; angles are degrees about X, Y and Z, applied in
    the order YXZ; each tracker has its own timestamps in milliseconds of one clock.

    Raises:
        InputError: broken JSON with its line, a pose without its numbers with its index, no headset.
    """
    try:
        data: Any = parse_json(content, RECORDING_BYTES, small=False)
    except FaultError as fault:
        raise InputError(f"{file}: {fault}; was the file cut short? record it again") from None
    if isinstance(data, dict) and "recording" in data:
        data = cast(Any, data["recording"])
    if not isinstance(data, dict):
        raise InputError(f"{file}: no trackers in it; an A-Frame recording has camera, left and right")
    head, left, right = (_track(cast(dict[str, Any], data), names, file) for names in _KEYS)
    if len(head.times) == 0:
        raise InputError(f"{file}: no poses of the camera; record the headset as well as the controllers")
    return RawRecording(tracks=(head, left, right), found={"format": "A-Frame motion capture"})


def _track(data: Mapping[str, Any], names: tuple[str, ...], file: str) -> Track:
    """The poses stored under the first of `names` that is there."""
    name = next((name for name in names if name in data), names[0])
    stored = data.get(name)
    poses: Any = cast(dict[str, Any], stored).get("poses", []) if isinstance(stored, dict) else []
    try:
        rows = [
            (pose["timestamp"], *(pose[part][axis] for part in ("position", "rotation") for axis in "xyz"))
            for pose in poses
        ]
        values = np.array(rows, dtype=np.float64).reshape(-1, 7)
    except (KeyError, TypeError, ValueError, OverflowError, IndexError):
        raise _first_fault(poses, f"{file}: {name}") from None
    turns = quat.from_euler(np.radians(values[:, [5, 4, 6]]), "YXZ")
    positions, rotations = change_axes(values[:, 1:4], turns, "RUB")
    return Track(values[:, 0] / 1000.0, positions, rotations, np.ones(len(values), dtype=np.bool_))


def _first_fault(poses: Any, where: str) -> InputError:
    """What keeps poses from being read."""
    if not isinstance(poses, list):
        return InputError(f"{where}: poses is not a list; record it again")
    for i, pose in enumerate(cast(list[Any], poses)):
        try:
            numbers = [
                pose["timestamp"],
                *(pose[part][axis] for part in ("position", "rotation") for axis in "xyz"),
            ]
            np.array(numbers, dtype=np.float64)
        except (KeyError, TypeError, ValueError, OverflowError, IndexError):
            return InputError(
                f"{where}: pose {i} lacks a number among timestamp, position and rotation; remove it"
            )
    return InputError(f"{where}: its poses cannot be read; record it again")


def recognise(content: bytes) -> bool:
    """Whether a file looks like an A-Frame motion-capture recording."""
    return content.lstrip()[:1] == b"{" and b'"poses"' in content and b'"rotation"' in content

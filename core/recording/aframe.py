"""A-Frame motion-capture recordings: JSON of poses with Euler angles in degrees, made in the browser."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, cast

import numpy as np

from ..bounds import RECORDING_BYTES
from ..errors import FaultError, InputError
from ..json_text import parse_json
from .raw import RawRecording, Reading, Track

_KEYS = (
    ("camera", "head", "headset", "hmd"),
    ("left", "leftHand", "left-hand", "lefthand", "left-controller", "leftController"),
    ("right", "rightHand", "right-hand", "righthand", "right-controller", "rightController"),
)
"""The names under which versions of the component store head, left and right."""


def read_aframe(content: bytes, file: str) -> RawRecording:
    """Samples of an A-Frame motion-capture file, with the controllers' keys of any of its versions.

    Axes are X right, Y up, -Z forward for world and devices; angles are degrees about X, Y and Z, applied in
    the order YXZ, or there are quaternions; each tracker has its own timestamps in milliseconds of one clock.

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
    parts = "xyzw" if _has_quaternions(content) else "xyz"
    head, left, right = (_track(cast(dict[str, Any], data), names, parts, file) for names in _KEYS)
    if len(head.times) == 0:
        raise InputError(f"{file}: no poses of the camera; record the headset as well as the controllers")
    return RawRecording(
        tracks=(head, left, right),
        found={"format": "A-Frame motion capture"},
        reading=Reading(axes="RUB", rotation="xyzw" if parts == "xyzw" else "YXZ-degrees"),
    )


def _has_quaternions(content: bytes) -> bool:
    """Whether the first rotation has a w."""
    found = re.search(rb'"rotation"\s*:\s*\{([^}]*)\}', content)
    return found is not None and b'"w"' in found[1]


def _track(data: Mapping[str, Any], names: tuple[str, ...], parts: str, file: str) -> Track:
    """The poses stored under the first of `names` that is there."""
    name = next((name for name in names if name in data), names[0])
    stored = data.get(name)
    poses: Any = cast(dict[str, Any], stored).get("poses", []) if isinstance(stored, dict) else []
    try:
        values = np.array([_numbers(pose, parts) for pose in poses], dtype=np.float64).reshape(
            -1, 4 + len(parts)
        )
    except (KeyError, TypeError, ValueError, OverflowError, IndexError):
        raise _first_fault(poses, parts, f"{file}: {name}") from None
    return Track(values[:, 0] / 1000.0, values[:, 1:4], values[:, 4:], np.ones(len(values), dtype=np.bool_))


def _numbers(pose: Any, parts: str) -> list[Any]:
    """Time, position and rotation of a pose."""
    position, rotation = pose["position"], pose["rotation"]
    return [pose["timestamp"], *(position[axis] for axis in "xyz"), *(rotation[axis] for axis in parts)]


def _first_fault(poses: Any, parts: str, where: str) -> InputError:
    """What keeps poses from being read."""
    if not isinstance(poses, list):
        return InputError(f"{where}: poses is not a list; record it again")
    for i, pose in enumerate(cast(list[Any], poses)):
        try:
            np.array(_numbers(pose, parts), dtype=np.float64)
        except (KeyError, TypeError, ValueError, OverflowError, IndexError):
            return InputError(
                f"{where}: pose {i} lacks a number among timestamp, position and rotation; remove it"
            )
    return InputError(f"{where}: its poses cannot be read; record it again")


def recognise(content: bytes) -> bool:
    """Whether a file looks like an A-Frame motion-capture recording."""
    return content.lstrip()[:1] == b"{" and b'"poses"' in content and b'"rotation"' in content

"""Beat Saber Open Replay, version 1: a headset and two sabers of one song, binary, little endian."""

from __future__ import annotations

import struct

import numpy as np

from ..errors import InputError
from .raw import RawRecording, Reading, Track
from .recording import TRACKERS

_MAGIC = struct.pack("<I", 0x442D3D69)
_INFO = b"\x00"
_FRAMES = b"\x01"
# time, frames per second, then for head, left, right: position and quaternion x y z w
_FRAME = np.dtype([("time", "<f4"), ("fps", "<i4"), ("poses", "<f4", (3, 7))])


def read_bsor(content: bytes, file: str) -> RawRecording:
    """Samples of a Beat Saber replay, in Unity's axes: left-handed, Y up, Z forward, metres.

    Raises:
        InputError: a newer version, or a file that ends early or is garbled.
    """
    if content[4:5] != b"\x01":
        raise InputError(
            f"{file}: replay version {content[4] if len(content) > 4 else '?'}; only version 1 is known"
        )
    try:
        start, device = _skip_info(content)
        if content[start : start + 1] != _FRAMES:
            raise ValueError
        (count,) = struct.unpack_from("<i", content, start + 1)
        frames = np.frombuffer(content, dtype=_FRAME, count=max(count, 0), offset=start + 5)
    except (struct.error, ValueError):
        raise InputError(
            f"{file}: the replay ends early or is garbled; download or record it again"
        ) from None
    times = frames["time"].astype(np.float64)
    poses = frames["poses"].astype(np.float64)
    head, left, right = (
        Track(times, poses[:, i, :3], poses[:, i, 3:], np.ones(len(times), dtype=np.bool_))
        for i in range(len(TRACKERS))
    )
    found = {"format": "Beat Saber replay"}
    if device:
        found["device"] = device
    return RawRecording(tracks=(head, left, right), found=found, reading=Reading(axes="RUF", rotation="xyzw"))


def _skip_info(content: bytes) -> tuple[int, str]:
    """Offset of the section after the first, and the devices' names; struct.error or ValueError if broken."""
    if content[5:6] != _INFO:
        raise ValueError
    offset, strings = _strings(content, 6, 13)
    offset, _ = _strings(content, offset + 4, 3)
    # jump distance, left-handed flag, height, start, fail time, speed
    return offset + struct.calcsize("<fBffff"), ", ".join(text for text in strings[7:9] if text)


def _strings(content: bytes, offset: int, count: int) -> tuple[int, list[str]]:
    """The offset after `count` length-prefixed strings, and the strings."""
    out: list[str] = []
    for _ in range(count):
        (length,) = struct.unpack_from("<i", content, offset)
        end = offset + 4 + length
        if length < 0 or end > len(content):
            raise ValueError
        # player names come in broken encodings
        out.append(content[offset + 4 : end].decode("utf-8", "replace"))
        offset = end
    return offset, out


def recognise(content: bytes) -> bool:
    """Whether a file looks like a Beat Saber replay, whatever its version."""
    return content.startswith(_MAGIC)

"""Formats that are known, and not read: they are refused by their names."""

from __future__ import annotations

from ...errors import InputError
from ..raw import RawRecording

_LOOKED_AT = 4096
_NAMES = (b"\x03info\x00", b"frames\x00", b"software\x00")


def is_xror(content: bytes) -> bool:
    """Whether a file is XROR: BSON that begins with the session, with frames packed by fpzip."""
    head = content[:_LOOKED_AT]
    return not head[:1].isspace() and b"\0" in head[:8] and all(name in head for name in _NAMES)


def refuse_xror(content: bytes, file: str) -> RawRecording:
    """Raise InputError."""
    raise InputError(
        f"{file}: XROR, whose frames are packed by fpzip, is not read; convert it to BSOR or CSV with the tools of XROR"
    )

"""One mocap file, as all readers give it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..body.motion import Motion


@dataclass(frozen=True, slots=True, eq=False)
class Take:
    """One mocap file, read into Footwork's convention."""

    name: str
    """File name without folder and extension."""
    file: str
    """File name as given."""
    sha256: str
    motion: Motion
    found: dict[str, str]
    """What the reader decided, for people: unit, up axis, preset, facing, floor ... in order of printing."""
    doubts: tuple[str, ...]
    """One line for each thing a person should look at."""


def repeated(takes: Sequence[Take]) -> tuple[str, ...]:
    """One line for each take whose file has the content of an earlier one: its motion would count twice."""
    first: dict[str, Take] = {}
    lines: list[str] = []
    for take in takes:
        known = first.setdefault(take.sha256, take)
        if known is not take and take.sha256:
            lines.append(f"{take.file}: the same content as {known.file}; it counts twice, give it once")
    return tuple(lines)

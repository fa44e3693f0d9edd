"""One mocap file, as all readers give it."""

from __future__ import annotations

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

"""CSV tables of other recorders, each described by a JSON file in presets/recording_layouts.

A layout names the columns of time and of every tracker's position and quaternion (w, x, y, z in this order),
the units and the axes. A new recorder that writes one row a frame needs a new layout and no code.
"""

from __future__ import annotations

import functools
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np

from ..errors import InputError
from .raw import Format, RawRecording, Track, change_axes
from .recording import TRACKERS
from .table import columns_of, decode, read_columns

FOLDER = Path(__file__).resolve().parents[2] / "presets" / "recording_layouts"
_HEADER_BYTES = 16384
_SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001}


@dataclass(frozen=True, slots=True)
class Layout:
    """How a table's columns are to be read."""

    name: str
    columns: tuple[str, ...]
    """Time, then for head, left and right: position x y z, quaternion w x y z."""
    seconds: float
    metres: float
    axes: str
    """Where x, y and z point, as in `raw.change_axes`."""
    on_floor: bool


def load_layout(path: Path) -> Layout:
    """A layout from its JSON file.

    Raises:
        InputError: the file is not a layout; the line says what is missing.
    """
    try:
        data = cast(dict[str, Any], json.loads(path.read_text("utf-8")))
        columns = [data["time"]]
        for tracker in TRACKERS:
            position, rotation = data[tracker]["position"], data[tracker]["rotation"]
            if len(position) != 3 or len(rotation) != 4:
                raise ValueError(f"{tracker} needs 3 position and 4 rotation columns")
            columns += [*position, *rotation]
        axes = str(data["axes"])
        if sorted(
            {"R": "x", "L": "x", "U": "z", "D": "z", "F": "y", "B": "y"}[letter] for letter in axes
        ) != list("xyz"):
            raise ValueError(f"axes {axes!r} are not three of R/L, U/D, F/B")
        return Layout(
            name=str(data["name"]),
            columns=tuple(str(column) for column in columns),
            seconds=_SECONDS[data["time_unit"]],
            metres=_METRES[data["unit"]],
            axes=axes,
            on_floor=bool(data["on_floor"]),
        )
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise InputError(
            f"{path}: not a recording layout ({error}); compare it with its neighbours"
        ) from error


def read_table(content: bytes, file: str, layout: Layout) -> RawRecording:
    """Samples of a table in a given layout.

    Raises:
        InputError: a short row or a cell that is no number, with its line.
    """
    values, _ = read_columns(decode(content, file), 0, layout.columns, file)
    times = (values[:, 0] - values[0, 0]) * layout.seconds
    poses = values[:, 1:].reshape(len(values), len(TRACKERS), 7)
    positions, rotations = change_axes(poses[..., :3] * layout.metres, poses[..., 3:], layout.axes)
    head, left, right = (
        Track(times, positions[:, i], rotations[:, i], np.ones(len(times), dtype=np.bool_))
        for i in range(len(TRACKERS))
    )
    return RawRecording(tracks=(head, left, right), found={"format": layout.name}, on_floor=layout.on_floor)


def _recognise(content: bytes, layout: Layout) -> bool:
    first = content[:_HEADER_BYTES].removeprefix(b"\xef\xbb\xbf").split(b"\n", 1)[0]
    return set(layout.columns) <= set(columns_of(first.decode("utf-8", "replace")))


@functools.cache
def formats() -> tuple[Format, ...]:
    """A format for every layout in the presets, by file name."""
    layouts = [load_layout(path) for path in sorted(FOLDER.glob("*.json"))]
    return tuple(
        Format(
            layout.name,
            functools.partial(_recognise, layout=layout),
            functools.partial(read_table, layout=layout),
        )
        for layout in layouts
    )

"""CSV tables of other recorders, each described by a JSON file (presets/recording_layouts, the user's folder).

A layout names the columns of time and of every tracker's position and quaternion (w, x, y, z in this order),
the units and the axes. A new recorder that writes one row a frame needs a new layout and no code.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..presets import Presets, check_keys, check_text, check_texts, load_presets, read_preset
from .raw import RawRecording, Reading, Track
from .reading.dress import header_line
from .recording import TRACKERS
from .table import columns_of, decode, read_columns

KIND = "recording_layouts"
"""Sub-folder of the presets."""
_HEADER_BYTES = 16384
_SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001}
_AXES = ("RL", "UD", "FB")


@dataclass(frozen=True, slots=True)
class TableLayout:
    """How a table's columns are to be read."""

    name: str
    columns: tuple[str, ...]
    """Time, then for head, left and right: position x y z, quaternion w x y z."""
    seconds: float
    metres: float
    axes: str
    """Where x, y and z point, as in `raw.change_axes`."""
    on_floor: bool


def layouts() -> Presets[TableLayout]:
    """The layouts of the user's folder, then those that ship."""
    return load_presets(KIND, read_layout)


def read_layout(path: str | os.PathLike[str]) -> TableLayout:
    """A layout from its JSON file.

    Raises:
        InputError: the file is not a layout; the line says what is wrong.
    """
    return read_preset(path, _parse, "recording layout")


def read_table(content: bytes, file: str, layout: TableLayout) -> RawRecording:
    """Samples of a table in a given layout.

    Raises:
        InputError: a short row or a cell that is no number, with its line.
    """
    lines = decode(content, file)
    values, _ = read_columns(lines, header_line(lines), layout.columns, file)
    times = (values[:, 0] - values[0, 0]) * layout.seconds
    poses = values[:, 1:].reshape(len(values), len(TRACKERS), 7)
    head, left, right = (
        Track(times, poses[:, i, :3], poses[:, i, 3:], np.ones(len(times), dtype=np.bool_))
        for i in range(len(TRACKERS))
    )
    return RawRecording(
        tracks=(head, left, right),
        found={"format": layout.name},
        on_floor=layout.on_floor,
        reading=Reading(axes=layout.axes, metres=layout.metres),
    )


def recognise(content: bytes, layout: TableLayout) -> bool:
    """Whether a file begins with a header that has every column of a layout."""
    lines = content[:_HEADER_BYTES].removeprefix(b"\xef\xbb\xbf").decode("utf-8", "replace").splitlines()
    return bool(lines) and set(layout.columns) <= set(columns_of(lines[header_line(lines)]))


def _parse(content: Any) -> TableLayout:
    data = check_keys(content, ("name", "time", "time_unit", "unit", "axes", "on_floor", *TRACKERS))
    columns = [check_text(data["time"], "'time'")]
    for tracker in TRACKERS:
        poses = check_keys(data[tracker], ("position", "rotation"), where=f"{tracker!r}")
        columns += check_texts(poses["position"], f"{tracker!r}: 'position'", count=3)
        columns += check_texts(poses["rotation"], f"{tracker!r}: 'rotation'", count=4)
    repeated = [column for column in columns if columns.count(column) > 1]
    if repeated:
        raise ValueError(f"the column {repeated[0]!r} is used twice")
    axes = check_text(data["axes"], "'axes'")
    if len(axes) != 3 or any(sum(letter in axes for letter in pair) != 1 for pair in _AXES):
        raise ValueError(f"'axes' {axes!r} is not one each of R or L, U or D, F or B")
    if not isinstance(data["on_floor"], bool):
        raise ValueError("'on_floor' is neither true nor false")
    return TableLayout(
        name=check_text(data["name"], "'name'"),
        columns=tuple(columns),
        seconds=_unit(data["time_unit"], _SECONDS, "'time_unit'"),
        metres=_unit(data["unit"], _METRES, "'unit'"),
        axes=axes,
        on_floor=data["on_floor"],
    )


def _unit(value: Any, units: dict[str, float], where: str) -> float:
    if not isinstance(value, str) or value not in units:
        raise ValueError(f"{where} {value!r} is none of {', '.join(units)}")
    return units[value]

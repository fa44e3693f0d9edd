"""A hundred ways in which recorders might write three trackers, ten of each kind, of invented programs.

Each takes a `Motion` and gives the bytes of a file, or a folder's files by name.
"""

from __future__ import annotations

from collections.abc import Callable

from . import json_files, tables
from .writing import Files, Motion

KINDS: dict[str, Callable[[], dict[str, Callable[[Motion], Files]]]] = {
    "JSON objects": json_files.json_objects,
    "JSON arrays": json_files.json_arrays,
    "JSON lines": json_files.json_lines,
    "matrices": tables.matrix_tables,
    "angles": tables.angle_tables,
    "one row a device": tables.long_tables,
    "one file a device": tables.folders,
    "vectors in a cell": tables.vectors_in_cells,
    "text dress": tables.text_dress,
    "clocks": tables.clocks,
}
LAYOUTS = {f"{kind}: {name}": make for kind, layouts in KINDS.items() for name, make in layouts().items()}

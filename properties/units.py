"""The choice of a file's unit, which takes and recordings have."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from bpy.props import EnumProperty

_NAMES = {
    "m": "Metres",
    "dm": "Decimetres",
    "cm": "Centimetres",
    "mm": "Millimetres",
    "ft": "Feet",
    "in": "Inches",
    "CMU": "CMU's Unit of 5.64 cm",
}


def unit_property(units: Iterable[str], update: Callable[[Any, Any], None]) -> Any:
    """A property to choose one of some units, or none.

    Args:
        units: their short names.
        update: called when another one is chosen.
    """
    return EnumProperty(
        name="Unit",
        description="Unit of the file's lengths",
        items=[
            ("AUTO", "Automatic", "The unit that makes a person of usual size"),
            *((unit, _NAMES[unit], f"The file's lengths are in this unit: {unit}") for unit in units),
        ],
        update=update,
    )

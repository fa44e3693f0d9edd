"""Blender properties made from the settings dataclasses of core, so that every control is described once."""

from __future__ import annotations

from dataclasses import Field, fields
from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty

from ..core.settings import BakeSettings, DatabaseSettings
from ..nn.settings import TrainSettings

UNITS: dict[str, dict[str, Any]] = {
    "m": {"subtype": "DISTANCE"},
    "s": {"subtype": "TIME_ABSOLUTE", "unit": "TIME_ABSOLUTE"},
    "m/s": {"unit": "VELOCITY"},
}
"""How Blender shows our units; numbers of other units are shown plain."""
DIGITS = {"learning_rate": 5, "decay": 3}
"""Places after the point for settings that are usually small."""


def property_of(item: Field[Any]) -> Any:
    """The Blender property of one settings field."""
    meta, default = item.metadata, item.default
    shared: dict[str, Any] = {"name": meta["label"], "description": meta["help"], "default": default}
    if isinstance(default, bool):
        return BoolProperty(**shared)
    if isinstance(default, str):
        choices = [(key, key.replace("-", " ").title(), text) for key, text in meta["choices"].items()]
        return EnumProperty(**shared, items=choices)
    ends = (("min", "low"), ("max", "high"))
    bounds: dict[str, Any] = {end: meta[name] for end, name in ends if meta[name] is not None}
    if isinstance(default, int):
        return IntProperty(**shared, **bounds)
    precision = DIGITS.get(item.name, 3 if meta["unit"] in UNITS else 2)
    return FloatProperty(**shared, **bounds, **UNITS.get(meta["unit"], {}), step=1, precision=precision)


def property_group(name: str, settings: type) -> type[bpy.types.PropertyGroup]:
    """A property group class with one property for each field of a settings dataclass."""
    annotations = {item.name: property_of(item) for item in fields(settings)}
    return type(
        name, (bpy.types.PropertyGroup,), {"__annotations__": annotations, "__doc__": settings.__doc__}
    )


FOOTWORK_PG_database_settings = property_group("FOOTWORK_PG_database_settings", DatabaseSettings)
FOOTWORK_PG_train_settings = property_group("FOOTWORK_PG_train_settings", TrainSettings)
FOOTWORK_PG_bake_settings = property_group("FOOTWORK_PG_bake_settings", BakeSettings)

CLASSES = (FOOTWORK_PG_database_settings, FOOTWORK_PG_train_settings, FOOTWORK_PG_bake_settings)

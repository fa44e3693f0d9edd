"""Settings dataclasses of core, read from the Blender properties that were made from them."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Any, TypeVar

import bpy

from ..core.settings import check

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Settings = TypeVar("Settings", bound="DataclassInstance")


def read_settings(properties: bpy.types.PropertyGroup, settings: type[Settings]) -> Settings:
    """The settings that a property group of the same field names holds.

    Blender stores single precision: numbers are given back as typed, so that a bake in the window and one on the
    command line are the same.

    Raises:
        InputError: a value is out of its bounds.
    """
    values: dict[str, Any] = {}
    for item in fields(settings):
        value = getattr(properties, item.name)
        if isinstance(value, float):
            value = _as_typed(value, item.default, item.metadata["low"], item.metadata["high"])
        values[item.name] = value
    result = settings(**values)
    check(result)
    return result


def typed(value: float) -> float:
    """A number as it was typed: Blender's properties hold single precision."""
    return float(f"{value:.7g}")


def _as_typed(value: float, default: Any, low: float | None, high: float | None) -> float:
    number = typed(value)
    if number == typed(default):
        return default
    return min(max(number, -1e30 if low is None else low), 1e30 if high is None else high)

"""Short texts in panels: facts in two columns, and long lines wrapped to the width of the sidebar."""

import textwrap
from typing import Any

import bpy


def facts(context: bpy.types.Context, layout: bpy.types.UILayout, found: str) -> None:
    """Lines of "name<tab>value" as two columns, the second wrapped."""
    width = max(int(0.78 * width_of(context)), 12)
    column = layout.column(align=True)
    column.scale_y = 0.8
    for line in found.splitlines():
        name, _, value = line.partition("\t")
        for number, part in enumerate(textwrap.wrap(value, width) or [""]):
            split = column.split(factor=0.35)
            left = split.row()
            left.active = False
            left.label(text="" if number else name.capitalize())
            split.label(text=part)


def notes(context: bpy.types.Context, layout: bpy.types.UILayout, text: str, icon: Any = "ERROR") -> None:
    """Each line of a text as a wrapped note with an icon."""
    for line in text.splitlines():
        column = layout.column(align=True)
        column.scale_y = 0.8
        for number, part in enumerate(textwrap.wrap(line, width_of(context))):
            column.label(text=part, icon=icon if number == 0 else "BLANK1")


def width_of(context: bpy.types.Context) -> int:
    """How many letters fit in a line of the region."""
    region = context.region
    scale = context.preferences.system.ui_scale or 1.0
    width = region.width / scale if region is not None and region.width > 1 else 260.0
    return max(int((width - 70.0) / 6.2), 20)

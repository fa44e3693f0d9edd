"""Lists of takes and databases."""

from typing import Any

import bpy

STATE_ICONS: dict[str, Any] = {"NEW": "QUESTION", "OK": "NONE", "DOUBT": "ERROR", "FAULT": "CANCEL"}


class FOOTWORK_UL_takes(bpy.types.UIList):
    """Takes: tick, name, length, state"""

    bl_idname = "FOOTWORK_UL_takes"

    def draw_item(self, context, layout, data, item, icon, active_data, active_property, index=0, flt_flag=0):
        row = layout.row(align=True)
        row.prop(item, "use", text="")
        name = row.row()
        name.active = item.use and item.state != "FAULT"
        name.label(text=item.name, icon=STATE_ICONS[item.state])
        length = row.row()
        length.alignment = "RIGHT"
        length.active = False
        length.label(text=duration(item.seconds) if item.seconds else "")


class FOOTWORK_UL_databases(bpy.types.UIList):
    """Motion databases: tick, name, height range, length"""

    bl_idname = "FOOTWORK_UL_databases"

    def draw_item(self, context, layout, data, item, icon, active_data, active_property, index=0, flt_flag=0):
        row = layout.row(align=True)
        row.prop(item, "use", text="")
        name = row.row()
        name.active = item.use
        name.label(text=item.name)
        facts = row.row()
        facts.alignment = "RIGHT"
        facts.active = False
        facts.label(text=f"{item.height_low:.2f}-{item.height_high:.2f}  {duration(item.seconds)}")


def duration(seconds: float) -> str:
    """Minutes and seconds."""
    whole = round(seconds)
    return f"{whole // 60}:{whole % 60:02d}"


CLASSES = (FOOTWORK_UL_takes, FOOTWORK_UL_databases)

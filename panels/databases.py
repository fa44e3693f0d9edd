"""2: the motion databases that a bake chooses from."""

import bpy

from ..operators.rows import active
from ..properties.scene import FOOTWORK_PG_scene, footwork_of
from . import text
from .parts import Part


class FOOTWORK_PT_databases(Part, bpy.types.Panel):
    """Motion databases that the bake chooses from"""

    bl_idname = "FOOTWORK_PT_databases"
    bl_label = "2  Databases"

    def step_icon(self, footwork: FOOTWORK_PG_scene) -> str:
        return "CHECKMARK" if any(row.use for row in footwork.databases) else ""

    def draw(self, context: bpy.types.Context) -> None:
        layout, footwork = self.layout, footwork_of(context.scene)
        row = layout.row()
        row.template_list(
            "FOOTWORK_UL_databases", "", footwork, "databases", footwork, "database_index", rows=3
        )
        buttons = row.column(align=True)
        buttons.operator("footwork.add_database", text="", icon="ADD")
        buttons.operator("footwork.remove_database", text="", icon="REMOVE")
        if len(footwork.databases) > 1:
            buttons.operator("footwork.move_database", text="", icon="TRIA_UP").step = -1
            buttons.operator("footwork.move_database", text="", icon="TRIA_DOWN").step = 1
        database = active(footwork.databases, footwork.database_index)
        if database is None:
            text.notes(
                context,
                layout,
                "Starter motion, while the list is empty. Build a database above, or add one that was built before",
                "INFO",
            )
            return
        heights = layout.row(align=True)
        heights.use_property_split = True
        heights.use_property_decorate = False
        heights.prop(database, "height_low", text="Height Range")
        heights.prop(database, "height_high", text="")
        header, body = layout.panel("FOOTWORK_database_found", default_closed=True)
        header.label(text="In This Database")
        if body:
            text.facts(context, body, database.found)


CLASSES = (FOOTWORK_PT_databases,)

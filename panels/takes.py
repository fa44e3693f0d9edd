"""1: motion-capture files, and the database that is built from them."""

import bpy

from ..operators.databases import database_path
from ..operators.rows import active
from ..properties.scene import FOOTWORK_PG_scene, footwork_of
from . import text
from .lists import duration
from .parts import Part, job_button, job_progress


class FOOTWORK_PT_takes(Part, bpy.types.Panel):
    """Motion-capture files, and the database that is built from them"""

    bl_idname = "FOOTWORK_PT_takes"
    bl_label = "1  Takes"

    def draw_header_preset(self, context: bpy.types.Context) -> None:
        takes = [take for take in footwork_of(context.scene).takes if take.use]
        if takes:
            self.layout.label(text=duration(sum(take.seconds for take in takes)))

    def draw(self, context: bpy.types.Context) -> None:
        layout, footwork = self.layout, footwork_of(context.scene)
        row = layout.row()
        row.template_list(
            "FOOTWORK_UL_takes",
            "",
            footwork,
            "takes",
            footwork,
            "take_index",
            rows=5 if footwork.takes else 3,
        )
        buttons = row.column(align=True)
        buttons.operator("footwork.add_takes", text="", icon="ADD")
        buttons.operator("footwork.remove_take", text="", icon="REMOVE")
        if footwork.takes:
            buttons.separator()
            buttons.operator("footwork.move_take", text="", icon="TRIA_UP").step = -1
            buttons.operator("footwork.move_take", text="", icon="TRIA_DOWN").step = 1
            buttons.separator()
            buttons.menu("FOOTWORK_MT_takes", text="", icon="DOWNARROW_HLT")
        job_progress(layout, "footwork.inspect_takes")
        take = active(footwork.takes, footwork.take_index)
        if take is None:
            text.notes(
                context,
                layout,
                "Add motion-capture files (BVH, MVNX, FBX, glTF), or drop them into the viewport",
                "INFO",
            )
            return
        found, body = layout.panel("FOOTWORK_take_found", default_closed=True)
        found.label(text="In This Take")
        if body:
            text.facts(context, body, take.found)
            reading = body.column()
            reading.use_property_split = True
            reading.use_property_decorate = False
            for name in ("unit", "up", "rate"):
                reading.prop(take, name)
            if take.state == "NEW":
                reading.operator("footwork.inspect_takes", text="Read Again", icon="FILE_REFRESH")
            body.prop(take, "leave_out", placeholder="seconds, such as 0-1.5, 30-32")
            body.prop(take, "contacts", placeholder="such as L:planted:1.2-1.65")
            body.operator("footwork.use_edited_contacts", icon="ACTION")
        text.notes(context, layout, take.doubts, "CANCEL" if take.state == "FAULT" else "ERROR")

        settings = footwork.database_settings
        column = layout.column()
        column.use_property_split = True
        column.use_property_decorate = False
        column.prop(settings, "mirror")
        column.prop(settings, "body_height")
        heights = column.row(align=True)
        heights.prop(settings, "height_low", text="Height Range")
        heights.prop(settings, "height_high", text="")
        column.prop(footwork, "database_path", placeholder=database_path(footwork).name)
        self._advanced(layout, footwork)
        job_button(layout, "footwork.build_database", "FILE_NEW", 1.3)

    def _advanced(self, layout: bpy.types.UILayout, footwork: FOOTWORK_PG_scene) -> None:
        header, body = layout.panel("FOOTWORK_database_advanced", default_closed=True)
        header.label(text="Advanced")
        if not body:
            return
        body.use_property_split = True
        body.use_property_decorate = False
        settings = footwork.database_settings
        for name in settings.__annotations__:
            if name not in ("mirror", "body_height", "height_low", "height_high"):
                body.prop(settings, name)
        body.prop(footwork, "database_tags")
        body.prop(footwork, "database_skeleton")


class FOOTWORK_MT_takes(bpy.types.Menu):
    """More for takes"""

    bl_idname = "FOOTWORK_MT_takes"
    bl_label = "Takes"

    def draw(self, context: bpy.types.Context) -> None:
        layout, footwork = self.layout, footwork_of(context.scene)
        layout.operator("footwork.inspect_takes", text="Read All Again", icon="FILE_REFRESH").which = "ALL"
        take = active(footwork.takes, footwork.take_index)
        if take is not None:
            show = layout.operator("footwork.import_take", text="Show Take in Scene", icon="ARMATURE_DATA")
            show.filepath = bpy.path.abspath(take.path)
        layout.operator("footwork.simulate_recording", icon="TRACKER")
        layout.separator()
        layout.operator("footwork.clear_takes", icon="TRASH")


CLASSES = (FOOTWORK_MT_takes, FOOTWORK_PT_takes)

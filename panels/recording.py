"""4: headset and controllers over time."""

import bpy

from ..properties.scene import FOOTWORK_PG_scene, footwork_of
from . import text
from .parts import Part


class FOOTWORK_PT_recording(Part, bpy.types.Panel):
    """Headset and controllers over time"""

    bl_idname = "FOOTWORK_PT_recording"
    bl_label = "4  Recording"

    def step_icon(self, footwork: FOOTWORK_PG_scene) -> str:
        if footwork.recording_source == "OBJECTS":
            return "CHECKMARK" if footwork.head else ""
        return "CHECKMARK" if footwork.recording_path and footwork.recording_state != "FAULT" else ""

    def draw(self, context: bpy.types.Context) -> None:
        layout, footwork = self.layout, footwork_of(context.scene)
        layout.row().prop(footwork, "recording_source", expand=True)
        column = layout.column()
        column.use_property_split = True
        column.use_property_decorate = False
        if footwork.recording_source == "OBJECTS":
            for name in ("head", "left", "right"):
                column.prop(footwork, name)
            column.prop(footwork, "tracker_axes")
            _eye_height(column, footwork)
            column.prop(footwork.reading, "swap_hands")
            column.prop(footwork.reading, "force")
            return
        if not footwork.recording_path:
            column.operator("footwork.load_recording", icon="FILEBROWSER")
            return
        row = column.row(align=True)
        row.prop(footwork, "recording_path", text="")
        row.operator("footwork.inspect_recording", text="", icon="FILE_REFRESH")
        _eye_height(column, footwork)
        part = column.row(align=True)
        part.prop(footwork, "recording_from", text="Part")
        part.prop(footwork, "recording_to", text="")
        _reading(layout, footwork)
        header, body = layout.panel("FOOTWORK_recording_found", default_closed=True)
        header.label(text="In This Recording")
        if body:
            text.facts(context, body, footwork.recording_found)
        text.notes(
            context,
            layout,
            footwork.recording_doubts,
            "CANCEL" if footwork.recording_state == "FAULT" else "ERROR",
        )
        layout.operator("footwork.show_recording", icon="EMPTY_ARROWS")


def _reading(layout: bpy.types.UILayout, footwork: FOOTWORK_PG_scene) -> None:
    """What the file does not say, or says wrongly."""
    header, body = layout.panel("FOOTWORK_recording_reading", default_closed=True)
    header.label(text="How to Read It")
    if body:
        column = body.column()
        column.use_property_split = True
        column.use_property_decorate = False
        for name in ("axes", "unit", "rotation", "rate", "swap_hands", "mounts"):
            column.prop(footwork.reading, name)
        if footwork.reading.mounts == "CUSTOM":
            for name in ("headset_ahead", "headset_above", "controller_reach", "controller_pitch"):
                column.prop(footwork.reading, name)
        for name in ("auto_trim", "force"):
            column.prop(footwork.reading, name)
        column.operator("footwork.map_recording", icon="PRESET")


def _eye_height(layout: bpy.types.UILayout, footwork: FOOTWORK_PG_scene) -> None:
    """Given by hand, or greyed what the recording says."""
    row = layout.row(heading="Eye Height", align=True)
    row.prop(footwork, "use_eye_height", text="")
    value = row.row(align=True)
    value.active = footwork.use_eye_height
    value.prop(footwork, "eye_height", text="")


CLASSES = (FOOTWORK_PT_recording,)

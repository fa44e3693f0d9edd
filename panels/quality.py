"""7: how good the last bake is."""

from typing import Any

import bpy

from ..properties.scene import FOOTWORK_PG_scene, footwork_of
from . import overlays, text
from .parts import Part

RATING_ICONS: dict[str, Any] = {"GOOD": "CHECKMARK", "POOR": "ERROR", "NONE": "BLANK1"}


class FOOTWORK_PT_quality(Part, bpy.types.Panel):
    """How good the last bake is"""

    bl_idname = "FOOTWORK_PT_quality"
    bl_label = "7  Quality"

    def step_icon(self, footwork: FOOTWORK_PG_scene) -> str:
        if not footwork.figures:
            return ""
        return "ERROR" if any(row.good == "POOR" for row in footwork.figures) else "CHECKMARK"

    def draw(self, context: bpy.types.Context) -> None:
        layout, footwork = self.layout, footwork_of(context.scene)
        known = bool(footwork.figures)
        layout.label(
            text=footwork.figures_of if known else "Nothing baked yet", icon="ACTION" if known else "INFO"
        )
        column = layout.column(align=True)
        for index, row in enumerate(footwork.figures):
            split = column.split(factor=0.55)
            split.label(text=row.name, icon=RATING_ICONS[row.good])
            value = split.row()
            value.alignment = "LEFT"
            value.operator("footwork.explain_figure", text=row.value, emboss=False).index = index
        toggles = overlays.toggles_of(context.scene)
        column = layout.column(align=True)
        for overlay in overlays.OVERLAYS:
            column.prop(toggles, overlay.name, icon=overlay.icon, toggle=True)
        told = footwork.recording_doubts.splitlines()
        fresh = [line for line in footwork.warnings.splitlines() if line not in told]
        text.notes(context, layout, "\n".join(fresh))


CLASSES = (FOOTWORK_PT_quality,)

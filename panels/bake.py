"""6: the recording becomes an action of the rig."""

import bpy
from bl_ui.utils import PresetPanel

from ..operators.presets import FOLDER
from ..properties.scene import footwork_of
from .parts import Part, job_button, settings_column

MAIN_BAKE_SETTINGS = ("trajectory", "search", "feet", "alpha", "beta")
CAUSAL_SETTINGS = ("beta", "smoothing")
"""Settings that only the causal trajectory uses."""
FITTING_SETTINGS = ("scale_to_rig", "head", "arms")


class FOOTWORK_PT_bake_presets(PresetPanel, bpy.types.Panel):
    """Named sets of bake settings"""

    bl_idname = "FOOTWORK_PT_bake_presets"
    bl_label = "Bake Presets"
    preset_subdir = FOLDER
    preset_operator = "script.execute_preset"
    preset_add_operator = "footwork.add_bake_preset"


class FOOTWORK_PT_bake(Part, bpy.types.Panel):
    """The recording becomes an action of the rig"""

    bl_idname = "FOOTWORK_PT_bake"
    bl_label = "6  Bake"

    def draw_header_preset(self, context: bpy.types.Context) -> None:
        FOOTWORK_PT_bake_presets.draw_panel_header(self.layout)

    def draw(self, context: bpy.types.Context) -> None:
        layout, footwork = self.layout, footwork_of(context.scene)
        settings = footwork.bake
        idle = () if settings.trajectory == "causal" else CAUSAL_SETTINGS
        known = [name for name in settings.__annotations__ if name not in idle]
        layout.use_property_decorate = False
        settings_column(layout, settings, [name for name in MAIN_BAKE_SETTINGS if name in known])
        waiting = layout.column()
        waiting.active = False
        settings_column(waiting, settings, [name for name in MAIN_BAKE_SETTINGS if name in idle])
        grid = layout.grid_flow(row_major=True, columns=2, even_columns=True, align=True)
        for name in FITTING_SETTINGS:
            if name in known:
                grid.prop(settings, name)
        column = layout.column()
        column.use_property_split = True
        column.prop(footwork, "ground")
        column.prop(footwork, "ground_collection", text="Collection")
        column.prop(footwork, "place")
        if footwork.place == "MARKER":
            column.prop(footwork, "place_marker")
        header, body = layout.panel("FOOTWORK_bake_advanced", default_closed=True)
        header.label(text="Advanced")
        if body:
            settings_column(
                body, settings, [n for n in known if n not in MAIN_BAKE_SETTINGS + FITTING_SETTINGS]
            )
        header, body = layout.panel("FOOTWORK_bake_output", default_closed=True)
        header.label(text="Output")
        if body:
            body.use_property_split = True
            body.use_property_decorate = False
            body.prop(footwork, "travel")
            body.prop(footwork, "write")
            if footwork.write != "NEW":
                body.prop(footwork, "blend")
            body.prop(footwork, "fewer_keys")
            for name in (
                "action_name",
                "frame_start",
                "mannequin",
                "fit_range",
                "markers",
                "keep_previous",
            ):
                body.prop(footwork, name)
        job_button(layout, "footwork.bake", "ARMATURE_DATA", 1.6)
        layout.operator("footwork.clear_bake", icon="X")


CLASSES = (FOOTWORK_PT_bake_presets, FOOTWORK_PT_bake)

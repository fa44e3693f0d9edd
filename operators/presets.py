"""Named sets of bake settings: those that ship, and the user's own."""

from dataclasses import fields

import bpy
from bl_operators.presets import AddPresetBase
from bpy.props import EnumProperty

from ..core.settings import BAKE_PRESETS, BakeSettings
from ..properties.scene import footwork_of
from .base import FootworkOperator

FOLDER = "footwork/bake"


class FOOTWORK_OT_add_bake_preset(AddPresetBase, bpy.types.Operator):
    """Keep the bake settings under a name, or remove those of that name"""

    bl_idname = "footwork.add_bake_preset"
    bl_label = "Add Bake Preset"
    bl_options = {"REGISTER", "UNDO"}
    preset_menu = "FOOTWORK_PT_bake_presets"
    preset_subdir = FOLDER
    preset_defines = ["settings = bpy.context.scene.footwork.bake"]
    preset_values = [f"settings.{item.name}" for item in fields(BakeSettings)]


class FOOTWORK_OT_use_bake_preset(FootworkOperator, bpy.types.Operator):
    """Set the bake settings to those that come with Footwork under a name"""

    bl_idname = "footwork.use_bake_preset"
    bl_label = "Use Bake Preset"
    bl_options = {"REGISTER", "UNDO"}

    name: EnumProperty(
        name="Preset",
        description="Which settings",
        items=[(name, name, f"Use the preset {name}") for name in BAKE_PRESETS],
    )

    def work(self, context):
        settings = footwork_of(context.scene).bake
        for item in fields(BakeSettings):
            settings.property_unset(item.name)
        for name, value in BAKE_PRESETS[self.name].items():
            setattr(settings, name, value)


CLASSES = (FOOTWORK_OT_add_bake_preset, FOOTWORK_OT_use_bake_preset)

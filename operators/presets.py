"""Named sets of bake settings: those that ship, and the user's own."""

from dataclasses import fields

import bpy
from bl_operators.presets import AddPresetBase

from ..core.settings import BakeSettings

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


CLASSES = (FOOTWORK_OT_add_bake_preset,)

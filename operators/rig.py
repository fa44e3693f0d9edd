"""The rig: take the active armature, and its role map back to what was detected."""

import bpy

from ..bridge import armature
from ..core.errors import InputError
from ..properties.scene import footwork_of
from .base import FootworkOperator


class FOOTWORK_OT_use_active_rig(FootworkOperator, bpy.types.Operator):
    """Animate the active armature"""

    bl_idname = "footwork.use_active_rig"
    bl_label = "Use Active Armature"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def refusal(cls, context: bpy.types.Context) -> str:
        chosen = context.object is not None and context.object.type == "ARMATURE"
        return "" if chosen else "Select an armature first"

    def work(self, context: bpy.types.Context) -> None:
        obj = context.object
        assert obj is not None
        footwork_of(context.scene).rig = obj
        try:
            armature.armature_to_rig(obj)
        except InputError as error:
            self.tell("WARNING", str(error))


class FOOTWORK_OT_reset_roles(FootworkOperator, bpy.types.Operator):
    """Forget what was set by hand and go back to the bones that were detected"""

    bl_idname = "footwork.reset_roles"
    bl_label = "Reset Role Map"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def refusal(cls, context: bpy.types.Context) -> str:
        rig = footwork_of(context.scene).rig
        if rig is None:
            return "Pick a rig first"
        return "" if armature.role_overrides(rig) else "Nothing was set by hand"

    def work(self, context: bpy.types.Context) -> None:
        armature.set_roles(footwork_of(context.scene).rig, {})


CLASSES = (FOOTWORK_OT_use_active_rig, FOOTWORK_OT_reset_roles)

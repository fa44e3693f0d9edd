"""The rig: take the active armature, and its role map back to what was detected."""

import bpy

from ..bridge import armature
from ..core.body.skeleton import RIG_ROLES
from ..core.errors import InputError
from ..core.mocap.families import KIND, family_of
from ..core.presets import keep_preset
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


class FOOTWORK_OT_keep_roles(FootworkOperator, bpy.types.Operator):
    """Keep this role map as a bone map in your own folder: rigs and takes with such names are known in every scene"""

    bl_idname = "footwork.keep_roles"
    bl_label = "Keep as Bone Map"
    bl_options = {"REGISTER"}

    @classmethod
    def refusal(cls, context: bpy.types.Context) -> str:
        rig = footwork_of(context.scene).rig
        if rig is None:
            return "Pick a rig first"
        missing = [role for role in RIG_ROLES if not armature.role_map(rig).get(role)]
        return f"Set a bone for {missing[0]} first" if missing else ""

    def work(self, context: bpy.types.Context) -> None:
        rig = footwork_of(context.scene).rig
        wanted = {role: bone for role, bone in armature.role_map(rig).items() if bone}
        path = keep_preset(KIND, rig.name, family_of(rig.name, wanted))
        self.tell("INFO", f"{path}: kept for every scene")
        found = {role: bone for role, bone in armature.detected_roles(rig).items() if bone}
        other = [role for role in wanted if found.get(role) != wanted[role]]
        if other:
            self.tell("WARNING", f"{rig.name}: {other[0]} hangs as no limb does and stays this scene's own")


CLASSES = (FOOTWORK_OT_use_active_rig, FOOTWORK_OT_reset_roles, FOOTWORK_OT_keep_roles)

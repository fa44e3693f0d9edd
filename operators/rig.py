"""The rig: take the active armature, and its role map back to what was detected."""

import bpy

from ..bridge import armature
from ..core.errors import InputError


class FOOTWORK_OT_use_active_rig(bpy.types.Operator):
    """Animate the active armature"""

    bl_idname = "footwork.use_active_rig"
    bl_label = "Use Active Armature"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        if context.object is None or context.object.type != "ARMATURE":
            cls.poll_message_set("Select an armature first")
            return False
        return True

    def execute(self, context):
        context.scene.footwork.rig = context.object
        try:
            armature.armature_to_rig(context.object)
        except InputError as error:
            self.report({"WARNING"}, str(error))
        return {"FINISHED"}


class FOOTWORK_OT_reset_roles(bpy.types.Operator):
    """Forget what was set by hand and go back to the bones that were detected"""

    bl_idname = "footwork.reset_roles"
    bl_label = "Reset Role Map"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        rig = context.scene.footwork.rig
        if rig is None:
            cls.poll_message_set("Pick a rig first")
            return False
        if not armature.role_overrides(rig):
            cls.poll_message_set("Nothing was set by hand")
            return False
        return True

    def execute(self, context):
        armature.set_roles(context.scene.footwork.rig, {})
        return {"FINISHED"}


CLASSES = (FOOTWORK_OT_use_active_rig, FOOTWORK_OT_reset_roles)

"""5: the character that is animated, and its role map."""

import bpy

from ..bridge import armature
from ..core.body.skeleton import ARM, CENTRE_ROLES, LEG, RIG_ROLES
from ..properties.role_map import attribute, role_label, role_map_of
from ..properties.scene import FOOTWORK_PG_scene, footwork_of
from . import text
from .parts import Part


class FOOTWORK_PT_rig(Part, bpy.types.Panel):
    """The character that is animated"""

    bl_idname = "FOOTWORK_PT_rig"
    bl_label = "5  Rig"

    def step_icon(self, footwork: FOOTWORK_PG_scene) -> str:
        rig = footwork.rig
        if rig is None or rig.type != "ARMATURE":
            return "" if rig is None else "ERROR"
        mapped = armature.role_map(rig)
        return "CHECKMARK" if all(mapped.get(role) for role in RIG_ROLES) else "ERROR"

    def draw(self, context: bpy.types.Context) -> None:
        layout, footwork = self.layout, footwork_of(context.scene)
        row = layout.row(align=True)
        row.prop(footwork, "rig", text="")
        row.operator("footwork.use_active_rig", text="", icon="RESTRICT_SELECT_OFF")
        rig = footwork.rig
        if rig is None:
            text.notes(context, layout, "Empty: an armature with the database's proportions is made", "INFO")
            return
        preset, _ = armature.detected_preset(rig)
        layout.label(
            text=f"Bone names: {preset}" if preset else "Bone names: not recognised", icon="BONE_DATA"
        )
        missing = [role for role in RIG_ROLES if not armature.role_map(rig).get(role)]
        if missing:
            names = ", ".join(role.replace("_", " ") for role in missing[:4])
            text.notes(
                context, layout, f"Set bones below for: {names}" + (" ..." if len(missing) > 4 else "")
            )
        for doubt in armature.rig_doubts(rig):
            text.notes(context, layout, doubt)
        header, body = layout.panel("FOOTWORK_role_map", default_closed=True)
        header.label(text="Role Map")
        header.operator("footwork.keep_roles", text="", icon="FILE_TICK", emboss=False)
        header.operator("footwork.reset_roles", text="", icon="LOOP_BACK", emboss=False)
        if body:
            _role_map(body, rig)


def _role_map(layout: bpy.types.UILayout, rig: bpy.types.Object) -> None:
    groups = (
        ("", CENTRE_ROLES),
        ("Left", tuple(f"{part}.L" for part in (*ARM, *LEG))),
        ("Right", tuple(f"{part}.R" for part in (*ARM, *LEG))),
    )
    for heading, roles in groups:
        column = layout.column(align=True)
        if heading:
            column.label(text=heading)
        for role in roles:
            split = column.split(factor=0.3, align=True)
            split.label(text=role_label(role))
            split.prop_search(role_map_of(rig), attribute(role), rig.data, "bones", text="")


CLASSES = (FOOTWORK_PT_rig,)

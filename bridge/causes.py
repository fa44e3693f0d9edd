"""Why a bone is not where its keys put it: what on the armature acts beside them."""

from __future__ import annotations

import bpy


def cause_of(obj: bpy.types.Object, name: str) -> str:
    """The likeliest cause on the armature object or on one of its bones, as it is now."""
    assert isinstance(obj.data, bpy.types.Armature)
    return _of_armature(obj, obj.data) or _of_bones(obj, obj.pose.bones[name]) or _of_object(obj) or "unknown"


def _of_armature(obj: bpy.types.Object, armature: bpy.types.Armature) -> str:
    if armature.is_editmode:
        return "the armature is in Edit Mode"
    if armature.pose_position == "REST":
        return "the armature is shown in rest position"
    data = obj.animation_data
    if data is None or data.action is None:
        return "the action is not assigned to the object"
    if any(track.is_solo for track in data.nla_tracks):
        return "an NLA track is solo and plays instead of the action"
    if data.action_influence < 1.0 or data.action_blend_type != "REPLACE":
        return "the action's influence or blending mode"
    return ""


def _of_bones(obj: bpy.types.Object, bone: bpy.types.PoseBone) -> str:
    line = (bone, *bone.parent_recursive)
    for other in (*line, *bone.children_recursive):
        for constraint in other.constraints:
            # what inverse kinematics moves lies above the bone that has it
            if (other in line or constraint.type in ("IK", "SPLINE_IK")) and not constraint.mute:
                kind = "inverse kinematics" if constraint.type in ("IK", "SPLINE_IK") else "constraint"
                return f"the {kind} {constraint.name} on {other.name}"
    data = obj.animation_data
    for other in line:
        paths = [driver.data_path for driver in ([] if data is None else data.drivers)]
        if any(path.startswith(other.path_from_id()) for path in paths):
            return f"a driver on {other.name}"
    for other in line:
        if any(abs(scale - 1.0) > 1e-4 for scale in other.scale):
            return f"the scale of {other.name}"
    for other in line:
        if not other.bone.use_local_location and other.location.length > 1e-6:
            return f"Local Location is off on {other.name}"
        if other.parent is not None and not other.bone.use_inherit_rotation:
            return f"Inherit Rotation is off on {other.name}"
    return ""


def _of_object(obj: bpy.types.Object) -> str:
    data = obj.animation_data
    if obj.parent is not None:
        return f"its parent {obj.parent.name} moves it"
    if any(not constraint.mute for constraint in obj.constraints):
        return "a constraint moves the object"
    if max(*obj.scale[:]) - min(*obj.scale[:]) > 1e-4:
        return "the object's scale differs between axes"
    if data is not None and any(not track.mute for track in data.nla_tracks):
        return "NLA tracks play below the bake"
    return ""

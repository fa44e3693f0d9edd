"""The role map of an armature object: which bone plays which role."""

import bpy
from bpy.props import StringProperty

from ..bridge import armature
from ..core.body.skeleton import ROLES

NAME = "footwork"
"""Property of an object that holds it."""


def attribute(role: str) -> str:
    """Name of a role's property in the role map: a dot cannot be in one."""
    return role.replace(".", "_")


def role_label(role: str) -> str:
    """A role in people's words, without its side."""
    return role.partition(".")[0].replace("_", " ").capitalize()


def _armature_of(group: bpy.types.PropertyGroup) -> bpy.types.Object | None:
    obj = group.id_data
    return obj if isinstance(obj, bpy.types.Object) and obj.type == "ARMATURE" else None


def _bone_property(role: str):
    def read(self: bpy.types.PropertyGroup) -> str:
        obj = _armature_of(self)
        return "" if obj is None else armature.role_map(obj).get(role, "")

    def write(self: bpy.types.PropertyGroup, bone: str) -> None:
        obj = _armature_of(self)
        if obj is not None:
            armature.set_role(obj, role, bone)

    side = {"L": "left ", "R": "right "}.get(role.partition(".")[2], "")
    return StringProperty(
        name=role_label(role),
        description=f"Bone that moves as the {side}{role_label(role).lower()}; empty for none",
        get=read,
        set=write,
    )


FOOTWORK_PG_role_map = type(
    "FOOTWORK_PG_role_map",
    (bpy.types.PropertyGroup,),
    {
        "__annotations__": {attribute(role): _bone_property(role) for role in ROLES},
        "__doc__": "Which bone plays which role: what was detected, until it is set by hand.",
    },
)


def role_map_of(obj: bpy.types.Object) -> bpy.types.PropertyGroup:
    """The role map of an object, a property under the `attribute` of each role."""
    return getattr(obj, NAME)


CLASSES = (FOOTWORK_PG_role_map,)

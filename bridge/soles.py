"""Soles of a rig: the lowest vertices that its feet carry, as Blender evaluates the mesh at rest."""

from __future__ import annotations

from collections.abc import Generator, Mapping
from contextlib import contextmanager
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.body.skeleton import SIDES

Array = NDArray[np.floating[Any]]

_CARRIED = 0.5
"""Weight of a foot's bones from which a vertex is the foot's."""


def sole_depth(obj: bpy.types.Object, roles: Mapping[str, str]) -> float | None:
    """How far the soles are under the toe joints (ankles of rigs without), in the scene's units at rest.

    The lower foot counts. None where no mesh moves with the feet.

    Args:
        obj: the armature object.
        roles: role -> bone name.
    """
    meshes = [mesh for mesh in bpy.data.objects if mesh.type == "MESH" and _moves_with(mesh, obj)]
    if not meshes or any(f"foot.{side}" not in roles for side in SIDES):
        return None
    bones = obj.pose.bones
    groups: set[str] = set()
    joints: list[str] = []
    part = "toe" if all(f"toe.{side}" in roles for side in SIDES) else "foot"
    for side in SIDES:
        foot = bones.get(roles[f"foot.{side}"])
        joint = bones.get(roles[f"{part}.{side}"])
        if foot is None or joint is None:
            return None
        joints.append(joint.name)
        for own in (foot, joint):
            below: Any = own.children_recursive
            groups |= {own.name, *(bone.name for bone in below)}
    data: Any = obj.data
    heights = [float((obj.matrix_world @ data.bones[name].head_local).z) for name in joints]
    with _at_rest(obj):
        lowest = [low for mesh in meshes if (low := _lowest(mesh, obj, groups)) is not None]
    return float(np.mean(heights)) - min(lowest) if lowest else None


def _moves_with(mesh: bpy.types.Object, armature: bpy.types.Object) -> bool:
    return any(
        isinstance(modifier, bpy.types.ArmatureModifier) and modifier.object == armature
        for modifier in mesh.modifiers
    )


@contextmanager
def _at_rest(obj: bpy.types.Object) -> Generator[None]:
    """The time in which an armature shows its rest pose."""
    data: Any = obj.data
    before = data.pose_position
    if before == "REST":
        yield
        return
    data.pose_position = "REST"
    bpy.context.view_layer.update()
    try:
        yield
    finally:
        data.pose_position = before
        bpy.context.view_layer.update()


def _lowest(mesh: bpy.types.Object, armature: bpy.types.Object, groups: set[str]) -> float | None:
    """Height in the world of the lowest vertex that some bones carry; None where they carry none."""
    wanted = {group.index for group in mesh.vertex_groups if group.name in groups}
    if not wanted:
        return None
    evaluated = mesh.evaluated_get(bpy.context.evaluated_depsgraph_get())
    world = np.array(mesh.matrix_world)
    if mesh.parent == armature and mesh.parent_type in ("OBJECT", "ARMATURE"):
        # of an object that is hidden in an excluded collection Blender knows no place
        world = np.array(armature.matrix_world @ mesh.matrix_parent_inverse @ mesh.matrix_basis)
    try:
        shown = evaluated.to_mesh()
        places = np.empty(3 * len(shown.vertices))
        shown.vertices.foreach_get("co", places)
        heights = places.reshape(-1, 3) @ world[2, :3] + world[2, 3]
        # from the lowest up: the first that the feet carry is the sole
        for index in np.argsort(heights, kind="stable").tolist():
            weights = [(link.group, link.weight) for link in shown.vertices[index].groups]
            if sum(weight for group, weight in weights if group in wanted) >= _CARRIED * max(
                sum(weight for _, weight in weights), 1e-9
            ):
                return float(heights[index])
    finally:
        evaluated.to_mesh_clear()
    return None

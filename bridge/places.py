"""Places of a scene at which a bake can start."""

from __future__ import annotations

import bpy
import numpy as np
from mathutils import Matrix, Vector

from ..core.errors import InputError
from ..core.rig.place import Place
from .armature import role_map
from .ground import SURFACES
from .lookup import metres_per_unit as unit_of

_BESIDE, _BACK = 1.2, 2.5
"""Metres to the right of what is there, and behind the middle, at which a body starts that walks to and fro."""
_FLAT, _WIDE = 0.3, 20.0
"""Metres: what is lower, or wider, is nothing to stand beside."""


def place_of_object(obj: bpy.types.Object, metres_per_unit: float) -> Place:
    """The place of an object as it is evaluated now; who starts there faces along its Y axis."""
    world = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).matrix_world
    return _place(obj.name, world.to_translation(), world.to_3x3() @ Vector((0.0, 1.0, 0.0)), metres_per_unit)


def place_of_rig(obj: bpy.types.Object, metres_per_unit: float) -> Place:
    """Where an armature stands as it is evaluated now, by its object and by the bones above its hips.

    Raises:
        InputError: its hips or shoulders have no bones, or it lies down.
    """
    shown = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    roles = role_map(obj)
    missing = [role for role in ("hips", "upper_arm.L", "upper_arm.R") if not roles.get(role)]
    if missing:
        raise InputError(f"{obj.name}: no bone for {', '.join(missing)}; set it in the role map")
    above, moved = shown.pose.bones[roles["hips"]].parent, Matrix.Identity(4)
    if above is not None:
        moved = above.matrix @ above.bone.matrix_local.inverted()
    world = shown.matrix_world @ moved
    left, right = (world @ obj.data.bones[roles[f"upper_arm.{side}"]].head_local for side in "LR")  # pyright: ignore[reportAttributeAccessIssue]
    across = right - left
    ahead = Vector((-across.y, across.x, 0.0))
    return _place(obj.name, world.to_translation(), ahead, metres_per_unit)


def _place(name: str, position: Vector, ahead: Vector, metres_per_unit: float) -> Place:
    if ahead.xy.length < 0.1 * ahead.length or ahead.length == 0.0:
        raise InputError(f"{name}: it points straight up or down, so a body at it faces nowhere; turn it")
    x, y, z = (float(part) * metres_per_unit for part in position)
    return Place((x, y, z), float(np.arctan2(-ahead.x, ahead.y)))


def free_place(scene: bpy.types.Scene) -> Place:
    """Where a bake may start that is to be in nothing's way: beside what stands in the scene, facing -Y."""
    unit = unit_of(scene)
    right = 0.0
    for obj in scene.objects:
        if obj.type in SURFACES and obj.visible_get():
            corners = np.array([obj.matrix_world @ Vector(corner) for corner in obj.bound_box]) * unit
            size = np.ptp(corners, axis=0)
            # floors are for standing on, and nobody would look for a body beside a landscape
            if size[2] > _FLAT and size.max() < _WIDE:
                right = max(right, float(corners[:, 0].max()) + _BESIDE)
    return Place((right, _BACK, 0.0), np.pi)

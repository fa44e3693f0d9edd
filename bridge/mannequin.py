"""Mannequins: a skinned mesh of average build for an armature that was made from a skeleton."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np

from ..core.maths import quat
from ..core.rig.fit import fit_rig
from ..core.rig.mannequin.build import Mannequin, make_mannequin
from ..core.rig.rig import Rig
from .armature import create_armature

MATERIALS = (
    ("Mannequin Body", (0.84, 0.80, 0.74, 1.0), 0.55),
    ("Mannequin Joints", (0.09, 0.24, 0.40, 1.0), 0.4),
)
"""Name, base colour (linear) and roughness, in the order of `core.rig.mannequin`."""


def create_mannequin(
    rig: Rig, name: str, collection: bpy.types.Collection, metres_per_unit: float = 1.0
) -> bpy.types.Object:
    """A new armature object with a body: what a bake makes that is given no rig.

    Args:
        rig: made by `rig_from_skeleton`.
        name: of the armature.
        collection: where it goes, as with `create_armature`.
        metres_per_unit: scale of the scene's unit.
    """
    armature = create_armature(rig, name, collection, metres_per_unit)
    add_body(armature, rig)
    return armature


def add_body(armature: bpy.types.Object, rig: Rig) -> bpy.types.Object:
    """Give an armature that was made from a rig a body, skinned to its bones.

    Args:
        armature: made by `create_armature` of `rig`.
        rig: made by `rig_from_skeleton`: in T-pose, facing -Y, metres.

    Returns:
        The mesh object, a child of the armature in its collection.
    """
    made = make_mannequin(fit_rig(rig).skeleton)
    mesh = _mesh(f"{armature.name} Body", made)
    obj = bpy.data.objects.new(mesh.name, mesh)
    for collection in armature.users_collection:
        collection.objects.link(obj)
    obj.parent = armature
    _skin(obj, made, rig.bones)
    modifier: Any = obj.modifiers.new("Armature", "ARMATURE")
    modifier.object = armature
    return obj


def _mesh(name: str, made: Mannequin) -> bpy.types.Mesh:
    mesh = bpy.data.meshes.new(name)
    # as armatures that are made from skeletons, it faces -Y
    vertices = quat.rotate(quat.from_yaw(np.pi), made.vertices)
    mesh.from_pydata(vertices.tolist(), [], made.quads.tolist())
    for material in MATERIALS:
        mesh.materials.append(_material(*material))
    mesh.polygons.foreach_set("material_index", made.materials.astype(np.int32))
    mesh.polygons.foreach_set("use_smooth", np.ones(len(made.quads), dtype=bool))
    mesh.update()
    return mesh


def _material(name: str, colour: tuple[float, ...], roughness: float) -> bpy.types.Material:
    """The material of that name, made where the file has none."""
    found = bpy.data.materials.get(name)
    if found is not None and found.library is None:
        return found
    material = bpy.data.materials.new(name)
    settings: Any = material
    settings.diffuse_color = colour
    material.roughness = roughness
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    nodes: Any = material.node_tree
    shader = next(node for node in nodes.nodes if node.type == "BSDF_PRINCIPLED")
    shader.inputs["Base Color"].default_value = colour
    shader.inputs["Roughness"].default_value = roughness
    return material


def _skin(obj: bpy.types.Object, made: Mannequin, bones: tuple[str, ...]) -> None:
    """Vertex groups from the weights; vertices of one weight are added together."""
    for joint, bone in enumerate(bones):
        weights = np.round(made.weights[:, joint], 3)
        carried = np.flatnonzero(weights)
        if not len(carried):
            continue
        group = obj.vertex_groups.new(name=bone)
        order = carried[np.argsort(weights[carried], kind="stable")]
        values, starts = np.unique(weights[order], return_index=True)
        for value, vertices in zip(values.tolist(), np.split(order, starts[1:]), strict=True):
            group.add(vertices.tolist(), value, "REPLACE")

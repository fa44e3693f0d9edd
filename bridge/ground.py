"""The ground that an avatar stands on: height and normal of the meshes of a scene."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree
from numpy.typing import NDArray

from ..core.errors import InputError
from ..core.rig.ground import Ground

Array = NDArray[np.floating[Any]]

SURFACES = ("MESH", "CURVE", "SURFACE", "FONT", "META")
"""Types of objects that can have a surface."""


def chosen_ground(
    scene: bpy.types.Scene,
    chosen: Iterable[bpy.types.Object | bpy.types.Collection | None],
    rig: bpy.types.Object | None,
    metres_per_unit: float = 1.0,
) -> Ground | None:
    """The ground that objects and collections make; what hangs on the rig is passed over. None where none is chosen.

    Raises:
        InputError: an object is not in the scene, or there is no surface.
    """
    chosen = [one for one in chosen if one is not None]
    if not chosen:
        return None
    objects: dict[str, bpy.types.Object] = {}
    for one in chosen:
        if isinstance(one, bpy.types.Object) and one.name not in scene.objects:
            raise InputError(f"{one.name}: it is not in this scene; pick another ground")
        found = [one] if isinstance(one, bpy.types.Object) else one.all_objects
        objects |= {obj.name: obj for obj in found if obj.name in scene.objects and not _hangs_on(obj, rig)}
    tree, top = _surface_tree(objects.values())
    if tree is None:
        names = ", ".join(one.name for one in chosen)
        raise InputError(f"{names}: it has no surface to stand on; pick a mesh or a collection with one")
    return _ground(tree, top, metres_per_unit)


def _ground(tree: BVHTree, top: float, metres_per_unit: float) -> Ground:
    """The highest surface at each point."""

    def ground(points: Array) -> tuple[Array, Array]:
        heights = np.full(len(points), np.nan)
        normals = np.tile([0.0, 0.0, 1.0], (len(points), 1))
        down = Vector((0.0, 0.0, -1.0))
        for index, (x, y) in enumerate((points / metres_per_unit).tolist()):
            place, normal, _, _ = tree.ray_cast(Vector((x, y, top)), down)
            if place is not None and normal is not None:
                heights[index] = place.z * metres_per_unit
                normals[index] = normal if normal.z >= 0.0 else -normal
        return heights, normals

    return ground


def _hangs_on(obj: bpy.types.Object, rig: bpy.types.Object | None) -> bool:
    """Whether an object is the rig, or moved by it."""
    if rig is None:
        return False
    above: bpy.types.Object | None = obj
    while above is not None:
        if above == rig or above.find_armature() == rig:
            return True
        above = above.parent
    return False


def _surface_tree(objects: Iterable[bpy.types.Object]) -> tuple[BVHTree | None, float]:
    """One search tree over the triangles of objects in the world as evaluated at the current frame, with their
    modifiers, None where there are none; and a height above all of it."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    vertices: list[Array] = []
    triangles: list[NDArray[np.integer[Any]]] = []
    offset = 0
    for obj in objects:
        evaluated = obj.evaluated_get(depsgraph)
        try:
            mesh = evaluated.to_mesh()
        except RuntimeError:
            continue
        if mesh is not None:
            mesh.calc_loop_triangles()
            places = np.empty(3 * len(mesh.vertices))
            mesh.vertices.foreach_get("co", places)
            corners = np.empty(3 * len(mesh.loop_triangles), dtype=np.int32)
            mesh.loop_triangles.foreach_get("vertices", corners)
            world = np.array(obj.matrix_world)
            vertices.append(places.reshape(-1, 3) @ world[:3, :3].T + world[:3, 3])
            triangles.append(corners.reshape(-1, 3) + offset)
            offset += len(mesh.vertices)
        evaluated.to_mesh_clear()
    if not triangles or not sum(map(len, triangles)):
        return None, 0.0
    places = np.concatenate(vertices)
    tree = BVHTree.FromPolygons(places.tolist(), np.concatenate(triangles).tolist(), all_triangles=True)
    return tree, float(places[:, 2].max()) + 1.0

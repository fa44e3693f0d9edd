"""Height and normal of the ground under points, from the meshes of the scene."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]


def ground_heights(
    points: Array, objects: Iterable[bpy.types.Object], step: float = 1.0
) -> tuple[Array, Array]:
    """Height of the ground under points, and its normal.

    The ground is the highest surface that is not more than `step` above a point, so a floor above does not count.
    Meshes are taken as evaluated at the current frame, with their modifiers.

    Args:
        points: `(N, 3)` metres in the world.
        objects: the objects that make the ground; those without a surface are passed over.
        step: how far above a point the ground may be, metres.

    Returns:
        heights `(N,)` in metres, NaN where nothing is below, and unit normals `(N, 3)` that point up.
    """
    heights = np.full(len(points), np.nan)
    normals = np.tile([0.0, 0.0, 1.0], (len(points), 1))
    tree = surface_tree(objects)
    if tree is None:
        return heights, normals
    down = Vector((0.0, 0.0, -1.0))
    for index, (x, y, z) in enumerate(points.tolist()):
        place, normal, _, _ = tree.ray_cast(Vector((x, y, z + step)), down)
        if place is not None:
            heights[index] = place.z
            normals[index] = normal if normal.z >= 0.0 else -normal
    return heights, normals


def surface_tree(objects: Iterable[bpy.types.Object]) -> BVHTree | None:
    """One search tree over the world-space triangles of objects; None where there are none."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    vertices: list[Array] = []
    triangles: list[NDArray[np.intp]] = []
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
        return None
    return BVHTree.FromPolygons(
        np.concatenate(vertices).tolist(), np.concatenate(triangles).tolist(), all_triangles=True
    )

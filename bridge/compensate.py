"""Hips that stay where they were meant to be, whatever moves the armature or the bones above them."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
from mathutils import Matrix, Quaternion
from numpy.typing import NDArray

from ..core.pipeline import BakeResult
from .action import key_bone
from .armature import carrier_of
from .lookup import metres_per_unit

Array = NDArray[np.floating[Any]]


def compensate(obj: bpy.types.Object, scene: bpy.types.Scene, result: BakeResult, frame_start: float) -> bool:
    """Key the hips anew against the movement of the object and of the bones above, frame by frame.

    Keys stay as they are where something acts on the hips themselves, which no key can outdo, or where the hips
    are connected to the bone above.

    Returns:
        Whether there are new keys.
    """
    tracks = result.tracks
    hips = obj.pose.bones[tracks.bones[0]]
    if any(not constraint.mute for constraint in hips.constraints) or carrier_of(hips) != hips:
        return False
    unit = metres_per_unit(scene)
    meant = np.array(result.rig.world, dtype=np.float64)
    meant[:3] /= unit
    rest = hips.bone.matrix_local
    locations, rotations = np.empty_like(tracks.locations), np.empty((len(tracks.locations), 4))
    current, subframe = scene.frame_current, scene.frame_subframe
    try:
        for index, (location, rotation) in enumerate(
            zip(tracks.locations, tracks.rotations[:, 0], strict=True)
        ):
            scene.frame_set(round(frame_start) + index)
            evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
            basis = Matrix.Translation(location) @ Quaternion(rotation).to_matrix().to_4x4()
            pose = evaluated.matrix_world.inverted_safe() @ Matrix(meant.tolist()) @ rest @ basis
            found = _to_basis(hips, pose, evaluated.pose.bones[hips.name])
            locations[index], rotations[index] = found.to_translation(), found.to_quaternion()
    finally:
        scene.frame_set(current, subframe=subframe)
    key_bone(obj, hips, locations, rotations, round(frame_start))
    return True


def _to_basis(hips: bpy.types.PoseBone, pose: Matrix, evaluated: bpy.types.PoseBone) -> Matrix:
    """What the bone's keys have to be for this pose in the armature's space, with the parent as it is evaluated."""
    parent = evaluated.parent
    if parent is None:
        return hips.bone.convert_local_to_pose(pose, hips.bone.matrix_local, invert=True)
    return hips.bone.convert_local_to_pose(
        pose,
        hips.bone.matrix_local,
        parent_matrix=parent.matrix,
        parent_matrix_local=parent.bone.matrix_local,
        invert=True,
    )

"""Hips and loose limbs that stay where they were meant to be, whatever moves the armature or the bones above them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix, Quaternion
from numpy.typing import NDArray

from ..core.pipeline import BakeResult
from ..core.rig.mirror import MIRROR
from ..core.rig.rig import BoneTracks
from .action import key_bone
from .armature import carrier_of
from .lookup import metres_per_unit

Array = NDArray[np.floating[Any]]


def compensate(obj: bpy.types.Object, scene: bpy.types.Scene, result: BakeResult, frame_start: float) -> bool:
    """Key the bones that are placed on their own anew, against the movement of the object and of bones above them.

    These are the hips, and limbs that do not hang on the body. Keys stay as they are where something acts on a bone
    itself, which no key can outdo, or where it is connected to the bone above or moved by another keyed bone.

    Returns:
        Whether there are new keys.
    """
    tracks = result.tracks
    bones = [
        (obj.pose.bones[name], rotations, places)
        for name, rotations, places in _placed(tracks)
        if _is_free(obj.pose.bones[name], tracks.bones)
    ]
    meant = np.array(result.rig.world, dtype=np.float64)
    if result.rig.mirrored:
        meant = meant @ MIRROR
    meant[:3] /= metres_per_unit(scene)
    keys = [(np.empty_like(places), np.empty_like(rotations)) for _, rotations, places in bones]
    current, subframe = scene.frame_current, scene.frame_subframe
    try:
        for index in range(len(tracks.rotations) if bones else 0):
            scene.frame_set(round(frame_start) + index)
            evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
            moved = evaluated.matrix_world.inverted_safe() @ Matrix(meant.tolist())
            for (bone, rotations, places), (location, rotation) in zip(bones, keys, strict=True):
                turn = Quaternion(rotations[index]).to_matrix().to_4x4()
                pose = moved @ bone.bone.matrix_local @ Matrix.Translation(places[index]) @ turn
                found = _to_basis(bone, pose, evaluated.pose.bones[bone.name])
                location[index], rotation[index] = found.to_translation(), found.to_quaternion()
    finally:
        scene.frame_set(current, subframe=subframe)
    for (bone, _, _), (locations, turns) in zip(bones, keys, strict=True):
        key_bone(obj, bone, locations, turns, round(frame_start))
    return bool(bones)


def _placed(tracks: BoneTracks) -> list[tuple[str, Array, Array]]:
    """Name, rotations `(T, 4)` and locations `(T, 3)` of the bones with keyed locations."""
    out = [(tracks.bones[0], tracks.rotations[:, 0], tracks.locations)]
    for k, name in enumerate(tracks.placed):
        out.append((name, tracks.rotations[:, tracks.bones.index(name)], tracks.places[:, k]))
    return out


def _is_free(bone: bpy.types.PoseBone, keyed: Sequence[str]) -> bool:
    """Whether its keys alone, beside what is not keyed, say where it is."""
    held = any(not constraint.mute for constraint in bone.constraints) or carrier_of(bone) != bone
    return not held and not any(parent.name in keyed for parent in bone.parent_recursive)


def _to_basis(bone: bpy.types.PoseBone, pose: Matrix, evaluated: bpy.types.PoseBone) -> Matrix:
    """What the bone's keys have to be for this pose in the armature's space, with the parent as it is evaluated."""
    parent = evaluated.parent
    if parent is None:
        return bone.bone.convert_local_to_pose(pose, bone.bone.matrix_local, invert=True)
    return bone.bone.convert_local_to_pose(
        pose,
        bone.bone.matrix_local,
        parent_matrix=parent.matrix,
        parent_matrix_local=parent.bone.matrix_local,
        invert=True,
    )

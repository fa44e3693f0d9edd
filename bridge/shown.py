"""What Blender shows of a bake: the action keyed on an armature, evaluated frame by frame, as joint poses."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.maths import quat
from ..core.pipeline import BakeResult
from ..core.rig.fit import fit_rig
from .armature import armature_to_rig
from .targets import open_target

Array = NDArray[np.floating[Any]]


def show_bake(result: BakeResult) -> tuple[Array, Array]:
    """Bake onto a new armature in an empty scene, as the verb `bake` does, and read every frame back.

    Whatever was open in Blender is closed.

    Returns:
        World positions `(T, J, 3)` in metres and rotations since T-pose `(T, J, 4)` of the rig's joints.
    """
    target = open_target(None, result.tracks.fps)
    target.write(result, "Evaluation")
    return joint_poses(bpy.data.objects[target.name], bpy.context.scene, len(result.tracks.rotations))


def joint_poses(armature: bpy.types.Object, scene: bpy.types.Scene, frames: int) -> tuple[Array, Array]:
    """World positions `(T, J, 3)` and rotations since T-pose `(T, J, 4)` of an armature's joints in `frames`
    frames from the scene's start on, as the depsgraph evaluates them."""
    fit = fit_rig(armature_to_rig(armature))
    columns = np.empty((frames, len(armature.pose.bones), 4, 4), dtype=np.float32)
    for frame in range(frames):
        scene.frame_set(scene.frame_start + frame)
        evaluated = armature.evaluated_get(bpy.context.evaluated_depsgraph_get())
        evaluated.pose.bones.foreach_get("matrix", columns[frame].reshape(-1))
    # Blender hands matrices out column by column
    matrices = np.swapaxes(columns[:, fit.bones].astype(np.float64), -1, -2)
    poses = np.array(armature.matrix_world, dtype=np.float64) @ matrices
    axes = poses[..., :3, :3] / np.linalg.norm(poses[..., :3, :3], axis=-2, keepdims=True)
    return poses[..., :3, 3], quat.multiply(quat.from_matrix(axes), quat.conjugate(fit.tpose))

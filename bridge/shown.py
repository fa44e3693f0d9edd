"""What Blender shows of a bake: the action keyed on an armature, evaluated frame by frame, as joint poses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.maths import quat
from ..core.rig.fit import RigFit, fit_rig
from ..core.rig.mirror import MIRROR
from .armature import armature_to_rig
from .mechanism import shown_by

Array = NDArray[np.floating[Any]]


def joint_poses(armature: bpy.types.Object, scene: bpy.types.Scene, frames: int) -> tuple[Array, Array]:
    """World positions `(T, J, 3)` and rotations since T-pose `(T, J, 4)` of an armature's joints in `frames`
    frames from the scene's start on, as the depsgraph evaluates them."""
    fit = fit_rig(armature_to_rig(armature))
    return poses_at(armature, scene, fit, scene.frame_start + np.arange(frames))


def poses_at(
    armature: bpy.types.Object,
    scene: bpy.types.Scene,
    fit: RigFit,
    frames: Sequence[float] | NDArray[Any],
    metres_per_unit: float = 1.0,
) -> tuple[Array, Array]:
    """World positions `(N, J, 3)` in metres and rotations since T-pose `(N, J, 4)` of the joints of a fit.

    A control is looked at through the deforming bone that starts there and runs the same way, where there is one.

    Args:
        armature: in the scene.
        scene: the active one; its current frame is the same afterwards.
        fit: of the armature.
        frames: `(N,)`, which may lie between whole ones.
        metres_per_unit: of the scene.
    """
    columns = np.empty((len(frames), len(armature.pose.bones), 4, 4), dtype=np.float32)
    worlds = np.empty((len(frames), 1, 4, 4))
    current, subframe = scene.frame_current, scene.frame_subframe
    try:
        for index, frame in enumerate(frames):
            scene.frame_set(int(np.floor(frame)), subframe=float(frame - np.floor(frame)))
            evaluated = armature.evaluated_get(bpy.context.evaluated_depsgraph_get())
            evaluated.pose.bones.foreach_get("matrix", columns[index].reshape(-1))
            worlds[index] = evaluated.matrix_world
    finally:
        scene.frame_set(current, subframe=subframe)
    names = fit.skeleton.names
    by = shown_by(armature, names)
    # Blender hands matrices out column by column
    matrices, seen = (
        np.swapaxes(columns[:, [armature.pose.bones.find(name) for name in bones]], -1, -2).astype(np.float64)
        for bones in (names, [by[name] for name in names])
    )
    for joint, name in enumerate(names):
        if by[name] != name:
            matrices[:, joint] = _led(matrices[:, joint], seen[:, joint])
    if fit.rig.mirrored:
        worlds, matrices = worlds @ MIRROR, MIRROR @ matrices @ MIRROR
    for joint, name in enumerate(names):
        if name in fit.rig.absent:
            parent = fit.skeleton.parents[joint]
            rest, hang = fit.rig.rest[fit.bones[joint]], fit.rig.rest[fit.bones[parent]]
            matrices[:, joint] = matrices[:, parent] @ (np.linalg.inv(hang) @ rest)
    worlds[..., :3, :] *= metres_per_unit
    poses = worlds @ matrices
    axes = poses[..., :3, :3] / np.linalg.norm(poses[..., :3, :3], axis=-2, keepdims=True)
    return poses[..., :3, 3], quat.multiply(quat.from_matrix(axes), quat.conjugate(fit.tpose))


def _led(control: Array, seen: Array) -> Array:
    """Matrices `(N, 4, 4)` of a control, put where the bone is that shows it and turned to run as that does.

    How it is twisted stays the control's: a deforming bone may have half of a twist.
    """
    out = control.copy()
    turn = quat.between(control[:, :3, 1], seen[:, :3, 1])
    out[:, :3, :3] = quat.to_matrix(turn) @ control[:, :3, :3]
    out[:, :3, 3] = seen[:, :3, 3]
    return out

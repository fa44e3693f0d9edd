"""The way over the ground on a root bone, or taken out of a bake."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.body.edit import resample
from ..core.errors import InputError
from ..core.maths import quat
from ..core.pipeline import BakeResult
from ..core.rig.fit import fit_rig
from ..core.rig.keys import to_bone_tracks
from ..core.rig.travel import in_place, way
from .action import key_bone
from .armature import role_map
from .before import keep_too
from .compensate import compensate
from .holds import above_hips
from .lookup import in_view, metres_per_unit
from .mechanism import drivers_of, is_mechanism

Array = NDArray[np.floating[Any]]


def root_bone(obj: bpy.types.Object) -> bpy.types.PoseBone | None:
    """The bone above all others that the hips hang on, and that keys can move; None where there is none."""
    hips = role_map(obj).get("hips")
    if not hips or hips not in obj.pose.bones:
        return None
    drivers = drivers_of(obj)
    over = [obj.pose.bones[name] for name in above_hips(obj, hips)]
    roots = [bone for bone in over if bone.parent is None and not is_mechanism(bone, drivers)]
    return roots[0] if roots else None


def check_travel(obj: bpy.types.Object | None, travel: str) -> None:
    """Raise InputError where a rig has no root bone for its way to be on."""
    if travel == "root" and (obj is None or root_bone(obj) is None):
        name = "the database's skeleton" if obj is None else obj.name
        raise InputError(
            f"{name}: no bone above the hips can carry the way; leave it on the hips, or bake in place"
        )


def without_way(result: BakeResult, travel: str) -> BakeResult:
    """The bake in place, where that is asked for."""
    if travel != "in-place":
        return result
    motion, lost = in_place(result.motion)
    tracks = to_bone_tracks(motion, fit_rig(result.rig), result.tracks.fps)
    return replace(result, motion=motion, tracks=tracks, lost=lost)


def carry_on_root(
    obj: bpy.types.Object, scene: bpy.types.Scene, result: BakeResult, frame_start: float
) -> None:
    """Key the way of a bake that the armature object plays on its root bone, and the hips anew against it.

    The root goes as the ground below the body does: from its place at rest, with the body at rest above, to where
    the body is and faces.

    Raises:
        InputError: there is no root bone.
    """
    check_travel(obj, "root")
    bone, action = root_bone(obj), obj.animation_data.action
    assert bone is not None and action is not None
    places, yaws = way(resample(result.motion, result.tracks.fps))
    fit = fit_rig(result.rig)
    unit = metres_per_unit(scene)
    world = np.array(result.rig.world, dtype=np.float64)
    world[:3] /= unit
    rest_hips = world @ fit.rig.rest[fit.bones[0]]
    # facing at rest: the turn that straightens the hips' bone to its T-pose facing +Y, undone
    straight = quat.multiply(fit.tpose[0], quat.conjugate(quat.multiply(fit.turn, fit.rest[0])))
    turns = quat.to_matrix(quat.from_yaw(yaws + quat.heading(straight)))
    steps = np.tile(np.eye(4), (len(places), 1, 1))
    steps[:, :3, :3] = turns
    steps[:, :2, 3] = places / unit - (turns @ (rest_hips[:3, 3] * (1.0, 1.0, 0.0)))[:, :2]
    rest = np.array(bone.bone.matrix_local, dtype=np.float64)
    basis = np.linalg.inv(world @ rest) @ steps @ (world @ rest)
    locations, rotations = basis[:, :3, 3], quat.continuous(quat.from_matrix(basis[:, :3, :3]))
    keep_too(obj, action, bone.name)
    with in_view(obj, scene):
        key_bone(obj, bone, locations, rotations, round(frame_start))
        compensate(obj, scene, result, frame_start)

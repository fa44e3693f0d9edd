"""Takes shown in the scene: a new armature with the take's own proportions and its motion."""

from __future__ import annotations

import bpy

from ..core.mocap.skeleton import Motion
from ..core.rig.fit import fit_rig, rig_from_skeleton, to_bone_tracks
from .action import scene_fps, write_action
from .armature import create_armature
from .lookup import metres_per_unit


def show_motion(
    motion: Motion,
    name: str,
    collection: bpy.types.Collection,
    scene: bpy.types.Scene,
    frame_start: float = 1.0,
) -> bpy.types.Object:
    """A new armature that moves like `motion`, at the scene's frame rate."""
    rig = rig_from_skeleton(motion.skeleton, name)
    obj = create_armature(rig, name, collection, metres_per_unit(scene))
    tracks = to_bone_tracks(motion, fit_rig(rig), scene_fps(scene))
    write_action(obj, tracks, name, fps=scene_fps(scene), frame_start=frame_start)
    return obj

"""Takes shown in the scene: a new armature with the take's own proportions, its motion and its foot contacts."""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.mocap.take import Take
from ..core.rig.fit import fit_rig, rig_from_skeleton
from ..core.rig.keys import to_bone_tracks
from .action import key_pose, new_action, scene_fps
from .armature import create_armature
from .contacts import key_contacts
from .lookup import metres_per_unit


def show_take(
    take: Take,
    contacts: NDArray[np.bool_],
    file: str,
    collection: bpy.types.Collection,
    scene: bpy.types.Scene,
    frame_start: float = 1.0,
) -> bpy.types.Object:
    """A new armature that moves as a take, at the scene's frame rate.

    Args:
        take: at any rate.
        contacts: `(T, 2)` left, right foot on the ground, a frame of the scene each.
        file: the take's file, as the armature is to keep it.
        collection: where the armature is put.
        scene: gives frame rate and unit.
        frame_start: frame of the first key.
    """
    fps, rig = scene_fps(scene), rig_from_skeleton(take.motion.skeleton, take.name)
    obj = create_armature(rig, take.name, collection, metres_per_unit(scene))
    new_action(obj, take.name)
    # first, to be at the top of the Dope Sheet
    key_contacts(obj, contacts, file=file, fps=fps, frame_start=frame_start)
    key_pose(obj, to_bone_tracks(take.motion, fit_rig(rig), fps), fps, frame_start)
    return obj

"""Pose tracks to one action: bulk keys on mapped bones, and nothing else of the scene touched."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.errors import InputError
from ..core.maths import quat
from ..core.rig.rig import BoneTracks
from . import before, compat, rotations
from .armature import carrier_of
from .holds import holds
from .mechanism import is_locked

Array = NDArray[np.floating[Any]]

MADE_BY = "footwork"
"""Custom property on actions that Footwork wrote."""


def scene_fps(scene: bpy.types.Scene) -> float:
    """True frame rate of a scene."""
    return scene.render.fps / scene.render.fps_base


def check_writable(obj: bpy.types.Object) -> None:
    """Raise InputError where an action cannot be given to this object."""
    if obj.library is not None:
        raise InputError(
            f"{obj.name}: it is linked from {obj.library.name}; make a library override of it first"
        )
    if obj.animation_data is not None and obj.animation_data.use_tweak_mode:
        raise InputError(f"{obj.name}: an NLA strip of it is being tweaked; leave tweak mode first")


def write_action(
    obj: bpy.types.Object,
    tracks: BoneTracks,
    name: str,
    *,
    fps: float,
    frame_start: float = 1.0,
    marker_times: Sequence[float] = (),
    keep_previous: bool = True,
) -> bpy.types.Action:
    """Give an armature object a new action made of pose tracks.

    Rotations are keyed in each bone's own rotation mode, the hips' location too. Controls that stand between keys and
    what is seen get one key at rest, switches between IK and FK one key each. The object's transform, rest pose and
    other actions stay as they are.

    Args:
        obj: an armature object that has all bones of `tracks`.
        tracks: what to key; resampled to `fps` already, or the keys fall between frames.
        name: name of the new action.
        fps: the scene's true frame rate.
        frame_start: frame of the first key.
        marker_times: seconds from the first key at which pose markers are set.
        keep_previous: keep the object's present action with a fake user; else, where Footwork wrote it and nothing
            else uses it, it is removed.

    Raises:
        InputError: a bone is missing, or the object is linked or in NLA tweak mode.
    """
    check_writable(obj)
    missing = [bone for bone in tracks.bones if bone not in obj.pose.bones]
    if missing:
        raise InputError(f"{obj.name}: it has no bone {missing[0]!r} any more; check its role map")
    state = before.state_of(obj)
    previous = obj.animation_data_create().action
    action = new_action(obj, name)
    _play(obj)
    if previous is not None and not _is_kept(previous, keep_previous):
        replaced = previous
        state, previous = before.inherited(state, replaced)
        bpy.data.actions.remove(replaced)
    key_pose(obj, tracks, fps, frame_start)
    before.keep(obj, action, state, previous)
    for time in marker_times:
        frame = round(frame_start + time * fps)
        action.pose_markers.new("T").frame = frame
    return action


def new_action(obj: bpy.types.Object, name: str) -> bpy.types.Action:
    """Give an object a new action, marked as Footwork's."""
    action = bpy.data.actions.new(name)
    action[MADE_BY] = True
    compat.assign_action(obj, action)
    return action


def key_pose(obj: bpy.types.Object, tracks: BoneTracks, fps: float, frame_start: float) -> None:
    """Key pose tracks in the new action of an armature object that has all their bones (see `write_action`)."""
    action = obj.animation_data.action
    assert action is not None
    _hold(obj, tracks.bones, frame_start)
    frames = frame_start + np.arange(len(tracks.rotations)) * (fps / tracks.fps)
    hips = obj.pose.bones[tracks.bones[0]]
    carrier = carrier_of(hips)
    # a connected bone ignores its location; the one that it hangs on goes the same way in its own axes
    turn = carrier.bone.matrix_local.to_3x3().inverted() @ hips.bone.matrix_local.to_3x3()
    locations = tracks.locations @ np.array(turn, dtype=np.float64).T
    _key(action, obj, carrier.path_from_id("location"), carrier.name, frames, locations)
    for index, bone in enumerate(tracks.placed):
        path = obj.pose.bones[bone].path_from_id("location")
        _key(action, obj, path, bone, frames, tracks.places[:, index])
    for index, bone in enumerate(tracks.bones):
        _key_rotation(action, obj, obj.pose.bones[bone], frames, tracks.rotations[:, index])


def key_bone(
    obj: bpy.types.Object, bone: bpy.types.PoseBone, locations: Array, quaternions: Array, frame_start: float
) -> None:
    """Replace a bone's keys in the object's action by locations `(T, 3)` and rotations `(T, 4)`, one a frame."""
    action = obj.animation_data.action
    assert action is not None
    frames = frame_start + np.arange(len(locations), dtype=np.float64)
    for curve in compat.fcurves_of(obj):
        if curve.data_path.startswith(f"{bone.path_from_id()}."):
            curve.keyframe_points.clear()
    _key(action, obj, bone.path_from_id("location"), bone.name, frames, locations)
    _key_rotation(action, obj, bone, frames, quaternions)


def _key_rotation(
    action: bpy.types.Action,
    obj: bpy.types.Object,
    bone: bpy.types.PoseBone,
    frames: Array,
    quaternions: Array,
) -> None:
    values = rotations.channels(quaternions, bone.rotation_mode)
    path = bone.path_from_id(rotations.property_of(bone.rotation_mode))
    _key(action, obj, path, bone.name, frames, values)


def _play(obj: bpy.types.Object) -> None:
    """Have the object play its action alone: what an NLA track or a blend made of the last one was not for this."""
    data = obj.animation_data
    for track in data.nla_tracks:
        if track.is_solo:
            track.is_solo = False
    data.action_influence, data.action_blend_type = 1.0, "REPLACE"


def key_transform(
    obj: bpy.types.Object, positions: Array, quaternions: Array, name: str, fps: float, frame_start: float
) -> bpy.types.Action:
    """Give an object a new action that moves it through positions `(T, 3)` and rotations `(T, 4)` at `fps`."""
    action = new_action(obj, name)
    frames = frame_start + np.arange(len(positions), dtype=np.float64)
    _key(action, obj, "location", "Object Transforms", frames, positions)
    path = rotations.property_of(obj.rotation_mode)
    _key(action, obj, path, "Object Transforms", frames, rotations.channels(quaternions, obj.rotation_mode))
    return action


def _is_kept(previous: bpy.types.Action, keep: bool) -> bool:
    """Whether the action before stays, with a fake user then; only bakes that nothing else uses may go."""
    if previous.library is not None:
        return True
    if keep or not previous.get(MADE_BY):
        previous.use_fake_user = True
    return keep or not previous.get(MADE_BY) or previous.users - previous.use_fake_user > 0


def _hold(obj: bpy.types.Object, keyed: Sequence[str], frame: float) -> None:
    """One key each for what else has to stay as it is (see `holds`); scales are left alone."""
    action, found = obj.animation_data.action, holds(obj, keyed)
    assert action is not None
    frames, none = np.array([frame]), np.zeros((1, 3))
    for name in found.controls:
        bone = obj.pose.bones[name]
        if not bone.bone.use_connect and not is_locked(bone.lock_location):
            _key(action, obj, bone.path_from_id("location"), name, frames, none)
        _key_rotation(action, obj, bone, frames, quat.IDENTITY[None])
    for name in keyed:
        bone = obj.pose.bones[name]
        if not bone.bone.use_connect and bone.location.length > 0.0:
            _key(action, obj, bone.path_from_id("location"), name, frames, none)
    for name, prop, value in found.switches:
        bone = obj.pose.bones[name]
        _key(action, obj, before.switch_path(bone, prop), name, frames, np.array([[value]]))


def _key(
    action: bpy.types.Action,
    owner: bpy.types.Object,
    path: str,
    group: str,
    frames: Array,
    values: Array,
) -> None:
    for channel in range(values.shape[1]):
        track = values[:, channel].astype(np.float32)
        needed = np.ones(len(track), dtype=bool)
        needed[1:-1] = (track[1:-1] != track[:-2]) | (track[1:-1] != track[2:])
        curve = compat.ensure_fcurve(action, owner, path, channel, group)
        curve.keyframe_points.clear()
        fill_curve(curve, frames[needed], track[needed], compat.LINEAR)


def fill_curve(curve: bpy.types.FCurve, frames: Array, values: NDArray[Any], interpolation: int) -> None:
    """Give an empty F-curve keys at `frames` `(K,)`, in bulk."""
    points = np.empty((len(frames), 2), dtype=np.float32)
    points[:, 0], points[:, 1] = frames, values
    curve.keyframe_points.add(len(points))
    curve.keyframe_points.foreach_set("co", points.ravel())
    curve.keyframe_points.foreach_set("interpolation", np.full(len(points), interpolation, dtype=np.int32))
    curve.update()

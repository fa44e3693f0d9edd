"""What an armature was before a bake: kept on the bake's action, to be put back.

Blender leaves a channel that no key holds as it was evaluated last. So after a bake an older action would show the
bake's pose on the bones that it does not key; what they were is put back when the older one is assigned.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import bpy
import numpy as np

from ..core.errors import InputError
from . import compat
from .mechanism import SWITCHES, split_path

BEFORE, PREVIOUS = "footwork_before", "footwork_previous"
"""Custom properties of a bake's action: what was before, as JSON, and the action that the object had."""
_CHANNELS = {"location": 3, "rotation_quaternion": 4, "rotation_euler": 3, "rotation_axis_angle": 4}
_PLAYED = ("action_influence", "action_blend_type", "action_extrapolation")

State = dict[str, Any]

_watched: dict[int, int] = {}
"""Object -> the bake that it plays or played last, by Blender's numbers for them."""


def state_of(obj: bpy.types.Object) -> State:
    """Pose, switches and what the armature object plays, as they are now."""
    bones, data = obj.pose.bones, obj.animation_data
    columns = []
    for channel, size in _CHANNELS.items():
        values = np.empty(len(bones) * size, dtype=np.float32)
        bones.foreach_get(channel, values)
        columns.append(values.reshape(-1, size))
    rows = np.concatenate(columns, axis=1).astype(np.float64)
    state: State = {
        "animated": data is not None,
        "pose": {bone.name: row.tolist() for bone, row in zip(bones, rows, strict=True)},
        "switches": [[b.name, prop, b[prop]] for b in bones for prop in SWITCHES if prop in b],
        "played": {},
    }
    if data is not None:
        state["played"] = {name: getattr(data, name) for name in _PLAYED}
        state["solo"] = [track.name for track in data.nla_tracks if track.is_solo]
        state["slot"] = compat.slot_of(obj)
        state["fake_user"] = data.action is not None and data.action.use_fake_user
    return state


def keep(obj: bpy.types.Object, action: bpy.types.Action, state: State, previous: Any) -> None:
    """Keep on a bake's action what was before it, of the bones and switches that it keys.

    Args:
        obj: what the bake animates.
        action: the bake's.
        state: before anything was changed.
        previous: the action that the object had, or None.
    """
    keyed = {split_path(curve.data_path) for curve in compat.fcurves_of(obj, action)}
    bones = {bone for bone, _ in keyed}
    kept = {
        **state,
        "pose": {bone: row for bone, row in state["pose"].items() if bone in bones},
        "switches": [row for row in state["switches"] if (row[0], row[1]) in keyed],
    }
    action[BEFORE] = json.dumps(kept)
    if previous is not None:
        action[PREVIOUS] = previous
    _watched[obj.session_uid] = action.session_uid


def keep_too(obj: bpy.types.Object, action: bpy.types.Action, bone: str) -> None:
    """Keep of one more bone what it is now, before a bake's action keys it."""
    state = json.loads(action[BEFORE])
    state["pose"].setdefault(bone, state_of(obj)["pose"][bone])
    action[BEFORE] = json.dumps(state)


def inherited(state: State, previous: bpy.types.Action) -> tuple[State, Any]:
    """What was before an earlier bake that goes for a new one: state and action."""
    if BEFORE not in previous:
        return state, None
    older = json.loads(previous[BEFORE])
    switches = {(bone, prop): value for bone, prop, value in [*state["switches"], *older["switches"]]}
    merged = {
        **older,
        "pose": {**state["pose"], **older["pose"]},
        "switches": [[*where, value] for where, value in switches.items()],
    }
    return merged, previous.get(PREVIOUS)


def bake_of(obj: bpy.types.Object) -> bpy.types.Action | None:
    """The bake that an object plays: its action, or the topmost strip's that is one."""
    data = obj.animation_data
    if data is None:
        return None
    strips = [strip.action for track in reversed(data.nla_tracks) for strip in track.strips]
    return next((a for a in (data.action, *strips) if a is not None and BEFORE in a), None)


def clear_bake(obj: bpy.types.Object) -> str:
    """Take the bake off an armature object: action, pose, switches and strips are as before it.

    Returns:
        The bake's name.

    Raises:
        InputError: it plays no bake.
    """
    action = bake_of(obj)
    if action is None:
        raise InputError(f"{obj.name}: it plays no bake of Footwork; nothing to clear")
    state, previous, data, name = (
        json.loads(action[BEFORE]),
        action.get(PREVIOUS),
        obj.animation_data,
        action.name,
    )
    helpers = []
    for track in list(data.nla_tracks):
        pushed = track.name in state.get("pushed", ())
        if pushed or any(strip.action == action for strip in track.strips):
            helpers += [
                strip.action for strip in track.strips if strip.action not in (None, action, previous)
            ]
            data.nla_tracks.remove(track)
    compat.assign_action(obj, previous, state.get("slot", ""))
    for prop, value in state["played"].items():
        setattr(data, prop, value)
    for track in data.nla_tracks:
        if track.name in state.get("solo", ()):
            track.is_solo = True
    put_back(obj, state)
    if previous is not None:
        previous.use_fake_user = state.get("fake_user", False)
    _watched.pop(obj.session_uid, None)
    del action[BEFORE]
    if PREVIOUS in action:
        del action[PREVIOUS]
    for unused in (action, *helpers):
        if unused.users - unused.use_fake_user == 0:
            bpy.data.actions.remove(unused)
    if not state["animated"] and not (len(data.nla_tracks) or len(data.drivers)):
        obj.animation_data_clear()
    obj.update_tag()
    return name


def put_back(obj: bpy.types.Object, state: Mapping[str, Any], but: frozenset[str] = frozenset()) -> None:
    """Give bones the pose and the switches that they had.

    Args:
        obj: the armature object; bones that it has no more are passed over.
        state: what was before.
        but: data paths that stay as they are.
    """
    for name, row in state["pose"].items():
        bone = obj.pose.bones.get(name)
        if bone is None:
            continue
        at = 0
        for channel, size in _CHANNELS.items():
            if bone.path_from_id(channel) not in but:
                setattr(bone, channel, row[at : at + size])
            at += size
    for name, prop, value in state["switches"]:
        bone = obj.pose.bones.get(name)
        if bone is not None and prop in bone and switch_path(bone, prop) not in but:
            bone[prop] = value


def switch_path(bone: bpy.types.PoseBone, prop: str) -> str:
    """Data path of a custom property of a bone."""
    return f'{bone.path_from_id()}["{bpy.utils.escape_identifier(prop)}"]'


def value_before(obj: bpy.types.Object, state: Mapping[str, Any], bone: str, prop: str) -> list[float]:
    """The channels that a property of a bone had; `prop` as `mechanism.split_path` gives it."""
    at = 0
    for channel, size in _CHANNELS.items():
        if prop == f".{channel}":
            return state["pose"][bone][at : at + size]
        at += size
    found = [value for name, switch, value in state["switches"] if (name, switch) == (bone, prop)]
    return [float(found[0] if found else obj.pose.bones[bone][prop])]


def watch(objects: Any) -> None:
    """Take note of bakes that objects play, and tidy up after those that they play no more."""
    for obj in objects:
        data = obj.animation_data if obj.type == "ARMATURE" else None
        if data is None or data.action is None:
            continue
        if BEFORE in data.action:
            _watched[obj.session_uid] = data.action.session_uid
        elif obj.session_uid in _watched:
            gone = _watched.pop(obj.session_uid)
            bake = next((a for a in bpy.data.actions if a.session_uid == gone and BEFORE in a), None)
            if bake is not None:
                keyed = frozenset(curve.data_path for curve in compat.fcurves_of(obj))
                put_back(obj, json.loads(bake[BEFORE]), keyed)


def watched() -> list[bpy.types.Object]:
    """The objects that play, or played last, a bake."""
    return [obj for obj in bpy.data.objects if obj.session_uid in _watched] if _watched else []

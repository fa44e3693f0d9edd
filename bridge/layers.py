"""A bake beside the animation that a rig has: in a range of its action, or as an NLA strip on top."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.errors import InputError
from ..core.maths import quat
from ..core.maths.easing import smoothstep
from . import compat, rotations
from .action import fill_curve, new_action
from .before import BEFORE, PREVIOUS, keep, value_before
from .mechanism import split_path

Array = NDArray[np.floating[Any]]


def check_layer(obj: bpy.types.Object | None, how: str) -> None:
    """Raise InputError where a bake cannot be written as "NEW", "RANGE" or "STRIP"."""
    data = None if obj is None else obj.animation_data
    if how == "RANGE" and (obj is None or data is None or data.action is None):
        name = "the rig" if obj is None else obj.name
        raise InputError(f"{name}: it has no action to write a range into; assign one, or write a new action")
    if how == "RANGE" and obj is not None and any(len(curve.modifiers) for curve in compat.fcurves_of(obj)):
        raise InputError(
            f"{obj.name}: its action's F-curves have modifiers; bake them, or write a new action or strip"
        )


def layer(obj: bpy.types.Object, how: str, blend: int) -> bpy.types.Action:
    """Bring the bake that an armature object plays together with what it played before.

    Args:
        obj: it plays a bake.
        how: "NEW" leaves it so; "RANGE" makes a copy of the action of before with the bake in the bake's frames;
            "STRIP" makes strips of both, the bake on top.
        blend: frames over which the bake fades in and out.

    Returns:
        The bake's action.
    """
    action = obj.animation_data.action
    assert action is not None
    if how == "STRIP":
        _push(obj, action, blend)
    elif how == "RANGE":
        return _into_range(obj, action, blend)
    return action


def weights(frames: int, blend: int) -> Array:
    """Share of the bake `(frames,)`: from 0 to 1 and back over `blend` frames at the ends."""
    blend = min(blend, (frames - 1) // 2)
    if blend <= 0:
        return np.ones(frames)
    at = np.arange(frames)
    return smoothstep(np.minimum(np.minimum(at, frames - 1 - at) / blend, 1.0))


def _push(obj: bpy.types.Object, action: bpy.types.Action, blend: int) -> None:
    """Strips of the bake and, below it, of the action that the object had and of what nothing else keys."""
    data, previous, state = obj.animation_data, action.get(PREVIOUS), json.loads(action[BEFORE])
    baked = _by_path(compat.fcurves_of(obj))
    strips = [strip.action for track in data.nla_tracks for strip in track.strips if strip.action]
    others = {c.data_path for other in [*strips, previous] if other for c in compat.fcurves_of(obj, other)}
    base = new_action(obj, f"{action.name} base")
    for path, curves in baked.items():
        if path not in others:
            name, prop = split_path(path)
            for k, value in enumerate(value_before(obj, state, name, prop)[: len(curves)]):
                curve = compat.ensure_fcurve(base, obj, path, k, name)
                fill_curve(curve, np.array([action.frame_range[0]]), np.array([value]), compat.LINEAR)
    below = [(base, ""), *([] if previous is None else [(previous, state["slot"])])]
    state["pushed"] = [add_strip(obj, *layer)[0].name for layer in below]
    track, strip = add_strip(obj, action, "")
    data.action = None
    strip.extrapolation = "NOTHING"
    length = int(strip.frame_end - strip.frame_start)
    strip.blend_in = strip.blend_out = min(blend, length // 2)
    track.name = action.name
    action[BEFORE] = json.dumps(state)


def add_strip(obj: bpy.types.Object, action: bpy.types.Action, slot: str) -> tuple[Any, Any]:
    """A strip of an action in a new track on top, at the action's own frames."""
    track = obj.animation_data.nla_tracks.new()
    track.name = action.name
    strip = track.strips.new(action.name, round(action.frame_range[0]), action)
    if bpy.app.version >= (4, 4, 0):
        named = [s for s in strip.action_suitable_slots if s.identifier == slot]
        if named or strip.action_slot is None:
            strip.action_slot = (named or list(strip.action_suitable_slots))[0]
    return track, strip


def _into_range(obj: bpy.types.Object, bake: bpy.types.Action, blend: int) -> bpy.types.Action:
    """A copy of the action of before, with the bake's frames of the bake; takes the bake's place."""
    previous, state = bake[PREVIOUS], json.loads(bake[BEFORE])
    first, last = (round(frame) for frame in bake.frame_range)
    baked = _by_path(compat.fcurves_of(obj))
    markers = [(marker.name, marker.frame) for marker in bake.pose_markers]
    sampled = {path: _sampled(curves, first, last) for path, curves in baked.items()}
    name = bake.name
    whole = previous.copy()
    whole.use_fake_user = False
    for prop, value in bake.items():
        whole[prop] = value
    compat.assign_action(obj, whole, state["slot"])
    own = _by_path(compat.fcurves_of(obj))
    share = weights(last - first + 1, blend)
    for path, values in sampled.items():
        _mix(obj, whole, path, own.get(path, {}), values, share, first, state)
    for text, frame in markers:
        whole.pose_markers.new(text).frame = frame
    bpy.data.actions.remove(bake)
    whole.name = name
    keep(obj, whole, state, previous)
    return whole


def _by_path(curves: Sequence[bpy.types.FCurve]) -> dict[str, dict[int, bpy.types.FCurve]]:
    out: dict[str, dict[int, bpy.types.FCurve]] = {}
    for curve in curves:
        out.setdefault(curve.data_path, {})[curve.array_index] = curve
    return out


def _sampled(curves: Mapping[int, bpy.types.FCurve], first: int, last: int) -> Array:
    """Values `(last - first + 1, C)` of all channels of a property at whole frames."""
    frames = range(first, last + 1)
    return np.array([[curves[k].evaluate(frame) for k in sorted(curves)] for frame in frames])


def _mix(
    obj: bpy.types.Object,
    action: bpy.types.Action,
    path: str,
    own: Mapping[int, bpy.types.FCurve],
    values: Array,
    share: Array,
    first: int,
    state: Mapping[str, Any],
) -> None:
    """Put a property's values into an action's curves, the more the higher their share.

    Args:
        obj: has the action.
        action: the action.
        path: the property's data path.
        own: the action's curves of it, by channel.
        values: `(F, C)` the bake's, from frame `first` on.
        share: `(F,)`.
        first: frame.
        state: of before the bake, for what has no curves.
    """
    name, prop = split_path(path)
    channels, last = values.shape[1], first + len(values) - 1
    rest = value_before(obj, state, name, prop)
    old = [
        _around(own[k], first, last) if k in own else _still(rest[k], first, last) for k in range(channels)
    ]
    there = np.stack([around.inside for around in old], axis=1)
    kind = compat.LINEAR
    if prop.startswith(".rotation"):
        mode = obj.pose.bones[name].rotation_mode
        turned = quat.slerp(rotations.quaternions(there, mode), rotations.quaternions(values, mode), share)
        mixed = _near(rotations.channels(quat.continuous(turned), mode), there[0], mode)
    elif prop.startswith("."):
        mixed = there + share[:, None] * (values - there)
    else:
        mixed, kind = np.where(share[:, None] > 0.5, values, there), compat.CONSTANT
    for k, around in enumerate(old):
        curve = compat.ensure_fcurve(action, obj, path, k, name)
        _write(curve, around, np.arange(first, last + 1.0), mixed[:, k], kind)


def _near(values: Array, start: Array, mode: str) -> Array:
    """The same rotations, by whole turns and signs nearest to what they start from."""
    if mode == "QUATERNION":
        return -values if values[0] @ start < 0.0 else values
    turns = np.round((start - values[0]) / (2.0 * np.pi)) * 2.0 * np.pi
    if mode == "AXIS_ANGLE":
        turns[1:] = 0.0
    return values + turns


@dataclass(frozen=True, slots=True, eq=False)
class _Around:
    """A curve outside a range of frames, and its values inside."""

    kept: list[tuple[Any, ...]]
    """Frame, value, handles, their types and interpolation of keys outside."""
    frames: Array
    """Whole frames between the range and the keys next to it."""
    values: Array
    inside: Array


def _around(curve: bpy.types.FCurve, first: int, last: int) -> _Around:
    keys = list(curve.keyframe_points)
    before, after = [k for k in keys if k.co.x <= first - 1], [k for k in keys if k.co.x >= last + 1]
    low = int(np.floor(before[-1].co.x)) + 1 if before else first - 1
    high = int(np.ceil(after[0].co.x)) - 1 if after else last + 1
    frames = [*range(low, first), *range(last + 1, high + 1)]
    kept = []
    for key in (*before, *after):
        # beside the range are samples, which the handle there would bend and automatic handles would follow
        free = (before and key == before[-1]) or (after and key == after[0])
        types = ("FREE", "FREE") if free else (key.handle_left_type, key.handle_right_type)
        interpolation = "LINEAR" if before and key == before[-1] else key.interpolation
        kept.append((key.co[0], key.co[1], key.handle_left[:], key.handle_right[:], types, interpolation))
    inside = np.array([curve.evaluate(frame) for frame in range(first, last + 1)])
    return _Around(kept, np.array(frames, float), np.array([curve.evaluate(f) for f in frames]), inside)


def _still(value: float, first: int, last: int) -> _Around:
    """What has no curve stays as it was."""
    frames = np.array([first - 1.0, last + 1.0])
    return _Around([], frames, np.full(2, value), np.full(last - first + 1, value))


def _write(curve: bpy.types.FCurve, around: _Around, frames: Array, values: Array, kind: int) -> None:
    """Fill a curve with what is around a range and with the values in the range."""
    keys = np.concatenate([[row[0] for row in around.kept], around.frames, frames])
    heights = np.concatenate([[row[1] for row in around.kept], around.values, values])
    order = np.argsort(keys, kind="stable")
    curve.keyframe_points.clear()
    fill_curve(curve, keys[order], heights[order], kind)
    place = {int(index): at for at, index in enumerate(order)}
    for index, (_, _, left, right, types, interpolation) in enumerate(around.kept):
        key = curve.keyframe_points[place[index]]
        key.handle_left_type, key.handle_right_type = types
        key.handle_left, key.handle_right, key.interpolation = left, right, interpolation
    curve.update()

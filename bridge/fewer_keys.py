"""Fewer keys in a bake's action, within a stated distance of all of them."""

from __future__ import annotations

from functools import partial
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.errors import InputError
from ..core.pipeline import BakeResult
from ..core.rig.fewer_keys import Chain, Track, fewer_keys
from ..core.rig.fit import fit_rig
from . import compat, rotations
from .action import fill_curve
from .mechanism import split_path

Array = NDArray[np.floating[Any]]
Curves = list[bpy.types.FCurve]

MOST_MM = 100.0
"""The greatest distance that may be asked for."""


def check_fewer_keys(limit_mm: float) -> None:
    """Raise InputError for a distance that makes no sense."""
    if not 0.0 <= limit_mm <= MOST_MM:
        raise InputError(f"fewer keys: {limit_mm:g} mm; give 0 for all keys, or up to {MOST_MM:g} mm")


def thin_out(obj: bpy.types.Object, result: BakeResult, frame_start: float, limit_mm: float) -> None:
    """Take keys out of the bake that an armature object plays; the report gets an entry `keys`.

    Heads and tails of keyed bones stay within the distance of where they were, at every frame, in straight lines
    between keys. All channels of a rotation or a location are keyed at the same frames.

    Args:
        obj: it plays the bake alone, with a key for every frame that differs.
        result: the bake.
        frame_start: frame of the first key.
        limit_mm: in the world; 0 leaves all keys.
    """
    check_fewer_keys(limit_mm)
    frames = round(frame_start) + np.arange(len(result.tracks.rotations), dtype=np.float64)
    properties = _animated(obj)
    if limit_mm == 0.0 or len(frames) < 3 or not properties:
        return
    names = _in_order(obj, {name for name, _ in properties})
    chain = _chain(obj, result, names)
    tracks = [
        Track(names.index(name), _sampled(curves, frames), _turn(obj.pose.bones[name], prop))
        for (name, prop), curves in properties.items()
    ]
    millimetres = 1000.0 * fit_rig(result.rig).scale
    fewer = fewer_keys(chain, tracks, limit_mm / millimetres)
    before = sum(len(curve.keyframe_points) for curves in properties.values() for curve in curves)
    for n, (curves, track) in enumerate(zip(properties.values(), tracks, strict=True)):
        kept = fewer.kept[:, n]
        for channel, curve in enumerate(curves):
            curve.keyframe_points.clear()
            fill_curve(curve, frames[kept], track.values[kept, channel], compat.LINEAR)
    after = sum(len(curve.keyframe_points) for curves in properties.values() for curve in curves)
    result.report["keys"] = {
        "limit_mm": limit_mm,
        "worst_mm": fewer.worst * millimetres,
        "kept": after,
        "of": before,
    }


def _animated(obj: bpy.types.Object) -> dict[tuple[str, str], Curves]:
    """Bone and property -> its F-curves in order, of locations and rotations that more than one key moves."""
    found: dict[tuple[str, str], Curves] = {}
    for curve in compat.fcurves_of(obj):
        name, prop = split_path(curve.data_path)
        if name in obj.pose.bones and prop.startswith((".location", ".rotation")):
            found.setdefault((name, prop), []).append(curve)
    return {
        where: sorted(curves, key=lambda curve: curve.array_index)
        for where, curves in found.items()
        if any(len(curve.keyframe_points) > 1 for curve in curves)
    }


def _in_order(obj: bpy.types.Object, names: set[str]) -> list[str]:
    """Bones, parents before children."""
    bones = [obj.pose.bones[name] for name in names]
    return [bone.name for bone in sorted(bones, key=lambda bone: (len(bone.parent_recursive), bone.name))]


def _chain(obj: bpy.types.Object, result: BakeResult, names: list[str]) -> Chain:
    """Keyed bones as they hang on each other, be it through constraints between them."""
    rig, keyed = result.rig, set(names)
    hang = {name: _above(rig.bones, rig.parents, name, keyed) for name in names if name in rig.bones}
    hang.update({name: above for name, above in rig.placed if name in keyed and above in keyed | {""}})
    parents = []
    for name in names:
        above = hang.get(name, "")
        if not above and name not in dict(rig.placed):
            # bones above the hips, and the carrier of their location, are none of the rig's
            line = [bone.name for bone in obj.pose.bones[name].parent_recursive]
            above = next((other for other in line if other in keyed), "")
        parents.append(names.index(above) if above else -1)
    bones = [obj.pose.bones[name].bone for name in names]
    return Chain(
        np.array(parents, dtype=np.intp),
        np.array([bone.matrix_local for bone in bones], dtype=np.float64),
        np.array([bone.tail_local for bone in bones], dtype=np.float64),
        np.array([name in rig.loose for name in names]),
    )


def _above(bones: tuple[str, ...], parents: Any, name: str, keyed: set[str]) -> str:
    """The nearest keyed bone above one in a rig's description, "" for none."""
    at = int(parents[bones.index(name)])
    while at >= 0 and bones[at] not in keyed:
        at = int(parents[at])
    return bones[at] if at >= 0 else ""


def _sampled(curves: Curves, frames: Array) -> Array:
    """Values `(T, C)` of curves of straight lines."""
    out = np.empty((len(frames), len(curves)))
    for channel, curve in enumerate(curves):
        points = np.empty(2 * len(curve.keyframe_points), dtype=np.float32)
        curve.keyframe_points.foreach_get("co", points)
        out[:, channel] = np.interp(frames, points[::2], points[1::2])
    return out


def _turn(bone: bpy.types.PoseBone, prop: str) -> Any:
    """From keyed values to quaternions, as Blender reads them; None for a location."""
    return None if prop == ".location" else partial(rotations.quaternions, mode=bone.rotation_mode)

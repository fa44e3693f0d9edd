"""The motion of the skeleton in an FBX or glTF file, as Blender's importers bring it in.

Runs in a Blender of its own (`bridge.importing`): nothing that is open is touched, and an importer that crashes on a
damaged file takes nothing along.
"""

from __future__ import annotations

import contextlib
import io
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.bounds import JOINT_FRAMES, RESAMPLED_TIMES, TAKE_RATE
from ..core.errors import InputError
from ..core.maths import quat
from .action import scene_fps
from .compat import fcurves_of
from .errors import first_line

Array = NDArray[np.floating[Any]]

_USUAL_RATE = 30.0
_LEAST_KEYS = 5
"""Keys that tell a rate; fewer were set by hand."""
_SAME = 1e-5
"""1 - cosine of half the angle by which two poses of a bone may differ to be the same."""
_MOST_FRAMES = RESAMPLED_TIMES * JOINT_FRAMES


@dataclass(frozen=True, slots=True)
class _Span:
    """When a skeleton moves, in frames of its scene."""

    first: float
    last: float
    step: float
    """Between two keys; 0 where they do not tell."""


def write_poses(path: str, folder: str) -> None:
    """Write what is in a file into a folder: `poses.npz`, and `said.json` with the rest or the faults.

    Whatever is open in Blender is closed.
    """
    said: dict[str, Any] = {}
    try:
        arrays, said = _read(path)
        np.savez(Path(folder) / "poses.npz", **arrays)
    except InputError as error:
        said["faults"] = list(error.lines)
    (Path(folder) / "said.json").write_text(json.dumps(said), encoding="utf-8")


def _read(path: str) -> tuple[dict[str, Any], dict[str, Any]]:
    import_scene(path)
    scene = bpy.context.scene
    armature, span, doubts = _moving_armature(path, scene)
    fps = scene_fps(scene)
    if span.step > 0.0:
        rate = min(max(fps / span.step, TAKE_RATE[0]), TAKE_RATE[1])
        rate = round(rate) if abs(rate - round(rate)) < 0.01 * rate else rate
    else:
        rate = fps if _is_fbx(path) else _USUAL_RATE
        doubts.append(f"its keys tell no rate: {rate:g} frames per second are taken; say it: --rate N")
    count = int(np.floor((span.last - span.first) / fps * rate + 1e-3)) + 1
    if count * len(armature.pose.bones) > _MOST_FRAMES:
        raise InputError(f"{path}: {count} frames at {rate:g} per second are too many; export it in parts")
    names, arrays = _sampled(path, armature, scene, span.first + np.arange(count) * (fps / rate))
    # without a mesh an FBX file has no bind pose, and importers make the rest of the pose that its nodes are in
    off = np.abs(np.abs(arrays["rotations"][..., 0]) - 1.0).max(axis=1).min()
    chance = _is_fbx(path) and bool(off < _SAME) and not any(obj.type == "MESH" for obj in scene.objects)
    return arrays, {"names": names, "fps": float(rate), "doubts": doubts, "rest_is_a_frame": chance}


def _is_fbx(path: str) -> bool:
    with Path(path).open("rb") as stream:
        return stream.read(7) == b"Kaydara"


def import_scene(path: str) -> None:
    """Bring a file into a scene of its own.

    Raises:
        InputError: Blender cannot read it.
    """
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    # keys of glTF files are in seconds: a fine grid keeps them
    scene.render.fps, scene.render.fps_base = 60, 1.0
    try:
        # importers print what they think at length
        with contextlib.redirect_stderr(io.StringIO()), contextlib.redirect_stdout(io.StringIO()):
            if _is_fbx(path):
                bpy.ops.import_scene.fbx(filepath=path, use_prepost_rot=True, ignore_leaf_bones=False)
            else:
                bpy.ops.import_scene.gltf(filepath=path)
    except (RuntimeError, ReferenceError) as error:
        raise InputError(f"{path}: Blender cannot read it: {first_line(error)}") from error


def _moving_armature(path: str, scene: bpy.types.Scene) -> tuple[bpy.types.Object, _Span, list[str]]:
    """The armature with a motion, and when it moves; of several motions the longest."""
    armatures = [obj for obj in scene.objects if obj.type == "ARMATURE"]
    spans = {obj.name: span for obj in armatures if (span := _span(obj)) is not None}
    moving = [obj for obj in armatures if obj.name in spans]
    if not moving:
        has = f"{len(armatures)} skeletons and no motion of theirs" if armatures else "no skeleton"
        raise InputError(f"{path}: {has} in it; export the skeleton with its animation")
    if len(moving) > 1:
        names = ", ".join(obj.name for obj in moving[:4])
        raise InputError(f"{path}: {len(moving)} moving skeletons in it ({names}); export one")
    return moving[0], spans[moving[0].name], _other_motions(moving[0])


def _other_motions(armature: bpy.types.Object) -> list[str]:
    data = armature.animation_data
    if data is None or data.action is None:
        return []
    tracks = [track.name for track in data.nla_tracks if all(s.action != data.action for s in track.strips)]
    if not tracks:
        return []
    names = ", ".join(tracks[:3])
    return [f"it has {len(tracks) + 1} motions, and {data.action.name} is read (not {names}); export one"]


def _span(obj: bpy.types.Object) -> _Span | None:
    """When an armature moves; None where it does not."""
    _choose_action(obj)
    times = [
        np.array([key.co[0] for key in curve.keyframe_points])
        for curve in (fcurves_of(obj) if obj.animation_data is not None and obj.animation_data.action else ())
        if len(curve.keyframe_points) > 1
    ]
    if not times:
        return None
    dense = np.unique(np.round(np.concatenate(times), 3))
    steps = np.diff(dense)
    told = len(dense) >= _LEAST_KEYS and float(np.median(steps)) > 0.0
    return _Span(float(dense[0]), float(dense[-1]), float(np.median(steps)) if told else 0.0)


def _choose_action(obj: bpy.types.Object) -> None:
    """Let nothing but the longest of an object's motions play."""
    data = obj.animation_data
    if data is None:
        return
    strips = [strip for track in data.nla_tracks for strip in track.strips if strip.action is not None]
    for track in data.nla_tracks:
        track.mute = True
    if strips and data.action is None:
        longest = max(strips, key=lambda strip: strip.action.frame_range[1] - strip.action.frame_range[0])
        data.action = longest.action
        slot = getattr(longest, "action_slot", None)
        if slot is not None:
            data.action_slot = slot


def _sampled(
    path: str,
    armature: bpy.types.Object,
    scene: bpy.types.Scene,
    frames: Array,
) -> tuple[list[str], dict[str, Any]]:
    """Names of all bones, and their poses at some frames: what `bvh_of_poses` takes."""
    data: Any = armature.data
    bones = list(data.bones)
    if not bones:
        raise InputError(f"{path}: its skeleton has no bones; export it anew")
    local = np.array([bone.matrix_local for bone in bones], dtype=np.float64)
    columns = np.empty((len(frames), len(bones), 4, 4), dtype=np.float32)
    worlds = np.empty((len(frames), 4, 4))
    order = [armature.pose.bones.find(bone.name) for bone in bones]
    for index, frame in enumerate(frames.tolist()):
        scene.frame_set(int(np.floor(frame)), subframe=float(frame - np.floor(frame)))
        evaluated = armature.evaluated_get(bpy.context.evaluated_depsgraph_get())
        evaluated.pose.bones.foreach_get("matrix", columns[index].reshape(-1))
        worlds[index] = evaluated.matrix_world
    # Blender hands matrices out column by column
    poses = worlds[:, None] @ np.swapaxes(columns[:, order].astype(np.float64), -1, -2)
    rest = worlds[0] @ local
    if not (np.isfinite(poses).all() and np.isfinite(rest).all()):
        raise InputError(f"{path}: its skeleton has no place or turn in some frames; export it anew")
    turns = quat.multiply(_turns(poses), quat.conjugate(_turns(rest)))
    index = {bone.name: number for number, bone in enumerate(bones)}
    parents = np.array([-1 if b.parent is None else index[b.parent.name] for b in bones], dtype=np.intp)
    names, positions, heads = [bone.name for bone in bones], poses[..., :3, 3], rest[:, :3, 3]
    if (parents < 0).sum() > 1:
        # the object itself carries bones that hang on nothing
        names, parents = [armature.name, *names], np.concatenate([[-1], parents + 1])
        object_turns = quat.multiply(_turns(worlds), quat.conjugate(_turns(worlds[0])))
        turns = np.concatenate([object_turns[:, None], turns], axis=1)
        positions = np.concatenate([worlds[:, None, :3, 3], positions], axis=1)
        heads = np.concatenate([worlds[:1, :3, 3], heads])
    return names, {"parents": parents, "rest": heads, "positions": positions, "rotations": turns}


def _turns(matrices: Array) -> Array:
    """Rotations `(..., 4)` of matrices `(..., 4, 4)`, whatever their scale."""
    axes = matrices[..., :3, :3]
    lengths = np.maximum(np.linalg.norm(axes, axis=-2, keepdims=True), 1e-12)
    return quat.from_matrix(axes / lengths)

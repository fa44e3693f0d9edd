"""The animated objects of a .blend, FBX or glTF file that are trackers by their names.

Runs in a Blender of its own, as `scene_takes` does.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ..core.bounds import JOINT_FRAMES
from ..core.errors import InputError
from ..core.recording.reading.meaning import whose, words_of
from .action import scene_fps
from .errors import first_line
from .lookup import metres_per_unit
from .objects import sample_objects
from .scene_takes import import_scene

_BLEND = (b"BLENDER", b"\x28\xb5\x2f\xfd", b"\x1f\x8b")
"""First bytes of .blend files: plain, or packed with zstd or gzip."""
_MOST = 40


def write_poses(path: str, folder: str) -> None:
    """Write world poses of a file's trackers into a folder: `poses.npz`, and `said.json` with names or faults.

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
    with Path(path).open("rb") as stream:
        blend = stream.read(8).startswith(_BLEND)
    if blend:
        try:
            bpy.ops.wm.open_mainfile(filepath=path, use_scripts=False, load_ui=False)
        except RuntimeError as error:
            raise InputError(f"{path}: Blender cannot read it: {first_line(error)}") from error
    else:
        import_scene(path)
        _wake(bpy.context.scene)
    scene = bpy.context.scene
    trackers = _trackers(scene)
    if "head" not in trackers:
        raise InputError(
            f"{path}: no animated object of its scene is called head, hmd or camera; name objects head, left and right"
        )
    objects = list(trackers.values())[:_MOST]
    first, last = _span(objects, scene) if not blend else (scene.frame_start, scene.frame_end)
    if (last - first + 1) * len(objects) > JOINT_FRAMES:
        raise InputError(f"{path}: {last - first + 1} frames are too many; export it in parts")
    positions, rotations = sample_objects(scene, objects, first, last)
    times = np.arange(len(positions)) / scene_fps(scene)
    arrays = {"times": times, "positions": positions * metres_per_unit(scene), "rotations": rotations}
    return arrays, {"trackers": list(trackers)[:_MOST], "names": [obj.name for obj in objects]}


def _wake(scene: bpy.types.Scene) -> None:
    """Let every object do what it does in its own motion: importers show one motion of a file and mute the others."""
    for obj in scene.objects:
        data = obj.animation_data
        if data is not None and data.action is None:
            strips = [
                strip for track in data.nla_tracks for strip in track.strips if strip.action is not None
            ]
            if strips:
                longest = max(strips, key=lambda strip: strip.frame_end - strip.frame_start)
                data.action = longest.action
                # before Blender 4.4 actions have no slots
                if hasattr(longest, "action_slot"):
                    data.action_slot = longest.action_slot


def _trackers(scene: bpy.types.Scene) -> dict[str, bpy.types.Object]:
    """Objects by the trackers that their names tell: those that are animated, or whose parents or targets are."""
    named: dict[str, bpy.types.Object] = {}
    for obj in sorted(scene.objects, key=lambda obj: (not _animated(obj), obj.name)):
        tracker = _named(obj.name) if _moves(obj) else ""
        if tracker:
            named.setdefault(tracker, obj)
    return named


def _named(name: str) -> str:
    """The tracker that an object's name tells; what stands last tells most, after the name of a recording."""
    words = words_of(name)
    return whose(words[-2:])[0] or whose(words)[0]


def _animated(obj: bpy.types.Object) -> bool:
    data = obj.animation_data
    return data is not None and (data.action is not None or len(data.drivers) > 0 or len(data.nla_tracks) > 0)


def _moves(obj: bpy.types.Object) -> bool:
    return _animated(obj) or len(obj.constraints) > 0 or (obj.parent is not None and _moves(obj.parent))


def _span(objects: list[bpy.types.Object], scene: bpy.types.Scene) -> tuple[int, int]:
    """First and last frame of the objects' motions; importers leave the scene's range as it was."""
    ranges = [
        (obj.animation_data.action.frame_range[0], obj.animation_data.action.frame_range[1])
        for obj in objects
        if obj.animation_data is not None and obj.animation_data.action is not None
    ]
    if not ranges:
        return scene.frame_start, scene.frame_end
    return int(np.floor(min(low for low, _ in ranges))), int(np.ceil(max(high for _, high in ranges)))

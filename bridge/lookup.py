"""Finding data again that a long job was started for: names outlive undo, references do not."""

from __future__ import annotations

import bpy

from ..core.errors import InputError


def find_object(name: str) -> bpy.types.Object:
    """The file's own object of this name; InputError where it is gone."""
    obj = bpy.data.objects.get((name, None))
    if obj is None:
        raise InputError(f"{name}: the object is gone since the job was started; pick it again")
    return obj


def find_scene(name: str) -> bpy.types.Scene:
    """The file's own scene of this name; InputError where it is gone."""
    scene = bpy.data.scenes.get((name, None))
    if scene is None:
        raise InputError(f"{name}: the scene is gone since the job was started; start again")
    return scene


def metres_per_unit(scene: bpy.types.Scene) -> float:
    """How many metres one Blender unit of the scene stands for."""
    units = scene.unit_settings
    return 1.0 if units.system == "NONE" else units.scale_length

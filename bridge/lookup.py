"""Finding data again that a long job was started for: references do not outlive undo."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import bpy

from ..core.errors import InputError


@dataclass(frozen=True, slots=True)
class Kept:
    """An object or scene to be found again, whatever it is called by then; another one of its name does not count."""

    name: str
    """What it was called."""
    kind: str
    """"object" or "scene"."""
    uid: int
    """Blender's number for it: the same over undo and renaming, until another file is loaded."""

    def find(self) -> Any:
        """The object or scene; InputError where it is gone."""
        for found in getattr(bpy.data, f"{self.kind}s"):
            if found.session_uid == self.uid:
                return found
        raise InputError(f"{self.name}: the {self.kind} is gone since the job was started; start again")


def keep_object(obj: bpy.types.Object) -> Kept:
    """What finds an object again."""
    return Kept(obj.name, "object", obj.session_uid)


def keep_scene(scene: bpy.types.Scene) -> Kept:
    """What finds a scene again."""
    return Kept(scene.name, "scene", scene.session_uid)


def metres_per_unit(scene: bpy.types.Scene) -> float:
    """How many metres one Blender unit of the scene stands for."""
    units = scene.unit_settings
    return 1.0 if units.system == "NONE" else units.scale_length


@contextmanager
def in_view(obj: bpy.types.Object, scene: bpy.types.Scene) -> Iterator[None]:
    """A while in which Blender evaluates an object of the scene, though its collections are excluded."""
    layer = bpy.context.view_layer if bpy.context.scene == scene else scene.view_layers[0]
    if obj.name in layer.objects:
        yield
        return
    home = scene.collection
    home.objects.link(obj)
    layer.update()
    try:
        yield
    finally:
        home.objects.unlink(obj)
        layer.update()


def leave_edit_mode(obj: bpy.types.Object) -> None:
    """Leave an armature's Edit Mode, in which Blender shows no animation; what was edited is kept."""
    data = obj.data
    if not isinstance(data, bpy.types.Armature) or not data.is_editmode:
        return
    with_mode: Any = bpy.context.temp_override(active_object=obj, object=obj)
    with with_mode:
        bpy.ops.object.mode_set(mode="OBJECT")

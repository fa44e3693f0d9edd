"""Rigs and ground brought in from files."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path
from typing import Any, cast

import bpy

from ..core.errors import InputError
from .ground import SURFACES

RIG_FORMATS = (".blend", ".fbx", ".glb", ".gltf", ".vrm")


def split_rig(spec: str) -> tuple[Path, str]:
    """FILE and OBJECT of FILE[:OBJECT]; a colon after a drive letter separates nothing."""
    if Path(spec).suffix.lower() in RIG_FORMATS:
        return Path(spec), ""
    path, _, object_name = spec.rpartition(":")
    return Path(path or spec), object_name if path else ""


def check_ground(path: Path) -> None:
    """Raise InputError where a file cannot hold ground."""
    if not path.is_file():
        raise InputError(f"{path}: no such file; give --ground FILE.blend[:NAME]")
    if path.suffix.lower() != ".blend":
        raise InputError(f"{path}: cannot read ground from this kind of file; use .blend")


def append(path: Path, name: str) -> bpy.types.Object | bpy.types.Collection | None:
    """An object or collection of another file, or all its objects, brought into the scene; None if it has none."""
    into = bpy.context.scene.collection
    there: Any
    here: Any
    # drivers of the file would run from here on; only the command line comes here, in a Blender of its own
    bpy.context.preferences.filepaths.use_scripts_auto_execute = False
    try:
        with bpy.data.libraries.load(str(path)) as (there, here):  # pyright: ignore[reportGeneralTypeIssues]
            # names, which are data afterwards
            if not name:
                here.objects = list(there.objects)
            elif name in there.objects:
                here.objects = [name]
            elif name in there.collections:
                here.collections = [name]
    except OSError as error:
        raise InputError(f"{path}: Blender cannot read it: {str(error).splitlines()[0]}") from error
    collections, objects = cast(list[Any], here.collections), cast(list[Any], here.objects)
    if collections:
        into.children.link(collections[0])
        return collections[0]
    if not name:
        all_of_it = bpy.data.collections.new(path.stem)
        into.children.link(all_of_it)
        into = all_of_it
    for obj in objects:
        if obj.type in SURFACES or name:
            into.objects.link(obj)
    if name:
        return objects[0] if objects else None
    return into


def open_rig(path: Path) -> None:
    """Open a file with a rig, or import it into an empty scene.

    Raises:
        InputError: Blender cannot read it.
    """
    kind = path.suffix.lower()
    if not path.is_file():
        raise InputError(f"{path}: no such file; give --rig FILE[:OBJECT]")
    if kind not in RIG_FORMATS:
        raise InputError(f"{path}: cannot read rigs from this kind of file; use {', '.join(RIG_FORMATS)}")
    try:
        if kind == ".blend":
            bpy.ops.wm.open_mainfile(filepath=str(path), use_scripts=False)
            return
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        # importers print the same fault at length
        with contextlib.redirect_stderr(io.StringIO()):
            if kind == ".fbx":
                bpy.ops.import_scene.fbx(filepath=str(path))
            else:
                bpy.ops.import_scene.gltf(filepath=str(path))
    except RuntimeError as error:
        raise InputError(f"{path}: Blender cannot read it: {str(error).splitlines()[0]}") from error


def armature_of(path: Path, name: str) -> bpy.types.Object:
    """The open scene's armature of a name; for "" its only one, or the active one of several.

    Linked ones do not count where there is an override or another that can be keyed.

    Raises:
        InputError: there is none, or which one is not clear.
    """
    armatures = [obj for obj in bpy.context.scene.objects if obj.type == "ARMATURE"]
    armatures = [obj for obj in armatures if obj.library is None] or armatures
    names = ", ".join(obj.name for obj in armatures) or "none"
    chosen = [obj for obj in armatures if name in ("", obj.name)]
    active = bpy.context.view_layer.objects.active
    if not name and active in armatures:
        chosen = [active]
    if not chosen:
        chosen = _elsewhere(path, name)
    if len(chosen) > 1 and len({obj.name for obj in chosen}) == 1:
        homes = ", ".join(Path(obj.library.filepath).name for obj in chosen if obj.library)
        raise InputError(
            f"{path}: {len(chosen)} armatures are called {chosen[0].name!r} (linked from {homes}); make one local, or "
            "a library override of it"
        )
    if len(chosen) != 1:
        wanted = f"no armature {name!r}" if name else f"{len(armatures)} armatures"
        raise InputError(f"{path}: {wanted} in it (it has: {names}); give one as FILE:OBJECT")
    return chosen[0]


def _elsewhere(path: Path, name: str) -> list[bpy.types.Object]:
    """The armature of a name, "" for any, of another scene, which is opened then.

    Raises:
        InputError: there is one that is only shown as an instance.
    """
    for scene in bpy.data.scenes:
        found = [obj for obj in scene.objects if obj.type == "ARMATURE" and name in ("", obj.name)]
        if found and scene != bpy.context.scene and bpy.context.window is not None:
            bpy.context.window.scene = scene
            return found
    for shown in bpy.context.scene.objects:
        collection = shown.instance_collection if shown.instance_type == "COLLECTION" else None
        inside = [] if collection is None else collection.all_objects
        rigs = [obj.name for obj in inside if obj.type == "ARMATURE" and name in ("", obj.name)]
        if collection is not None and rigs:
            raise InputError(
                f"{path}: armature {rigs[0]} is only in the collection {collection.name} that {shown.name} instances; "
                "make the instance real, or a library override of it"
            )
    return []


def editable(obj: bpy.types.Object, scene: bpy.types.Scene) -> bpy.types.Object:
    """The armature object itself, or of a linked one a library override in the scene, made where there is none.

    Raises:
        InputError: Blender cannot make one.
    """
    if obj.library is None:
        return obj
    layer = bpy.context.view_layer if bpy.context.scene == scene else scene.view_layers[0]
    made = obj.override_hierarchy_create(scene, layer, do_fully_editable=True)
    # of an object that is linked without its collection
    made = made or obj.override_create(remap_local_usages=True)
    if made is None:
        raise InputError(
            f"{obj.name}: it is linked from {obj.library.name}, and Blender cannot make a library override of it"
        )
    return made

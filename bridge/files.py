"""Batch bakes: a rig from a file, the finished scene to a .blend, exports beside it."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import bpy

from ..core.body.edit import resample
from ..core.body.motion import Motion
from ..core.errors import InputError
from ..core.files import write_together
from ..core.mocap.bvh import write_bvh
from ..core.mocap.export import to_bvh
from ..core.pipeline import BakeResult
from ..core.rig.ground import Ground
from ..core.rig.rig import Rig
from .action import write_action
from .armature import armature_to_rig, create_armature, rig_doubts
from .ground import SURFACES, chosen_ground

RIG_FORMATS = (".blend", ".fbx", ".glb", ".gltf", ".vrm")


def check_targets(paths: Sequence[str]) -> None:
    """Raise InputError before any work where an output has the wrong kind or no folder."""
    for i, path in enumerate(paths):
        kinds = (".blend",) if i == 0 else tuple(_EXPORTERS)
        if Path(path).suffix.lower() not in kinds:
            raise InputError(f"{path}: cannot write this kind of file; use {', '.join(kinds)}")
        if not Path(path).resolve().parent.is_dir():
            raise InputError(f"{path}: its folder does not exist; make it first")


@dataclass(slots=True)
class Target:
    """The scene that a batch bake writes into."""

    rig: Rig | None
    """The rig found in a file; None until one is made from the database."""
    object_name: str
    fps: float
    doubts: tuple[str, ...] = ()
    """What on the rig will show in the bake."""
    motion: Motion | None = None
    """What was written, for exports that Blender does not do."""

    @property
    def name(self) -> str:
        """Name of the animated armature."""
        return self.object_name

    def ground(self, spec: str) -> Ground:
        """What is to be stood on, brought into the scene where it is from another file than the rig.

        Args:
            spec: FILE.blend or FILE.blend:NAME of an object or a collection; everything in the file by default.

        Raises:
            InputError: the file, or what is named in it, cannot be used.
        """
        path, name = split_rig(spec)
        _check_ground(path)
        scene = bpy.context.scene
        if bpy.data.filepath and Path(bpy.data.filepath).resolve() == path.resolve():
            found = bpy.data.objects.get(name) or bpy.data.collections.get(name)
            if not name:
                found = scene.collection
        else:
            found = _append(path, name)
        if found is None:
            raise InputError(f"{path}: no object or collection {name!r} in it; give one as FILE.blend:NAME")
        bpy.context.view_layer.update()
        rig = bpy.data.objects.get(self.object_name) if self.rig else None
        ground = chosen_ground(scene, [found], rig)
        assert ground is not None
        return ground

    def write(self, result: BakeResult, recording: str) -> None:
        """Give the rig its action, made first where the file had none, and fit the scene to it."""
        scene = bpy.context.scene
        if self.rig is None:
            self.object_name = create_armature(result.rig, result.rig.name, scene.collection).name
        armature = bpy.data.objects[self.object_name]
        times = [float(time) for time in result.transition_times]
        write_action(armature, result.tracks, recording, fps=self.fps, marker_times=times)
        scene.frame_start, scene.frame_end = 1, max(len(result.tracks.rotations), 1)
        scene.frame_set(1)
        self.motion = result.motion

    def save(self, output: str, exports: Sequence[str]) -> None:
        """Write the .blend and every export, all of them or none."""
        armature = bpy.data.objects[self.object_name]
        writers = {path: partial(_EXPORTERS[Path(path).suffix.lower()], self, armature) for path in exports}
        write_together({**writers, output: _save_copy})


def open_target(spec: str | None, fps: float) -> Target:
    """Start from an empty scene, or from a file with the rig.

    Args:
        spec: FILE or FILE:OBJECT; None for a rig made from the database.
        fps: frame rate that the scene gets.

    Raises:
        InputError: the file or the object in it cannot be used.
    """
    if spec is None:
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        _set_rate(fps)
        return Target(None, "", fps)
    path, object_name = split_rig(spec)
    _load(path)
    _set_rate(fps)
    armature = _armature(path, object_name)
    bpy.context.view_layer.update()
    return Target(armature_to_rig(armature), armature.name, fps, rig_doubts(armature))


def split_rig(spec: str) -> tuple[Path, str]:
    """FILE and OBJECT of FILE[:OBJECT]; a colon after a drive letter separates nothing."""
    if Path(spec).suffix.lower() in RIG_FORMATS:
        return Path(spec), ""
    path, _, object_name = spec.rpartition(":")
    return Path(path or spec), object_name if path else ""


def _check_ground(path: Path) -> None:
    if not path.is_file():
        raise InputError(f"{path}: no such file; give --ground FILE.blend[:NAME]")
    if path.suffix.lower() != ".blend":
        raise InputError(f"{path}: cannot read ground from this kind of file; use .blend")


def _append(path: Path, name: str) -> bpy.types.Object | bpy.types.Collection | None:
    """An object or collection of another file, or all its objects, brought into the scene; None if it has none."""
    into = bpy.context.scene.collection
    try:
        with bpy.data.libraries.load(str(path)) as (there, here):
            if not name:
                here.objects = list(there.objects)
            elif name in there.objects:
                here.objects = [name]
            elif name in there.collections:
                here.collections = [name]
    except OSError as error:
        raise InputError(f"{path}: Blender cannot read it: {str(error).splitlines()[0]}") from error
    if here.collections:
        into.children.link(here.collections[0])
        return here.collections[0]
    if not name:
        all_of_it = bpy.data.collections.new(path.stem)
        into.children.link(all_of_it)
        into = all_of_it
    for obj in here.objects:
        if obj.type in SURFACES or name:
            into.objects.link(obj)
    if name:
        return here.objects[0] if here.objects else None
    return into


def _load(path: Path) -> None:
    kind = path.suffix.lower()
    if not path.is_file():
        raise InputError(f"{path}: no such file; give --rig FILE[:OBJECT]")
    if kind not in RIG_FORMATS:
        raise InputError(f"{path}: cannot read rigs from this kind of file; use {', '.join(RIG_FORMATS)}")
    try:
        if kind == ".blend":
            bpy.ops.wm.open_mainfile(filepath=str(path))
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


def _armature(path: Path, name: str) -> bpy.types.Object:
    armatures = [obj for obj in bpy.context.scene.objects if obj.type == "ARMATURE"]
    names = ", ".join(obj.name for obj in armatures) or "none"
    chosen = [obj for obj in armatures if name in ("", obj.name)]
    if len(chosen) != 1:
        wanted = f"no armature {name!r}" if name else f"{len(armatures)} armatures"
        raise InputError(f"{path}: {wanted} in it (it has: {names}); give one as FILE:OBJECT")
    return chosen[0]


def _set_rate(fps: float) -> None:
    """Scene rate: whole numbers as they are, others as a whole rate over a base."""
    render = bpy.context.scene.render
    render.fps = max(1, round(fps))
    render.fps_base = render.fps / fps


def _save_copy(path: Path) -> None:
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True, check_existing=False)


def _export_bvh(target: Target, armature: bpy.types.Object, path: Path) -> None:
    write_bvh(path, to_bvh(resample(target.motion, target.fps), armature.name))


def _export_fbx(_: Target, armature: bpy.types.Object, path: Path) -> None:
    _select(armature)
    bpy.ops.export_scene.fbx(
        filepath=str(path),
        use_selection=True,
        add_leaf_bones=False,
        bake_anim_use_all_actions=False,
        bake_anim_use_nla_strips=False,
        bake_anim_simplify_factor=0.0,
    )


def _export_glb(_: Target, armature: bpy.types.Object, path: Path) -> None:
    _select(armature)
    bpy.ops.export_scene.gltf(
        filepath=str(path), use_selection=True, export_format="GLB", export_animation_mode="ACTIVE_ACTIONS"
    )


def _select(armature: bpy.types.Object) -> None:
    """Select the armature and the meshes it moves."""
    for obj in bpy.context.scene.objects:
        obj.select_set(obj == armature or obj.find_armature() == armature)
    bpy.context.view_layer.objects.active = armature


_EXPORTERS = {".fbx": _export_fbx, ".glb": _export_glb, ".bvh": _export_bvh}

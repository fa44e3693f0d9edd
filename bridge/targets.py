"""Batch bakes: the scene that a rig is opened in, and that is written to a .blend with its exports."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import bpy

from ..core.body.motion import Motion
from ..core.errors import InputError
from ..core.pipeline import BakeResult
from ..core.rig.ground import Ground
from ..core.rig.place import Place
from ..core.rig.rig import Rig
from ..core.transaction import Transaction
from .action import check_writable, scene_fps, write_action
from .armature import armature_to_rig, create_armature, rig_doubts, some
from .errors import writing
from .exports import Baked, kind_of
from .fewer_keys import check_fewer_keys, thin_out
from .ground import chosen_ground
from .layers import check_layer, layer
from .load import append, armature_of, check_ground, editable, open_rig, split_rig
from .lookup import in_view, leave_edit_mode, metres_per_unit
from .mannequin import create_mannequin
from .places import place_of_object, place_of_rig
from .proof import prove
from .shown import Array, joint_poses
from .travel import carry_on_root, check_travel, root_bone, without_way

_WITH_FILES = ("libraries", "images", "sounds", "movieclips", "fonts", "cache_files", "volumes", "texts")
"""Collections of `bpy.data` whose data-blocks have a `filepath`."""


@dataclass(slots=True)
class Target:
    """The scene that a batch bake writes into."""

    rig: Rig | None
    """The rig found in a file; None until one is made from the database."""
    object_name: str
    fps: float
    fit_range: bool = True
    """Whether the scene's range becomes that of the bake."""
    doubts: tuple[str, ...] = ()
    """What on the rig will show in the bake."""
    motion: Motion | None = None
    """What was written, for exports that Blender does not do."""
    frames: tuple[int, int] = (1, 1)
    """First and last frame of the bake."""

    write_as: str = "new"
    """What `layers.layer` makes of it."""
    blend: int = 0
    """Frames to fade in and out."""
    travel: str = "hips"
    """One of `core.methods.TRAVELS`."""
    engine: str = ""
    """One of `core.methods.ENGINES`, or "" for none."""
    deform_only: bool = False
    """Whether exports are of deforming bones alone."""
    body: bool = True
    """Whether an armature that is made has a mesh."""
    fewer_keys: float = 0.0
    """Millimetres within which keys are left out; 0 for all keys."""

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
        check_ground(path)
        scene = bpy.context.scene
        if bpy.data.filepath and Path(bpy.data.filepath).resolve() == path.resolve():
            found = bpy.data.objects.get(name) or bpy.data.collections.get(name)
            if not name:
                found = scene.collection
        else:
            found = append(path, name)
        if found is None:
            raise InputError(f"{path}: no object or collection {name!r} in it; give one as FILE.blend:NAME")
        bpy.context.view_layer.update()
        rig = bpy.data.objects.get(self.object_name) if self.rig else None
        ground = chosen_ground(scene, [found], rig, metres_per_unit(scene))
        assert ground is not None
        return ground

    def place(self, spec: str) -> Place | None:
        """Where the bake is to start: "recording", "rig", or the name of an object of the scene.

        Raises:
            InputError: there is no such object, or no rig.
        """
        if spec == "recording":
            return None
        scene = bpy.context.scene
        found = bpy.data.objects.get(self.object_name if spec == "rig" else spec)
        if found is None:
            raise InputError(
                f"--at {spec}: no such object in the rig's file; give rig, recording or an object's name"
            )
        if spec != "rig":
            return place_of_object(found, metres_per_unit(scene))
        with in_view(found, scene):
            return place_of_rig(found, metres_per_unit(scene))

    def for_engine(self, engine: str, travel: str | None, deform_only: bool | None) -> None:
        """Set what an engine wants; what is not None is said otherwise."""
        rig = bpy.data.objects.get(self.object_name) if self.rig else None
        usual = "root" if engine and rig is not None and root_bone(rig) is not None else "hips"
        self.engine, self.travel = engine, travel or usual
        self.deform_only = bool(engine) if deform_only is None else deform_only

    def check(self) -> None:
        """Raise InputError where the bake cannot be written as is asked for."""
        rig = bpy.data.objects.get(self.object_name) if self.rig else None
        check_layer(rig, self.write_as.upper())
        check_travel(rig, self.travel)
        check_fewer_keys(self.fewer_keys)

    def write(self, result: BakeResult, recording: str) -> None:
        """Give the rig its action, made first where the file had none, and fit the scene to it."""
        scene = bpy.context.scene
        if self.rig is None:
            unit = metres_per_unit(scene)
            create = create_mannequin if self.body else create_armature
            self.object_name = create(result.rig, result.rig.name, scene.collection, unit).name
        armature = bpy.data.objects[self.object_name]
        times = [float(time) for time in result.transition_times]
        start = 1 if self.fit_range else scene.frame_start
        result = without_way(result, self.travel)
        write_action(armature, result.tracks, recording, fps=self.fps, frame_start=start, marker_times=times)
        if self.fit_range:
            scene.frame_start, scene.frame_end = 1, max(len(result.tracks.rotations), 1)
            scene.frame_set(1)
        if self.travel == "root":
            carry_on_root(armature, scene, result, start)
        prove(armature, scene, result, start)
        thin_out(armature, result, start, self.fewer_keys)
        self.motion, self.frames = result.motion, (start, start + max(len(result.tracks.rotations), 1) - 1)

    def save(self, paths: Sequence[str], outputs: Transaction) -> None:
        """Write the .blend and every export.

        Raises:
            InputError: Blender cannot write one of them.
        """
        assert self.motion is not None
        baked = Baked(
            bpy.data.objects[self.object_name], self.motion, self.fps, self.deform_only, self.engine
        )
        scene = bpy.context.scene
        kept = scene.frame_start, scene.frame_end
        # exports are of the bake, whatever part of it the scene's range is
        scene.frame_start, scene.frame_end = self.frames
        blends = [path for path in paths if Path(path).suffix.lower() == ".blend"]
        for path in paths:
            if path not in blends:
                with outputs.staging(path) as new, writing(path):
                    kind_of(path).write(baked, new)
        scene.frame_start, scene.frame_end = kept
        # exports are of the bake alone
        layer(baked.armature, self.write_as.upper(), self.blend)
        for path in blends:
            with outputs.staging(path) as new, writing(path):
                _save_copy(new, Path(path).resolve().parent)


def open_target(
    spec: str | None, usual_fps: float, fps: float | None = None, fit_range: bool | None = None
) -> Target:
    """Start from an empty scene, or from a file with the rig.

    A .blend keeps its frame rate, range and current frame where nothing else is asked for.

    Args:
        spec: FILE or FILE:OBJECT; None for a rig made from the database.
        usual_fps: frame rate of a scene that has none of its own.
        fps: frame rate that the scene gets.
        fit_range: whether the scene's range becomes that of the bake.

    Raises:
        InputError: the file or the object in it cannot be used.
    """
    if spec is None:
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        _set_rate(fps or usual_fps)
        return Target(None, "", fps or usual_fps, fit_range is not False)
    path, object_name = split_rig(spec)
    open_rig(path)
    scene, own = bpy.context.scene, path.suffix.lower() == ".blend"
    if fps or not own:
        _set_rate(fps or usual_fps)
    armature = editable(armature_of(path, object_name), scene)
    check_writable(armature)
    leave_edit_mode(armature)
    with in_view(armature, scene):
        bpy.context.view_layer.update()
        rig = armature_to_rig(armature, metres_per_unit(scene))
    others = [obj.name for obj in scene.objects if obj.type == "ARMATURE" and obj.name != armature.name]
    doubts = rig_doubts(armature)
    if others and not object_name:
        doubts = (
            f"The file has {some(others)} too, and this one is active: give another as FILE:OBJECT",
            *doubts,
        )
    fitted = fit_range if fit_range is not None else not own
    return Target(rig, armature.name, scene_fps(scene), fitted, doubts)


def show_bake(result: BakeResult) -> tuple[Array, Array]:
    """Bake onto a new armature in an empty scene, as the verb `bake` does, and read every frame back.

    Whatever was open in Blender is closed.

    Returns:
        World positions `(T, J, 3)` in metres and rotations since T-pose `(T, J, 4)` of the rig's joints.
    """
    target = open_target(None, result.tracks.fps)
    target.write(result, "Evaluation")
    return joint_poses(bpy.data.objects[target.name], bpy.context.scene, len(result.tracks.rotations))


def _set_rate(fps: float) -> None:
    """Scene rate: whole numbers as they are, others as a whole rate over a base."""
    render = bpy.context.scene.render
    render.fps = max(1, round(fps))
    render.fps_base = render.fps / fps


def _save_copy(path: Path, folder: Path) -> None:
    """Write the scene to `path`, with relative paths that hold from `folder`, where the file will lie."""
    for blocks in (getattr(bpy.data, name) for name in _WITH_FILES):
        for block in blocks:
            # the files of linked data-blocks are found from their own library
            if block.library is None and getattr(block, "parent", None) is None:
                name = "filepath_raw" if hasattr(block, "filepath_raw") else "filepath"
                if getattr(block, name).startswith("//"):
                    setattr(
                        block,
                        name,
                        bpy.path.relpath(bpy.path.abspath(getattr(block, name)), start=str(folder)),
                    )
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True, check_existing=False, relative_remap=False)

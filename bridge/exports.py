"""The kinds of files that a bake can also be exported to: an entry in EXPORTS is all that one needs.

What writes is imported only where something is written: the command line's help lists these kinds without it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..core.errors import InputError

if TYPE_CHECKING:
    import bpy

    from ..core.body.motion import Motion


@dataclass(frozen=True, slots=True)
class Baked:
    """What there is to export."""

    armature: bpy.types.Object
    """In the open scene, with its action."""
    motion: Motion
    """The same motion as joints, at the database's rate."""
    fps: float
    """Frame rate of the scene."""
    deform_only: bool = False
    """Whether bones that do not deform are left out, but for those above others."""
    engine: str = ""
    """One of `core.methods.ENGINES`, or "" for none."""


@dataclass(frozen=True, slots=True)
class Export:
    """One kind of file."""

    suffix: str
    """With its dot, lower case."""
    label: str
    write: Callable[[Baked, Path], None]
    """Writes a new file; may change what is selected in the scene."""


def kind_of(path: str) -> Export:
    """The kind of file that a path's suffix says.

    Raises:
        InputError: nothing is exported to this kind.
    """
    for export in EXPORTS:
        if Path(path).suffix.lower() == export.suffix:
            return export
    raise InputError(f"{path}: cannot export to this kind of file; use {in_words()}")


def check_targets(paths: Sequence[str]) -> None:
    """Raise InputError before any work where something is to be exported to a kind of file that there is not."""
    for path in paths:
        kind_of(path)


def in_words() -> str:
    """All kinds, such as "FBX (.fbx), glTF (.glb) or BVH (.bvh)"."""
    *most, last = (f"{export.label} ({export.suffix})" for export in EXPORTS)
    return f"{', '.join(most)} or {last}" if most else last


def _write_bvh(baked: Baked, path: Path) -> None:
    from ..core.body.edit import resample
    from ..core.mocap.bvh import format_bvh
    from ..core.mocap.export import to_bvh

    path.write_text(format_bvh(to_bvh(resample(baked.motion, baked.fps), baked.armature.name)), newline="")


_FBX: Mapping[str, Mapping[str, Any]] = {
    "unreal": {"mesh_smooth_type": "FACE"},
    "unity": {"apply_scale_options": "FBX_SCALE_ALL"},
}
"""What an engine wants of FBX."""


def _write_fbx(baked: Baked, path: Path) -> None:
    import bpy

    _select(baked.armature)
    with _alone(baked.armature):
        bpy.ops.export_scene.fbx(
            filepath=str(path),
            use_selection=True,
            add_leaf_bones=False,
            use_armature_deform_only=baked.deform_only,
            # a strip's clip starts at time 0, which is frame 1 where it is read
            bake_anim_use_nla_strips=True,
            bake_anim_use_all_actions=False,
            bake_anim_simplify_factor=0.0,
            **_FBX.get(baked.engine, {}),
        )


@contextmanager
def _alone(armature: bpy.types.Object) -> Iterator[None]:
    """The bake as the only strip of everything that is exported; as before afterwards."""
    import bpy

    from . import compat
    from .layers import add_strip

    data = armature.animation_data
    action, slot = data.action, compat.slot_of(armature)
    assert action is not None
    owners = [obj.animation_data for obj in bpy.context.selected_objects or () if obj.animation_data]
    muted = [track for owner in owners for track in owner.nla_tracks if not track.mute]
    for track in muted:
        track.mute = True
    own, _ = add_strip(armature, action, slot)
    data.action = None
    try:
        yield
    finally:
        data.nla_tracks.remove(own)
        for track in muted:
            track.mute = False
        compat.assign_action(armature, action, slot)


def _write_glb(baked: Baked, path: Path) -> None:
    import bpy

    _select(baked.armature)
    bpy.ops.export_scene.gltf(
        filepath=str(path),
        use_selection=True,
        export_format="GLB",
        export_animation_mode="ACTIVE_ACTIONS",
        export_anim_slide_to_zero=True,
        export_optimize_animation_size=False,
        export_def_bones=baked.deform_only,
    )


def _select(armature: bpy.types.Object) -> None:
    """Select the armature and the meshes it moves."""
    import bpy

    for obj in bpy.context.scene.objects:
        obj.select_set(obj == armature or obj.find_armature() == armature)
    bpy.context.view_layer.objects.active = armature


EXPORTS = (
    Export(".fbx", "FBX", _write_fbx),
    Export(".glb", "glTF", _write_glb),
    Export(".bvh", "BVH", _write_bvh),
)
"""Every kind, in the order of the help."""

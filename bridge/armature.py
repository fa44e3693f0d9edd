"""Armature objects as rigs, and rigs as new armature objects."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import bpy
import numpy as np
from mathutils import Matrix

from ..core.body import hierarchy
from ..core.body.skeleton import RIG_ROLES, ROLES
from ..core.errors import InputError
from ..core.mocap.families import NamingFamily, families
from ..core.mocap.roles import match_roles
from ..core.presets import Presets
from ..core.rig.limbs import whole_limbs
from ..core.rig.mirror import unmirrored
from ..core.rig.rig import Rig
from .mechanism import passed_over
from .soles import sole_depth

ROLE_MAP = "footwork_roles"
"""Custom property of an armature object: role -> bone name for what was set by hand, "" for "no bone"."""


def armature_to_rig(obj: bpy.types.Object, metres_per_unit: float = 1.0) -> Rig:
    """Read the rest pose and world transform of an armature object.

    Roles come from the bone names, and from the object's role map where that says otherwise.

    Args:
        obj: the armature object.
        metres_per_unit: scale of the scene's unit; becomes part of the rig's world transform.

    Raises:
        InputError: it is no armature, or required roles are without a bone.
    """
    names, parents, bones = _hierarchy(obj)
    roles = _roles(obj, names, role_map(obj))
    world = np.array(obj.matrix_world, dtype=np.float64)
    world[:3] *= metres_per_unit
    world[:3, :3] *= _carried_scale(obj, role_map(obj).get("hips", ""))
    order, parents = _as_moved(obj, names, parents)
    parents = _lifted(parents, [roles[bone] for bone in order], obj, [names[bone] for bone in order])
    rig = Rig(
        name=obj.name,
        bones=tuple(names[bone] for bone in order),
        parents=np.array(parents, dtype=np.intp),
        rest=np.array([bones[bone].matrix_local for bone in order], dtype=np.float64).reshape(-1, 4, 4),
        tails=np.array([bones[bone].tail_local for bone in order], dtype=np.float64).reshape(-1, 3),
        world=world,
        roles=tuple(roles[bone] for bone in order),
        loose=tuple(bone.name for bone in bones if bone.parent and not bone.use_inherit_rotation),
    )
    depth = sole_depth(obj, {role: bone for role, bone in role_map(obj).items() if bone})
    sole = None if depth is None else depth * metres_per_unit
    return whole_limbs(unmirrored(replace(rig, sole=sole)))


def _carried_scale(obj: bpy.types.Object, hips: str) -> float:
    """How many times as large the bones above the hips make the body in its present pose; 1 if not evenly."""
    bone = obj.pose.bones.get(hips)
    if bone is None or bone.parent is None:
        return 1.0
    scale = bone.parent.matrix.to_scale()
    return scale.x if max(scale) - min(scale) < 1e-3 * abs(scale.x) else 1.0


def carrier_of(hips: bpy.types.PoseBone) -> bpy.types.PoseBone:
    """The bone whose location moves the hips: the hips, or the first above that is not connected to its parent."""
    bone = hips
    while bone.parent is not None and bone.bone.use_connect:
        bone = bone.parent
    return bone


def detected_roles(obj: bpy.types.Object) -> dict[str, str]:
    """Role -> bone name as found from the names alone; empty where no preset fits."""
    return dict(_detected(obj)[1])


def detected_preset(obj: bpy.types.Object) -> tuple[str, tuple[str, ...]]:
    """Name of the naming that fits the armature ("" for none), and what is doubtful about it."""
    preset, _, doubts = _detected(obj)
    return preset, doubts


def role_map(obj: bpy.types.Object) -> dict[str, str]:
    """Role -> bone name in use: what was detected, overruled by what was set by hand."""
    return {**detected_roles(obj), **role_overrides(obj)}


def role_overrides(obj: bpy.types.Object) -> dict[str, str]:
    """Role -> bone name as set by hand."""
    stored = obj.get(ROLE_MAP)
    return {} if stored is None else {role: bone for role, bone in stored.to_dict().items() if role in ROLES}


def set_role(obj: bpy.types.Object, role: str, bone: str) -> None:
    """Set by hand which bone plays a role; "" for none. The detected bone removes the entry."""
    overrides = role_overrides(obj)
    overrides.pop(role, None)
    if detected_roles(obj).get(role, "") != bone:
        overrides[role] = bone
    set_roles(obj, overrides)


def set_roles(obj: bpy.types.Object, overrides: Mapping[str, str]) -> None:
    """Replace everything that was set by hand; an empty map goes back to what is detected."""
    if overrides:
        obj[ROLE_MAP] = dict(overrides)
    elif ROLE_MAP in obj:
        del obj[ROLE_MAP]


def rig_doubts(obj: bpy.types.Object) -> tuple[str, ...]:
    """One line for each thing on the armature that will show in, or spoil, a bake."""
    mapped = [obj.pose.bones[bone] for bone in role_map(obj).values() if bone in obj.pose.bones]
    doubts = [*families().skipped, *detected_preset(obj)[1]]
    if _armature(obj).pose_position == "REST":
        doubts.append("It is shown in rest position and will not move: switch to pose position")
    if any(not constraint.mute for constraint in obj.constraints):
        doubts.append("Constraints act on the object: where they move it, the bake goes along")
    constrained = [bone.name for bone in mapped if any(not c.mute for c in bone.constraints)]
    if constrained:
        doubts.append(f"Constraints act on {some(constrained)} and go on top of the bake")
    loose = [bone.name for bone in mapped if bone.parent and not bone.bone.use_inherit_rotation]
    if loose:
        doubts.append(f"{some(loose)}: Inherit Rotation is off, the pose will differ")
    data = obj.animation_data
    if data is not None and any(not track.mute for track in data.nla_tracks):
        doubts.append("NLA tracks are active and play below the bake")
    if data is not None:
        driven = [
            bone.name
            for bone in mapped
            if any(d.data_path.startswith(f"{bone.path_from_id()}.rotation") for d in data.drivers)
        ]
        if driven:
            doubts.append(f"Drivers win over keys on {some(driven)}")
    return tuple(doubts)


def create_armature(
    rig: Rig, name: str, collection: bpy.types.Collection, metres_per_unit: float = 1.0
) -> bpy.types.Object:
    """Make a new armature object from a rig, its bones in quaternion mode, and leave the mode as it was.

    It goes to the scene's own collection where `collection` is linked or hidden in the active view layer.
    """
    layer = bpy.context.view_layer
    before = layer.objects.active
    mode = before.mode if before is not None else "OBJECT"
    if mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    obj = bpy.data.objects.new(name, bpy.data.armatures.new(name))
    home = collection if collection.is_editable else bpy.context.scene.collection
    home.objects.link(obj)
    if not obj.visible_get(view_layer=layer):
        home.objects.unlink(obj)
        bpy.context.scene.collection.objects.link(obj)
    layer.objects.active = obj
    bpy.ops.object.mode_set(mode="EDIT")
    bones = []
    for index, bone in enumerate(rig.bones):
        edit = _armature(obj).edit_bones.new(bone)
        length = float(np.linalg.norm(rig.tails[index] - rig.rest[index, :3, 3]))
        # Blender drops bones without length when edit mode is left
        edit.tail = (0.0, max(length, 1e-3), 0.0)
        edit.matrix = Matrix(rig.rest[index].tolist())
        edit.parent = bones[rig.parents[index]] if rig.parents[index] >= 0 else None
        bones.append(edit)
    bpy.ops.object.mode_set(mode="OBJECT")
    world = np.array(rig.world, dtype=np.float64)
    world[:3] /= metres_per_unit
    obj.matrix_world = Matrix(world.tolist())
    layer.objects.active = before
    if mode != "OBJECT":
        bpy.ops.object.mode_set(mode=mode)
    layer.update()
    return obj


def _armature(obj: bpy.types.Object) -> bpy.types.Armature:
    assert isinstance(obj.data, bpy.types.Armature)
    return obj.data


def _hierarchy(
    obj: bpy.types.Object,
) -> tuple[tuple[str, ...], tuple[int, ...], list[bpy.types.Bone]]:
    if obj.type != "ARMATURE":
        raise InputError(f"{obj.name}: it is a {obj.type.lower()}, not an armature")
    bones = list(_armature(obj).bones)
    index = {bone.name: number for number, bone in enumerate(bones)}
    parents = [-1 if bone.parent is None else index[bone.parent.name] for bone in bones]
    # Blender lists bones from the roots down
    assert all(parent < number for number, parent in enumerate(parents))
    return tuple(index), tuple(parents), bones


def _as_moved(
    obj: bpy.types.Object, names: tuple[str, ...], parents: tuple[int, ...]
) -> tuple[list[int], list[int]]:
    """The bones parents first, and their parents in that order, with bones that copy another below that one.

    Rigify hangs an arm on a bone that copies the shoulder's control: keys on the control move the arm.
    """
    index = {name: number for number, name in enumerate(names)}
    above = list(parents)
    for number, name in enumerate(names):
        leader = index.get(_copied(obj, obj.pose.bones[name]), -1)
        if leader >= 0 and number not in (leader, *hierarchy.above(above, leader)):
            above[number] = leader
    depths = [len(hierarchy.above(above, number)) for number in range(len(names))]
    order = list(range(len(names)))
    if any(parent > number for number, parent in enumerate(above)):
        order.sort(key=lambda number: depths[number])
    place = {bone: number for number, bone in enumerate(order)}
    return order, [place[above[bone]] if above[bone] >= 0 else -1 for bone in order]


def _lifted(
    parents: Sequence[int], roles: Sequence[str], obj: bpy.types.Object, names: Sequence[str]
) -> list[int]:
    """The parents, with bones that are to have keys directly below the next above that is to have any."""
    passed = passed_over(obj, [name for name, role in zip(names, roles, strict=True) if role])
    out = [int(parent) for parent in parents]
    for bone in hierarchy.with_ancestors(parents, [bone for bone, role in enumerate(roles) if role]):
        while out[bone] >= 0 and names[out[bone]] in passed:
            out[bone] = int(parents[out[bone]])
    return out


def _copied(obj: bpy.types.Object, bone: bpy.types.PoseBone) -> str:
    """The bone of the same rest pose that this one does nothing but copy, "" for none."""
    active = [c for c in bone.constraints if not c.mute and c.influence > 0.0]
    copy = active[0] if len(active) == 1 else None
    if not isinstance(copy, bpy.types.CopyTransformsConstraint) or copy.influence < 1.0:
        return ""
    leader = obj.pose.bones.get(copy.subtarget) if copy.target == obj else None
    if (
        leader is None
        or copy.mix_mode != "REPLACE"
        or {copy.owner_space, copy.target_space} - {"WORLD", "POSE"}
    ):
        return ""
    same = np.allclose(np.array(leader.bone.matrix_local), np.array(bone.bone.matrix_local), atol=1e-4)
    return leader.name if same else ""


def _detected(obj: bpy.types.Object) -> tuple[str, tuple[tuple[str, str], ...], tuple[str, ...]]:
    names, parents, bones = _hierarchy(obj)
    return _detect(names, parents, _heads(bones).tobytes(), families())


def _heads(bones: list[bpy.types.Bone]) -> np.ndarray:
    """`(1, B, 3)` where bones start at rest."""
    return np.array([bone.head_local for bone in bones], dtype=np.float64).reshape(1, -1, 3)


@lru_cache(maxsize=16)
def _detect(
    names: tuple[str, ...], parents: tuple[int, ...], heads: bytes, known: Presets[NamingFamily]
) -> tuple[str, tuple[tuple[str, str], ...], tuple[str, ...]]:
    def rest() -> np.ndarray:
        return np.frombuffer(heads).reshape(1, -1, 3)

    try:
        match = match_roles(
            names, np.array(parents, dtype=np.intp), known.entries, RIG_ROLES, apart=True, poses=rest
        )
    except InputError:
        return "", (), ()
    pairs = tuple((role, name) for role, name in zip(match.roles, names, strict=True) if role)
    return match.family, pairs, tuple(match.doubts)


def _roles(obj: bpy.types.Object, names: tuple[str, ...], wanted: Mapping[str, str]) -> tuple[str, ...]:
    chosen = {role: bone for role, bone in wanted.items() if bone}
    absent = [bone for bone in chosen.values() if bone not in names]
    if absent:
        raise InputError(
            f"{obj.name}: its role map names {absent[0]!r}, which it has not; choose another bone"
        )
    twice = [bone for bone in chosen.values() if list(chosen.values()).count(bone) > 1]
    if twice:
        raise InputError(f"{obj.name}: {twice[0]!r} has two roles in its role map; leave one")
    without = [role for role in RIG_ROLES if role not in chosen]
    if without:
        # of no family's names the nearest one's gap tells more than a list of all roles
        told = _why_not(obj) if len(without) == len(RIG_ROLES) else f"no bone for {', '.join(without)}"
        raise InputError(f"{obj.name}: {told}, or set them in the role map")
    role_of = {bone: role for role, bone in chosen.items()}
    return tuple(role_of.get(name, "") for name in names)


def _why_not(obj: bpy.types.Object) -> str:
    """Why no naming family fits the armature."""
    names, parents, bones = _hierarchy(obj)
    try:
        match_roles(
            names,
            np.array(parents, dtype=np.intp),
            None,
            RIG_ROLES,
            apart=True,
            poses=lambda: _heads(bones),
        )
    except InputError as error:
        return str(error)
    return "no bone has a role"


def some(names: list[str]) -> str:
    """Three names at most, and how many more there are."""
    return ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")

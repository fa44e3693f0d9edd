"""Bones that a rig moves by itself, drivers by bone, and the bones that show where a control puts the body."""

from __future__ import annotations

import re
from collections.abc import Collection
from typing import Any

import bpy
import numpy as np

SWITCHES = {"IK_FK": 1.0, "ik_fk_switch": 1.0, "FK_limb_follow": 0.0, "neck_follow": 1.0, "head_follow": 1.0}
"""Switches of Rigify and Auto-Rig Pro on pose bones: the value with which keys on FK controls show as they are."""
BLENDS = ("IK_FK", "ik_fk_switch")
"""Those that blend a limb between its controls for IK and for FK."""
_OF_BONE = re.compile(r'pose\.bones\["((?:[^"\\]|\\.)*)"\]')
_TRANSFORM = re.compile(r"\.(location|rotation_\w+|scale)$")
_SAME_AXIS, _SAME_PLACE = 0.9999, 1e-3
"""Cosine between axes at rest; distance of heads in lengths of the control."""

Drivers = dict[str, list[tuple[str, bpy.types.FCurve]]]
"""Bone name -> what follows the bone in a driver's data path, and the driver."""


def split_path(path: str) -> tuple[str, str]:
    """Bone and property of a data path such as `pose.bones["a"]["b"]` or `pose.bones["a"].location`; "" for none."""
    found = _OF_BONE.match(path)
    if found is None:
        return "", ""
    rest = path[found.end() :]
    if rest.startswith('["'):
        rest = bpy.utils.unescape_identifier(rest[2:-2])
    return bpy.utils.unescape_identifier(found[1]), rest


def drivers_of(obj: bpy.types.Object) -> Drivers:
    """The drivers on an armature object's pose bones."""
    out: Drivers = {}
    for curve in obj.animation_data.drivers if obj.animation_data else ():
        bone, rest = split_path(curve.data_path)
        if bone:
            out.setdefault(bone, []).append((rest, curve))
    return out


def read_by(curve: bpy.types.FCurve) -> list[tuple[str, str]]:
    """Bone and property of everything that a driver reads from pose bones by their data path."""
    assert curve.driver is not None
    pairs = [split_path(t.data_path) for variable in curve.driver.variables for t in variable.targets]
    return [pair for pair in pairs if pair[0]]


def is_mechanism(bone: bpy.types.PoseBone, drivers: Drivers) -> bool:
    """Whether a bone without a role is the rig's to move: it is constrained, driven, or locked altogether."""
    if any(not constraint.mute for constraint in bone.constraints):
        return True
    if any(_TRANSFORM.search(rest) for rest, _ in drivers.get(bone.name, ())):
        return True
    return is_locked(bone.lock_location) and is_locked(bone.lock_rotation)


def is_locked(lock: Any) -> bool:
    """Whether a lock of location or rotation is on in all three axes."""
    return bool(np.all(lock))


def passed_over(obj: bpy.types.Object, roles: Collection[str]) -> set[str]:
    """Bones without a role that no key goes to: mechanism, and controls beside those with roles.

    Args:
        obj: the armature object.
        roles: names of the bones with roles.
    """
    drivers = drivers_of(obj)
    deforming = any(bone.bone.use_deform for bone in obj.pose.bones)
    return {
        bone.name
        for bone in obj.pose.bones
        if bone.name not in roles
        and (is_mechanism(bone, drivers) or (deforming and not bone.bone.use_deform))
    }


def shown_by(obj: bpy.types.Object, names: Collection[str]) -> dict[str, str]:
    """Control -> the deforming bone that starts where it does at rest and runs the same way; itself without one."""
    bones: Any = obj.data.bones  # pyright: ignore[reportAttributeAccessIssue]
    deforming = [bone for bone in bones if bone.use_deform]
    out = {name: name for name in names}
    if not deforming:
        return out
    heads = np.array([bone.head_local for bone in deforming])
    axes = np.array([_axis(bone) for bone in deforming])
    for name in names:
        bone = bones.get(name)
        if bone is None or bone.use_deform:
            continue
        apart = np.linalg.norm(heads - np.array(bone.head_local), axis=1)
        apart[axes @ _axis(bone) < _SAME_AXIS] = np.inf
        nearest = int(np.argmin(apart))
        if apart[nearest] < _SAME_PLACE * bone.length:
            out[name] = deforming[nearest].name
    return out


def _axis(bone: bpy.types.Bone) -> np.ndarray:
    """The way a bone runs at rest, in armature space; a bone's own `y_axis` is its parent's."""
    return np.array(bone.matrix_local)[:3, 1]

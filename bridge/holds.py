"""What has to hold still beside keyed bones so that the rig shows their keys: controls at rest, and switches."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import bpy

from .mechanism import BLENDS, SWITCHES, Drivers, drivers_of, is_mechanism, read_by, shown_by


@dataclass(frozen=True, slots=True)
class Holds:
    """What one key each is to hold."""

    controls: tuple[str, ...]
    """Bones that are to stay at rest."""
    switches: tuple[tuple[str, str, float], ...]
    """Bone, custom property and value."""


def holds(obj: bpy.types.Object, keyed: Sequence[str]) -> Holds:
    """What between, or above, the bones that show the keys would otherwise change what they show.

    Found by going from keyed bones, and from the deforming bones that show them, to parents and to what constraints
    copy. Inverse kinematics is passed over: the switches that are found on the way turn it off. Bones above the hips
    are left as they are, whatever moves them.

    Args:
        obj: the armature object.
        keyed: names of keyed bones, the hips first.
    """
    drivers = drivers_of(obj)
    switches: dict[tuple[str, str], float] = {}
    hips = obj.pose.bones[keyed[0]]
    over = _reached(obj, _next(obj, hips, drivers, {}), drivers, set(keyed), {})
    start = {*keyed, *shown_by(obj, keyed).values()} - {hips.name}
    visited = _reached(obj, start, drivers, {hips.name, *over}, switches)
    between = _connected_above(hips)
    controls = [
        bone.name
        for bone in obj.pose.bones
        if (bone.name in visited or bone.name in between)
        and bone.name not in keyed
        and not is_mechanism(bone, drivers)
    ]
    return Holds(tuple(controls), tuple((*where, value) for where, value in switches.items()))


def above_hips(obj: bpy.types.Object, hips: str) -> set[str]:
    """The bones that the hips hang on or copy, all the way up."""
    drivers = drivers_of(obj)
    return _reached(obj, _next(obj, obj.pose.bones[hips], drivers, {}), drivers, {hips}, {})


def _connected_above(hips: bpy.types.PoseBone) -> list[str]:
    """Bones that carry the hips because these cannot have a location of their own."""
    out, bone = [], hips
    while bone.parent is not None and bone.bone.use_connect:
        bone = bone.parent
        out.append(bone.name)
    return out


def _reached(
    obj: bpy.types.Object,
    start: Iterable[str],
    drivers: Drivers,
    stop: set[str],
    switches: dict[tuple[str, str], float],
) -> set[str]:
    """All bones on the way up from some; switches that drivers on the way read are added to `switches`."""
    todo, visited = [name for name in start if name not in stop], set[str]()
    while todo:
        name = todo.pop()
        if name not in visited:
            visited.add(name)
            above = _next(obj, obj.pose.bones[name], drivers, switches)
            todo += [other for other in above if other not in stop]
    return visited


def _next(
    obj: bpy.types.Object,
    bone: bpy.types.PoseBone,
    drivers: Drivers,
    switches: dict[tuple[str, str], float],
) -> list[str]:
    """What a bone hangs on or copies."""
    out = [] if bone.parent is None else [bone.parent.name]
    own = drivers.get(bone.name, [])
    for constraint in bone.constraints:
        if constraint.mute:
            continue
        path = f'.constraints["{bpy.utils.escape_identifier(constraint.name)}"]'
        read = [pair for rest, curve in own if rest.startswith(path) for pair in read_by(curve)]
        found = [(name, prop) for name, prop in read if prop in SWITCHES and prop in obj.pose.bones[name]]
        switches.update({pair: SWITCHES[pair[1]] for pair in found})
        blended = any(prop in BLENDS for _, prop in found)
        if constraint.type in ("IK", "SPLINE_IK") or blended:
            continue
        parts: list[Any] = list(getattr(constraint, "targets", ())) or [constraint]
        named = [part.subtarget for part in parts if getattr(part, "target", None) == obj]
        out += [name for name in named if name in obj.pose.bones]
    return out

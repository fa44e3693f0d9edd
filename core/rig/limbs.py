"""Limbs as bodies have them, of rigs whose bones hang otherwise: feet on the root, arms that end at the wrist."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..body import hierarchy
from ..body.skeleton import ARM, LEG, SIDES
from .rig import Rig

_LONG = (0.4, 1.6)
"""A forearm in upper arms; the tail of a bone elsewhere is an importer's invention."""


def whole_limbs(rig: Rig) -> Rig:
    """The rig with every limb in one piece.

    A bone with a role that is not below the bone of the same limb before it, or a thigh that is not below the hips, is
    put there, and among `placed` with the parent that it has. Where a rig has no bone for a hand, one stands in that
    is in no armature (`absent`), at the end of the forearm.
    """
    return _in_order(_with_parents(_with_hands(rig)))


def _with_hands(rig: Rig) -> Rig:
    """A bone at the end of each forearm without a hand."""
    for side in SIDES:
        arm = [f"{part}.{side}" for part in ("upper_arm", "forearm")]
        if f"hand.{side}" in rig.roles or any(role not in rig.roles for role in arm):
            continue
        upper, lower = (rig.roles.index(role) for role in arm)
        rest = np.array(rig.rest[lower], dtype=np.float64)
        along = rest[:3, 3] - rig.rest[upper, :3, 3]
        bone = rig.tails[lower] - rest[:3, 3]
        length = np.linalg.norm(along)
        likely = _LONG[0] * length <= np.linalg.norm(bone) <= _LONG[1] * length and bone @ along > 0.0
        rest[:3, 3] += bone if likely else along
        name = f"{rig.bones[lower]} end"
        rig = replace(
            rig,
            bones=(*rig.bones, name),
            parents=np.append(rig.parents, lower),
            rest=np.concatenate([rig.rest, rest[None]]),
            tails=np.concatenate([rig.tails, rest[None, :3, 3]]),
            roles=(*rig.roles, f"hand.{side}"),
            absent=(*rig.absent, name),
        )
    return rig


def _with_parents(rig: Rig) -> Rig:
    """Bones with roles below the bone of their limb that comes before."""
    parents = rig.parents.copy()
    placed = dict(rig.placed)
    for bone, role in enumerate(rig.roles):
        part, _, side = role.partition(".")
        limb = ARM if part in ARM else LEG
        if not side:
            continue
        before = [f"{name}.{side}" for name in limb[: limb.index(part)]]
        wanted = next((r for r in reversed(before) if r in rig.roles), "hips")
        if wanted not in rig.roles:
            continue
        leader = rig.roles.index(wanted)
        if (
            leader == bone
            or leader in hierarchy.above(parents, bone)
            or bone in hierarchy.above(parents, leader)
        ):
            continue
        placed[rig.bones[bone]] = rig.bones[rig.parents[bone]] if rig.parents[bone] >= 0 else ""
        parents[bone] = leader
    return replace(rig, parents=parents, placed=tuple(placed.items()))


def _in_order(rig: Rig) -> Rig:
    """The same bones, parents first."""
    if all(parent < bone for bone, parent in enumerate(rig.parents.tolist())):
        return rig
    depths = [len(hierarchy.above(rig.parents, bone)) for bone in range(len(rig.bones))]
    order = sorted(range(len(depths)), key=depths.__getitem__)
    place = np.empty(len(order) + 1, dtype=np.intp)
    place[order], place[-1] = np.arange(len(order)), -1
    return replace(
        rig,
        bones=tuple(rig.bones[bone] for bone in order),
        parents=place[rig.parents[order]],
        rest=rig.rest[order],
        tails=rig.tails[order],
        roles=tuple(rig.roles[bone] for bone in order),
    )

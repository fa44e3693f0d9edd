"""A Blender armature as a canonical skeleton.

With a joint's world rotation since T-pose D, the bone's world rotation in T-pose T and the object's
rotation Q, the bone's pose in armature space is `Q^-1 D T`. T comes from the rest pose with its limbs
turned into T-pose, so a rig at rest in A-pose takes the same D as one in T-pose.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body import hierarchy
from ..body.skeleton import CENTRE_ROLES, REQUIRED_ROLES, ROLES, SIDES, Skeleton
from ..errors import InputError
from ..maths import quat
from ..mocap.tpose import tpose_rotations
from .rig import Rig

Array = NDArray[np.floating[Any]]


_UPRIGHT = -0.35
"""Cosine between trunk and legs at rest: -1 for who stands, 0 for animals on four legs."""
_DEEPEST_SOLE = 0.3
"""Of a leg's length: no sole is farther under the joints of the feet."""
_FACING = quat.from_yaw(np.pi)


@dataclass(frozen=True, slots=True, eq=False)
class RigFit:
    """A rig as a canonical skeleton in world metres, and the way back to its bones."""

    rig: Rig
    skeleton: Skeleton
    bones: NDArray[np.intp]
    """`(J,)` the rig's bone of each joint."""
    tpose: Array
    """`(J, 4)` world rotation of each bone in T-pose facing +Y."""
    rest: Array
    """`(J, 4)` rotation of each bone at rest, armature space."""
    turn: Array
    """`(4,)` the object's world rotation."""
    scale: float
    """World metres per armature unit."""

    def to_armature(self, points: Array) -> Array:
        """World points `(..., 3)` in metres as armature space."""
        return quat.rotate(quat.conjugate(self.turn), points - self.rig.world[:3, 3]) / self.scale


def fit_rig(rig: Rig) -> RigFit:
    """The canonical skeleton of a rig: its bones with roles and the bones between them.

    Raises:
        InputError: required roles are missing, given twice or not below the hips, a limb has no length, or
            the object is mirrored or scaled unevenly.
    """
    turn, scale = _object_transform(rig)
    bones = _joints(rig)
    parents = np.array([bones.index(int(rig.parents[b])) if k else -1 for k, b in enumerate(bones)], np.intp)
    roles = tuple(rig.roles[b] for b in bones)
    rest = quat.from_matrix(np.asarray(rig.rest[bones, :3, :3], np.float64))
    heads = np.asarray(rig.rest[bones, :3, 3], np.float64)
    world_rest = quat.multiply(turn, rest)
    world_heads = quat.rotate(turn, heads * scale)
    _check_limbs(rig, roles, world_heads)
    tpose = tpose_rotations(parents, roles, world_rest, world_heads, None)
    straighten = quat.multiply(tpose, quat.conjugate(world_rest))
    offsets = np.zeros((len(bones), 3))
    offsets[1:] = quat.rotate(straighten[parents[1:]], world_heads[1:] - world_heads[parents[1:]])
    tips = _likely(roles, quat.rotate(straighten, quat.rotate(turn, _tips(rig, bones) * scale)))
    names = tuple(rig.bones[b] for b in bones)
    skeleton = Skeleton(names, parents, offsets, roles, tips)
    offsets[0] = [0.0, 0.0, _hips_height(skeleton, float(rig.world[2, 3]), world_heads, rig.sole)]
    return RigFit(rig, skeleton, np.array(bones, np.intp), tpose, rest, turn, scale)


def rig_from_skeleton(skeleton: Skeleton, name: str) -> Rig:
    """An armature in T-pose, standing at the origin and facing -Y as Blender's front view expects.

    Bones run along their Y axis to the next joint; upright bones have Z forward, others Z up, so that left
    and right are mirror images as Blender's flipped pasting needs.
    """
    heads = quat.rotate(_FACING, skeleton.tpose_positions())
    ends = heads + quat.rotate(_FACING, _bone_vectors(skeleton))
    y = (ends - heads) / np.linalg.norm(ends - heads, axis=-1, keepdims=True)
    upright = np.abs(y[:, 2:]) > np.sqrt(0.5)
    z = np.where(upright, np.array([0.0, -1.0, 0.0]), np.array([0.0, 0.0, 1.0]))
    x = np.cross(y, z)
    x /= np.linalg.norm(x, axis=-1, keepdims=True)
    rest = np.tile(np.eye(4), (len(skeleton), 1, 1))
    rest[:, :3, :3] = np.stack([x, y, np.cross(x, y)], axis=-1)
    rest[:, :3, 3] = heads
    return Rig(name, skeleton.names, skeleton.parents, rest, ends, np.eye(4), skeleton.roles)


def _object_transform(rig: Rig) -> tuple[Array, float]:
    """Rotation `(4,)` and scale of the armature object."""
    matrix = np.asarray(rig.world[:3, :3], np.float64)
    lengths = np.linalg.norm(matrix, axis=0)
    scale = float(lengths.mean())
    if not np.isfinite(matrix).all() or scale < 1e-9:
        raise InputError(f"{rig.name}: the object's scale is zero; give it a scale")
    if np.linalg.det(matrix) < 0.0:
        raise InputError(f"{rig.name}: the object is mirrored by a negative scale; apply its scale first")
    turned = matrix / scale
    if np.abs(turned.T @ turned - np.eye(3)).max() > 2e-3:
        sizes = ", ".join(f"{length:.4g}" for length in lengths)
        raise InputError(f"{rig.name}: the object is scaled unevenly ({sizes}); apply its scale first")
    return quat.from_matrix(matrix / lengths), scale


def _joints(rig: Rig) -> list[int]:
    """Bones with roles and those between, hips first, parents before children."""
    counts = Counter(role for role in rig.roles if role)
    for role, count in counts.items():
        if role not in ROLES:
            raise InputError(f"{rig.name}: {role!r} is no joint role; correct the bone map")
        if count > 1:
            raise InputError(f"{rig.name}: {count} bones have the role {role}; keep one in the bone map")
    missing = [role for role in REQUIRED_ROLES if role not in counts]
    if missing:
        raise InputError(f"{rig.name}: no bone for {', '.join(missing)}; complete the bone map")
    hips = rig.roles.index("hips")
    named = [bone for bone, role in enumerate(rig.roles) if role]
    for bone in named:
        if bone != hips and hips not in hierarchy.above(rig.parents, bone):
            where = f"bone {rig.bones[bone]} ({rig.roles[bone]}) is not below the hips bone {rig.bones[hips]}"
            raise InputError(f"{rig.name}: {where}; correct the bone map")
    over = hierarchy.above(rig.parents, hips)
    return [bone for bone in hierarchy.with_ancestors(rig.parents, named) if bone not in over]


def _tips(rig: Rig, bones: list[int]) -> Array:
    """End of the bone `(J, 3)` from its head, armature space, of joints without children; else zeros."""
    tips = np.zeros((len(bones), 3))
    heads = rig.rest[:, :3, 3]
    for j, bone in enumerate(bones):
        children = np.flatnonzero(rig.parents == bone)
        if not set(children.tolist()) & set(bones):
            # one end bone, as Mixamo's, tells better than a tail that an importer made up
            end = heads[children[0]] if len(children) == 1 else rig.tails[bone]
            tips[j] = end - heads[bone]
    return tips


def _likely(roles: tuple[str, ...], tips: Array) -> Array:
    """Tips without those that point where no such bone does: importers make the tails of last bones up."""
    towards = {
        "head": (0.0, 0.0, 1.0),
        "hand.L": (-1.0, 0.0, 0.0),
        "hand.R": (1.0, 0.0, 0.0),
        **{f"{part}.{side}": (0.0, 1.0, 0.0) for part in ("foot", "toe") for side in SIDES},
    }
    wanted = np.array([towards.get(role, (0.0, 0.0, 0.0)) for role in roles])
    straight = np.sum(tips * wanted, axis=-1) > 0.5 * np.linalg.norm(tips, axis=-1)
    return np.where(straight[:, None], tips, 0.0)


def _hips_height(skeleton: Skeleton, origin: float, world_heads: Array, sole: float | None) -> float:
    """Height of the hips over the floor in T-pose, metres.

    The soles of a rig's mesh stand on the floor. Without a mesh, or where it has none that can be, joints tell:
    characters are made standing on their object's origin, or on the world's floor with the object elsewhere: the first
    of the two near which the feet are at rest is the floor. Else it is set below the feet by the share of a leg that a
    foot joint usually is above its sole.

    Args:
        skeleton: in T-pose, its hips at height 0.
        origin: height of the object in the world, metres.
        world_heads: `(J, 3)` joints at rest in the world's axes, seen from the object, metres.
        sole: metres from the mesh's soles up to the joints of the feet; None without a mesh.
    """
    leg = skeleton.leg_length()
    part = "toe" if skeleton.find("toe.L") >= 0 and skeleton.find("toe.R") >= 0 else "foot"
    feet = [skeleton.joint(f"{part}.{side}") for side in SIDES]
    low, high, usual = (-0.01, 0.10, 0.03) if part == "toe" else (0.0, 0.25, 0.11)
    if sole is not None and 0.0 <= sole <= _DEEPEST_SOLE * leg:
        return sole - float(skeleton.tpose_positions()[feet, 2].mean())
    height = float(world_heads[feet, 2].mean())
    near = [h for h in (height, height + origin) if low * leg <= h <= high * leg]
    return (near[0] if near else usual * leg) - float(skeleton.tpose_positions()[feet, 2].mean())


def _check_limbs(rig: Rig, roles: tuple[str, ...], heads: Array) -> None:
    """Refuse a body whose limbs, trunk or hips have no length; `heads` `(J, 3)`."""
    limbs = (("upper_arm", "forearm", "hand"), ("thigh", "shin", "foot"))
    pairs = [(f"{a}.{side}", f"{b}.{side}") for side in SIDES for limb in limbs for a, b in pairwise(limb)]
    least = 6e-4 * float(np.ptp(heads, axis=0).max())
    for a, b in [*pairs, ("thigh.L", "thigh.R"), ("hips", "head")]:
        if np.linalg.norm(heads[roles.index(a)] - heads[roles.index(b)]) <= least:
            raise InputError(f"{rig.name}: {a} and {b} are at the same place; correct the bone map")
    hips, head = heads[roles.index("hips")], heads[roles.index("head")]
    feet = np.mean([heads[roles.index(f"foot.{side}")] for side in SIDES], axis=0)
    up, down = head - hips, feet - hips
    if up @ down > _UPRIGHT * np.linalg.norm(up) * np.linalg.norm(down):
        raise InputError(f"{rig.name}: at rest its trunk does not stand on its legs: no person's body")


def _bone_vectors(skeleton: Skeleton) -> Array:
    """From each joint to the end of its bone `(J, 3)` in T-pose; never shorter than 1 cm."""
    vectors = np.array(skeleton.tips, np.float64)
    for j in range(len(skeleton)):
        child = _next_joint(skeleton, j)
        if child >= 0:
            vectors[j] = skeleton.offsets[child]
        if np.linalg.norm(vectors[j]) < 0.01:
            vectors[j] = _guess(skeleton, j, vectors)
    return vectors


def _next_joint(skeleton: Skeleton, joint: int) -> int:
    """The child that continues a bone: on the way to the head for the trunk, else the first; -1 without
    one."""
    children = [int(c) for c in np.flatnonzero(skeleton.parents == joint)]
    central = [c for c in children if skeleton.roles[c] in CENTRE_ROLES]
    named = [c for c in children if skeleton.roles[c]]
    return next(iter(central or named or children), -1)


def _guess(skeleton: Skeleton, joint: int, vectors: Array) -> Array:
    """A short bone where nothing tells its end: the head up, a toe forward, others on from their parent."""
    size = 0.1 * skeleton.leg_length()
    role = skeleton.roles[joint].partition(".")[0]
    if role == "head":
        return np.array([0.0, 0.0, 2.5 * size])
    if role in ("toe", "foot"):
        return np.array([0.0, size, 0.0])
    parent = vectors[skeleton.parents[joint]] if joint else np.array([0.0, 0.0, 1.0])
    return parent / np.linalg.norm(parent) * size

"""A Blender armature as arrays, and the keys to write back: what the bridge reads and writes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]


@dataclass(frozen=True, slots=True, eq=False)
class Rig:
    """Rest pose of an armature object, as Blender stores it."""

    name: str
    bones: tuple[str, ...]
    """Bone names `(B,)`, parents before children."""
    parents: NDArray[np.intp]
    """`(B,)` index of the parent bone, -1 for none."""
    rest: Array
    """`(B, 4, 4)` `Bone.matrix_local`: rest in armature space, armature units."""
    tails: Array
    """`(B, 3)` `Bone.tail_local`, armature space."""
    world: Array
    """`(4, 4)` the object's `matrix_world`: uniform scale, rotation, place."""
    roles: tuple[str, ...]
    """`(B,)` humanoid role of each bone, "" for none (see `core.body.skeleton.ROLES`)."""
    loose: tuple[str, ...] = ()
    """Bones whose rotation does not follow their parent's (Blender's Inherit Rotation is off)."""
    placed: tuple[tuple[str, str], ...] = ()
    """Bones that hang on another bone than `parents` says, and that bone, "" for none: their location is keyed too."""
    mirrored: bool = False
    """Whether the armature is this rig's mirror image in its X axis (see `core.rig.mirror`)."""
    absent: tuple[str, ...] = ()
    """Bones that stand in for what the armature does not have."""
    sole: float | None = None
    """Metres from the soles of its mesh up to the toe joints (ankles without toes) at rest; None without a mesh."""


@dataclass(frozen=True, slots=True, eq=False)
class BoneTracks:
    """Pose-bone channels to key on a rig, sampled evenly from time 0."""

    bones: tuple[str, ...]
    """Keyed bones `(K,)`; the first is the hips."""
    fps: float
    locations: Array
    """`(T, 3)` `PoseBone.location` of the hips bone, armature units in the bone's own rest axes."""
    rotations: Array
    """`(T, K, 4)` `PoseBone.rotation_quaternion`, sign-continuous."""
    placed: tuple[str, ...] = ()
    """Further bones `(P,)` whose location is keyed."""
    places: Array = field(default_factory=lambda: np.zeros((0, 0, 3)))
    """`(T, P, 3)` `PoseBone.location` of those."""

"""World poses of chosen joints, and world rotations of chosen joints back into a motion."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..maths import quat
from ..mocap.skeleton import Motion, Skeleton

Array = NDArray[np.floating[Any]]


def with_ancestors(skeleton: Skeleton, joints: Iterable[int]) -> list[int]:
    """Joints and all joints above them, parents before children."""
    found: set[int] = set()
    for joint in joints:
        walk = joint
        while walk >= 0 and walk not in found:
            found.add(walk)
            walk = int(skeleton.parents[walk])
    return sorted(found)


def world_rotations(motion: Motion, joints: Iterable[int]) -> dict[int, Array]:
    """World rotations since T-pose `(T, 4)` of some joints and of those above them."""
    out: dict[int, Array] = {}
    for joint in with_ancestors(motion.skeleton, joints):
        local = motion.rotations[:, joint]
        out[joint] = quat.multiply(out[int(motion.skeleton.parents[joint])], local) if joint else local
    return out


def world_positions(motion: Motion, rotations: Mapping[int, Array]) -> dict[int, Array]:
    """World positions `(T, 3)` in metres of the joints whose `world_rotations` are given."""
    skeleton = motion.skeleton
    out: dict[int, Array] = {0: motion.positions}
    for joint in sorted(rotations):
        if joint:
            above = int(skeleton.parents[joint])
            out[joint] = out[above] + quat.rotate(rotations[above], skeleton.offsets[joint])
    return out


def with_world_rotations(
    motion: Motion, wanted: Mapping[int, Array], positions: Array | None = None
) -> Motion:
    """`motion` with some joints' world rotations set; all other joints keep their local rotations.

    Args:
        motion: the motion to change.
        wanted: world rotations since T-pose `(T, 4)` by joint.
        positions: `(T, 3)` new places of the hips, metres; as they are by default.
    """
    parents = motion.skeleton.parents
    rotations = motion.rotations.copy()
    world: dict[int, Array] = {}
    for joint in with_ancestors(motion.skeleton, wanted):
        local = motion.rotations[:, joint]
        if joint in wanted:
            world[joint] = wanted[joint]
            local = (
                quat.multiply(quat.conjugate(world[int(parents[joint])]), wanted[joint])
                if joint
                else wanted[joint]
            )
            rotations[:, joint] = quat.continuous(local)
        else:
            world[joint] = quat.multiply(world[int(parents[joint])], local) if joint else local
    return replace(
        motion, rotations=rotations, positions=motion.positions if positions is None else positions
    )

"""World poses of chosen joints of a motion, and world rotations of chosen joints back into it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..maths import quat
from . import forward_kinematics as fk
from . import hierarchy
from .motion import Motion

Array = NDArray[np.floating[Any]]


def world_poses(motion: Motion, joints: Iterable[int]) -> tuple[dict[int, Array], dict[int, Array]]:
    """World positions `(T, 3)` in metres and rotations since T-pose `(T, 4)` of joints and of those above them."""
    skeleton = motion.skeleton
    order = hierarchy.with_ancestors(skeleton.parents, joints)
    positions, rotations = fk.forward(
        motion.positions,
        motion.rotations[:, order],
        skeleton.offsets[order],
        hierarchy.part(skeleton.parents, order),
    )
    return (
        {joint: positions[:, k] for k, joint in enumerate(order)},
        {joint: rotations[:, k] for k, joint in enumerate(order)},
    )


def role_poses(motion: Motion, roles: Sequence[str]) -> tuple[Array, Array]:
    """World positions `(T, n, 3)` and rotations since T-pose `(T, n, 4)` of the joints with these roles."""
    joints = [motion.skeleton.joint(role) for role in roles]
    positions, rotations = world_poses(motion, joints)
    return (
        np.stack([positions[joint] for joint in joints], axis=1),
        np.stack([rotations[joint] for joint in joints], axis=1),
    )


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
    for joint in hierarchy.with_ancestors(parents, wanted):
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

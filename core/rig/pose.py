"""World rotations of chosen joints back into a motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..maths import quat
from ..mocap.skeleton import Motion

Array = NDArray[np.floating[Any]]


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

    def find(joint: int) -> Array:
        """World rotation of a joint after the change; sets the local one where it is wanted."""
        if joint not in world:
            above = find(int(parents[joint])) if joint else None
            if joint in wanted:
                world[joint] = wanted[joint]
                local = (
                    wanted[joint] if above is None else quat.multiply(quat.conjugate(above), wanted[joint])
                )
                rotations[:, joint] = quat.continuous(local)
            elif above is None:
                world[joint] = rotations[:, 0]
            else:
                world[joint] = quat.multiply(above, rotations[:, joint])
        return world[joint]

    for joint in sorted(wanted):
        find(joint)
    return replace(
        motion, rotations=rotations, positions=motion.positions if positions is None else positions
    )

"""Takes of one body or of several, brought onto one skeleton."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body import forward_kinematics as fk
from ..body.motion import Motion
from ..body.retarget import retarget
from ..body.skeleton import Skeleton
from ..maths import quat

Array = NDArray[np.floating[Any]]

_SAME = 1e-4
"""Metres: offsets that differ less are the same."""
_CONGRUENT = 1e-3
"""Metres: how far joints may move where one body was read twice."""


def carry_over(motion: Motion, skeleton: Skeleton) -> Motion:
    """The motion on the skeleton `skeleton`.

    Where a file has no T-pose, it is estimated from the take, so two takes of one body can differ in their
    T-poses. Such a motion is told since the other T-pose, which moves no joint. A motion of another body is
    retargeted by joint role.
    """
    source = motion.skeleton
    if source.roles != skeleton.roles or not np.array_equal(source.parents, skeleton.parents):
        return retarget(motion, skeleton)
    if np.allclose(source.offsets[1:], skeleton.offsets[1:], rtol=0.0, atol=_SAME):
        return replace(motion, skeleton=skeleton)
    turns = tpose_turns(source, skeleton)
    moved = quat.rotate(turns[skeleton.parents[1:]], skeleton.offsets[1:]) - source.offsets[1:]
    if np.linalg.norm(moved, axis=-1).max() > _CONGRUENT:
        return retarget(motion, skeleton)
    rotations = quat.multiply(motion.forward()[1], turns)
    return Motion(skeleton, motion.fps, motion.positions, fk.local_rotations(rotations, skeleton.parents))


def tpose_turns(source: Skeleton, target: Skeleton) -> Array:
    """Rotations `(J, 4)` that lay the bones of the target's T-pose on those of the source's.

    Each joint's is the least-squares fit over the bones that start at it (Kabsch 1976). Where they leave a twist
    free, or there are none, it follows the parent's.
    """
    turns = np.empty((len(target), 3, 3))
    for j, parent in enumerate(target.parents.tolist()):
        children = np.flatnonzero(target.parents == j)
        goals, bones = source.offsets[children], target.offsets[children]
        if len(children) == 0:
            goals, bones = source.tips[j : j + 1], target.tips[j : j + 1]
        prior = turns[parent] if parent >= 0 else np.eye(3)
        u, _, vt = np.linalg.svd(goals.T @ bones + 1e-8 * prior)
        handed = np.array([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
        turns[j] = (u * handed) @ vt
    return quat.from_matrix(turns)

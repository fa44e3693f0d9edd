"""The parts of a body between its legs and its head: pelvis, spine and neck, whatever joints they have."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import hierarchy
from .skeleton import SIDES, Skeleton

Array = NDArray[np.floating[Any]]


def pelvis(skeleton: Skeleton) -> list[int]:
    """Joints that move as one with the hips: those, and that part of a spine from which thighs hang."""
    thighs = [hierarchy.path(skeleton.parents, 0, skeleton.joint(f"thigh.{side}"))[:-1] for side in SIDES]
    trunk = hierarchy.path(skeleton.parents, 0, skeleton.joint("head"))
    return [joint for joint in trunk if any(joint in thigh for thigh in thighs)]


def spine(skeleton: Skeleton) -> list[int]:
    """Joints from the last of the pelvis to the last of the back, the chest: one where there is no spine."""
    chain = hierarchy.path(skeleton.parents, pelvis(skeleton)[-1], skeleton.joint("head"))[:-1]
    for end in ("chest", "neck"):
        joint = skeleton.find(end)
        if joint in chain:
            return chain[: max(chain.index(joint) + (end == "chest"), 1)]
    return chain


def neck(skeleton: Skeleton) -> list[int]:
    """Joints above the chest below the head; empty where the skeleton has none."""
    return hierarchy.path(skeleton.parents, spine(skeleton)[-1], skeleton.joint("head"))[1:-1]


def thighs_middle(skeleton: Skeleton) -> Array:
    """Middle of the two thigh joints `(3,)` from the hips in T-pose, metres."""
    positions = skeleton.tpose_positions()
    thighs = positions[[skeleton.joint(f"thigh.{side}") for side in SIDES]]
    return thighs.mean(axis=0) - positions[0]

"""Skeletons in Footwork's one convention, whatever file they came from.

Every skeleton stands in T-pose at zero rotation, faces +Y, has its left side at -X, up is +Z, units are metres, joint 0
is the hips. So a local rotation is "rotation since T-pose" with axes parallel to the world's in T-pose, and two
skeletons with the same roles can exchange rotations as they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import hierarchy

Array = NDArray[np.floating[Any]]

SIDES = ("L", "R")
SPINE = ("spine1", "spine2", "spine3", "chest")
CENTRE_ROLES = ("hips", *SPINE, "neck", "head")
ARM = ("clavicle", "upper_arm", "forearm", "hand")
LEG = ("thigh", "shin", "foot", "toe")
ROLES = (*CENTRE_ROLES, *(f"{part}.{side}" for side in SIDES for part in (*ARM, *LEG)))
"""Humanoid joint roles, Blender's `.L`/`.R` for sides."""

REQUIRED_ROLES = (
    "hips",
    "head",
    *(
        f"{part}.{side}"
        for side in SIDES
        for part in ("upper_arm", "forearm", "hand", "thigh", "shin", "foot")
    ),
)
"""A body without one of these cannot be used; chest, neck, clavicles, toes and inner spine joints may be missing."""

RIG_ROLES = tuple(role for role in REQUIRED_ROLES if not role.startswith("hand."))
"""What a rig must have; where it has no bone for a hand, its forearms end at the wrists."""


@dataclass(frozen=True, slots=True, eq=False)
class Skeleton:
    """Joints of a humanoid in T-pose (see the module's text), hips first, parents before children."""

    names: tuple[str, ...]
    """Joint names as in the source, `(J,)`."""
    parents: NDArray[np.intp]
    """`(J,)` index of the parent; -1 for the hips."""
    offsets: Array
    """`(J, 3)` metres from the parent joint in T-pose; `offsets[0]` is the hips above the floor point (0, 0, 0)."""
    roles: tuple[str, ...]
    """`(J,)` one of `ROLES`, or "" for joints in between that have none; each role at most once."""
    tips: Array
    """`(J, 3)` metres from a leaf joint to the end of its bone in T-pose; zeros where unknown or not a leaf."""

    def __len__(self) -> int:
        return len(self.names)

    def find(self, role: str) -> int:
        """The joint with this role, or -1."""
        return self.roles.index(role) if role in self.roles else -1

    def joint(self, role: str) -> int:
        """The joint with this role; KeyError where the skeleton has none."""
        index = self.find(role)
        if index < 0:
            raise KeyError(role)
        return index

    def tpose_positions(self) -> Array:
        """Joint positions `(J, 3)` in T-pose, metres, the hips above the origin."""
        positions = np.array(self.offsets)
        for joint in range(1, len(self)):
            positions[joint] += positions[self.parents[joint]]
        return positions

    def leg_length(self) -> float:
        """Thigh plus shin, metres, mean of both sides."""
        ends = [
            (self.joint(f"{first}.{side}"), self.joint(f"{last}.{side}"))
            for side in SIDES
            for first, last in (("thigh", "shin"), ("shin", "foot"))
        ]
        bones = [self.offsets[hierarchy.path(self.parents, *pair)[1:]].sum(axis=0) for pair in ends]
        return float(np.linalg.norm(bones, axis=-1).sum() / 2.0)

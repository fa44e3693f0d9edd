"""The canonical T-pose of any humanoid skeleton: which rotation every joint has when the body stands in T-pose.

Where the skeleton's own zero or rest pose is near a T- or A-pose, that pose is taken and its limbs are straightened.
Where it is not (every bone along one axis, legs pointing up), the pose that the data shows most is taken instead
and straightened in the same way, which keeps the natural twist of the limbs: arms that hang are lifted sideways.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..maths import quat
from .skeleton import ARM, LEG, SIDES, SPINE

Array = NDArray[np.floating[Any]]

UP = np.array([0.0, 0.0, 1.0])
FORWARD = np.array([0.0, 1.0, 0.0])
RIGHT = np.array([1.0, 0.0, 0.0])

NEAR = np.radians(60.0)
"""A bone farther than this from where it points in T-pose is not in T- or A-pose."""
_BEND = np.radians(8.0)
"""A typical bend of elbow or knee below this does not tell the hinge's direction."""
_HINGES = {"upper_arm": ("forearm", FORWARD), "thigh": ("shin", -FORWARD)}
"""Upper bone: the joint that bends, and where the bone after it goes when it bends in T-pose."""


def tpose_rotations(
    parents: NDArray[np.intp],
    roles: tuple[str, ...],
    rest_rotations: Array,
    rest_positions: Array,
    typical: Array | None,
) -> Array:
    """Global rotation of every joint while the body stands in T-pose, faces +Y, left arm along -X, Z up.

    Args:
        parents: `(J,)`, parents before children, -1 for joint 0, the hips.
        roles: `(J,)` joint roles, "" for none.
        rest_rotations: `(J, 4)` global rotations at zero or rest pose, Z up.
        rest_positions: `(J, 3)` joint positions of the same pose, any unit.
        typical: `(J, 4)` global rotations of a pose that the data shows often, Z up, facing +Y, feet as when
            planted; None where there is no data, as for rigs.

    Returns:
        `(J, 4)`.
    """
    body = _Body(parents, roles, rest_rotations, rest_positions, typical)
    for j in range(1, len(parents)):
        body.place(j)
    return body.out


def direction(role: str) -> Array | None:
    """Where the bone from this role's joint to the next one points in T-pose; None where there is no next."""
    part, _, side = role.partition(".")
    if part in ("hips", *SPINE, "neck"):
        return UP
    if part in ARM[:-1]:
        return -RIGHT if side == "L" else RIGHT
    if part in ("thigh", "shin"):
        return -UP
    return FORWARD if part == "foot" else None


def next_roles(role: str) -> tuple[str, ...]:
    """Roles of the joint at the end of this role's bone, the first that a skeleton has counts."""
    part, dot, side = role.partition(".")
    for limb in (ARM, LEG):
        if part in limb[:-1]:
            return (limb[limb.index(part) + 1] + dot + side,)
    centre = ("hips", *SPINE, "neck", "head")
    return centre[centre.index(part) + 1 :] if part in centre else ()


@dataclass(slots=True)
class _Body:
    """The T-pose while it is being made, from the hips outwards."""

    parents: NDArray[np.intp]
    roles: tuple[str, ...]
    rest: Array
    positions: Array
    typical: Array | None
    out: Array
    doubtful: set[int]
    """Joints whose rest pose is far from T-pose."""

    def __init__(
        self,
        parents: NDArray[np.intp],
        roles: tuple[str, ...],
        rest: Array,
        positions: Array,
        typical: Array | None,
    ) -> None:
        self.parents, self.roles, self.rest = parents, roles, rest
        self.positions, self.typical = positions, typical
        self.out = np.array(rest, dtype=np.float64)
        self.doubtful = set()
        self.out[0] = self._hips()

    def place(self, j: int) -> None:
        """The T-pose rotation of one joint whose parent has its own."""
        part, _, side = self.roles[j].partition(".")
        candidate = self._on_parent(j, self.rest)
        goal, bone = direction(self.roles[j]), self._bone(j)
        if goal is None or bone is None:
            self.out[j] = self._without_bone(j, part, candidate)
            return
        if self.typical is not None and self._is_far(j, part, _angle(quat.rotate(candidate, bone), goal)):
            self.doubtful.add(j)
            candidate = self.typical[j] if part == "foot" else self._on_parent(j, self.typical)
        elif part == "foot":
            # the sole stays level where the legs are splayed
            candidate = quat.multiply(self.out[0], _relative(self.rest, 0, j))
        if part == "foot":
            candidate = _facing_forward(candidate, bone)
        elif part in ("upper_arm", "forearm", "thigh", "shin"):
            candidate = quat.multiply(quat.between(quat.rotate(candidate, bone), goal), candidate)
            if j in self.doubtful and part in _HINGES:
                candidate = self._hinged(j, candidate, goal, part, side)
        self.out[j] = candidate

    def _on_parent(self, j: int, pose: Array) -> Array:
        """Joint `j` turned against its parent as in `pose`, its parent in T-pose."""
        p = int(self.parents[j])
        return quat.multiply(self.out[p], _relative(pose, p, j))

    def _without_bone(self, j: int, part: str, candidate: Array) -> Array:
        """Head, hands, toes and joints without a role: the rest pose, unless the data belies it."""
        if self.typical is None:
            return candidate
        other = self._on_parent(j, self.typical)
        if part == "toe":
            # flat as the foot is
            return other if int(self.parents[j]) in self.doubtful else candidate
        return candidate if _turn(other, candidate) < NEAR else other

    def _is_far(self, j: int, part: str, angle: float) -> bool:
        """Whether a joint's rest pose tells nothing: its bone points elsewhere, or the trunk is never like that."""
        if angle > NEAR or self.typical is None:
            return angle > NEAR
        trunk = part in (*SPINE, "neck", "clavicle")
        return trunk and _turn(self._on_parent(j, self.typical), self._on_parent(j, self.rest)) > NEAR

    def _hips(self) -> Array:
        """Facing +Y with the thighs side by side; level as in the rest pose if that stands, else as in the data."""
        left, right = (self.positions[self.roles.index(f"thigh.{side}")] for side in SIDES)
        bone = self._bone(0)
        torso = UP if bone is None else quat.rotate(self.rest[0], bone)
        up = UP if _angle(torso, UP) < NEAR else torso
        inverse = quat.conjugate(self.rest[0])
        up_local = quat.rotate(inverse, up)
        if up is torso and self.typical is not None:
            self.doubtful.add(0)
            up_local = quat.rotate(quat.conjugate(self.typical[0]), UP)
        return _frame(quat.rotate(inverse, right - left), up_local)

    def _bone(self, j: int) -> Array | None:
        """From a joint to the next one, in the joint's own axes; None where nothing follows."""
        for role in next_roles(self.roles[j]):
            if role in self.roles:
                bone = self.positions[self.roles.index(role)] - self.positions[j]
                if np.linalg.norm(bone) > 1e-9:
                    return quat.rotate(quat.conjugate(self.rest[j]), bone)
        return None

    def _hinged(self, j: int, candidate: Array, axis: Array, part: str, side: str) -> Array:
        """Turned about its bone so that the elbow's or knee's typical bend goes where joints bend."""
        lower, goal = _HINGES[part]
        below = self.roles.index(f"{lower}.{side}")
        bone = self._bone(below)
        if bone is None or self.typical is None:
            return candidate
        bent = quat.rotate(quat.multiply(candidate, _relative(self.typical, j, below)), bone)
        bend = bent - axis * (bent @ axis)
        if np.linalg.norm(bend) < np.sin(_BEND) * np.linalg.norm(bone):
            return candidate
        return quat.multiply(quat.between(bend, goal), candidate)


def _relative(pose: Array, parent: int, joint: int) -> Array:
    return quat.multiply(quat.conjugate(pose[parent]), pose[joint])


def _angle(a: Array, b: Array) -> float:
    """Radians between two directions of any length."""
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))


def _turn(a: Array, b: Array) -> float:
    """Radians between two rotations."""
    return float(np.linalg.norm(quat.to_rotation_vector(quat.multiply(a, quat.conjugate(b)))))


def _frame(right: Array, up: Array) -> Array:
    """The rotation that brings `right`, made perpendicular, to +X and `up` to +Z."""
    z = up / np.linalg.norm(up)
    x = right - z * (right @ z)
    x = x / np.linalg.norm(x)
    return quat.from_matrix(np.stack([x, np.cross(z, x), z]))


def _facing_forward(rotation: Array, bone: Array) -> Array:
    """A foot turned about the vertical until it points along +Y."""
    points = quat.rotate(rotation, bone)
    return quat.multiply(quat.from_yaw(np.arctan2(points[0], points[1])), rotation)

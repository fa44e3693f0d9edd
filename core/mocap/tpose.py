"""The canonical T-pose of any humanoid skeleton: the rotation of every joint when the body stands in T-pose.

Where the skeleton's own zero or rest pose is near a T- or A-pose, that pose is taken and its limbs are
straightened. Where it is not (every bone along one axis, legs pointing up), the pose that the data shows most
is taken instead and straightened likewise, which keeps the limbs' natural twist: hanging arms are lifted.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body import hierarchy
from ..body.skeleton import ARM, LEG, SIDES, SPINE
from ..maths import quat

Array = NDArray[np.floating[Any]]

UP = np.array([0.0, 0.0, 1.0])
FORWARD = np.array([0.0, 1.0, 0.0])
RIGHT = np.array([1.0, 0.0, 0.0])

NEAR = float(np.radians(60.0))
"""A bone farther than this from where it points in T-pose is not in T- or A-pose."""
_BEND = np.radians(8.0)
"""A typical bend of elbow or knee below this does not tell the hinge's direction."""
_SNAP = np.radians(30.0)
"""Joint axes this near a right angle are taken to be at one."""
_CUBE = quat.from_matrix(
    np.array(
        [
            m
            for order in itertools.permutations(range(3))
            for signs in itertools.product((1.0, -1.0), repeat=3)
            if np.linalg.det(m := np.eye(3)[list(order)] * signs) > 0.0
        ]
    )
)
"""The 24 rotations of a cube."""
_HANGING = float(np.cos(np.radians(20.0)))
"""How straight down an arm points that hangs."""
_LEAN = np.radians(25.0)
"""A spine that slopes more than this in T-pose is not believed."""
_HINGES = {"upper_arm": "forearm", "thigh": "shin"}
"""Upper bones and the joints that bend at their end: elbows forward, knees backward."""
_STRAIGHT = ("upper_arm", "forearm", "thigh", "shin")
"""Bones that lie along an axis in T-pose; others keep their slope."""
_AGREES: dict[str, float] = {"shin": 0.4, "thigh": 0.4, **dict.fromkeys((*SPINE, "neck", "clavicle"), 0.7)}
"""Radians that the rest pose may differ from the typical one for joints of little freedom; `NEAR` for others."""


def lifted_arms(
    parents: NDArray[np.intp], roles: tuple[str, ...], rotations: Array, positions: Array
) -> tuple[Array, Array] | None:
    """A pose whose arms hang down with them lifted to the sides, palms down; None where they do not hang.

    Args:
        parents: `(J,)`.
        roles: `(J,)`.
        rotations: `(J, 4)` global rotations of an upright pose, Z up.
        positions: `(J, 3)`.
    """
    shoulders = [roles.index(f"upper_arm.{side}") for side in SIDES]
    across = (positions[shoulders[1]] - positions[shoulders[0]]) * (1.0, 1.0, 0.0)
    width = float(np.linalg.norm(across))
    forward = np.cross(UP, across / max(width, 1e-9))
    rotations, positions = rotations.copy(), positions.copy()
    for side, shoulder, sign in zip(SIDES, shoulders, (1.0, -1.0), strict=True):
        arm = positions[roles.index(f"hand.{side}")] - positions[shoulder]
        if width < 1e-6 or -arm[2] < _HANGING * float(np.linalg.norm(arm)):
            return None
        turn = quat.from_rotation_vector(forward * sign * np.pi / 2.0)
        moved = hierarchy.below(parents.tolist(), [shoulder])
        positions[moved] = positions[shoulder] + quat.rotate(turn, positions[moved] - positions[shoulder])
        rotations[moved] = quat.multiply(turn, rotations[moved])
    return rotations, positions


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
    body.straighten()
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


def looks_like_tpose(roles: tuple[str, ...], positions: Array, tolerance: float) -> bool:
    """Whether joint positions `(J, 3)`, Z up, show a body in T-pose, facing anywhere.

    Args:
        roles: `(J,)`.
        positions: of one frame, any unit.
        tolerance: radians that trunk, arms and legs may be off.
    """
    place = {role: positions[j] for j, role in enumerate(roles) if role}
    across = (place["thigh.R"] - place["thigh.L"]) * (1.0, 1.0, 0.0)
    bones = [(place["head"] - place["hips"], UP)]
    for side, lateral in zip(SIDES, (-across, across), strict=True):
        bones += [(place[f"hand.{side}"] - place[f"forearm.{side}"], lateral)]
        bones += [(place[f"forearm.{side}"] - place[f"upper_arm.{side}"], lateral)]
        bones += [(place[f"foot.{side}"] - place[f"shin.{side}"], -UP)]
        bones += [(place[f"shin.{side}"] - place[f"thigh.{side}"], -UP)]
    return all(_angle(bone, goal) < tolerance for bone, goal in bones)


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
    index: dict[str, int]
    seen: Array | None
    """`typical` where the rest pose is no T-pose and tells little; None where it is trusted."""

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
        self.index = {role: j for j, role in enumerate(roles) if role}
        self.seen = None if looks_like_tpose(roles, positions, NEAR) else typical
        self.out = np.array(rest, dtype=np.float64)
        self.out[0] = self._hips()

    def place(self, j: int) -> None:
        """The T-pose rotation of one joint whose parent has its own."""
        part, _, side = self.roles[j].partition(".")
        candidate = self._on_parent(j, self.rest)
        goal, bone = direction(self.roles[j]), self._bone(j)
        if goal is None or bone is None:
            self.out[j] = candidate if self.seen is None else self._unboned(j, part, candidate, self.seen)
            return
        if part == "foot":
            self.out[j] = _facing_forward(self._level(j, candidate), bone)
            return
        trusted = self.seen is None or self._agrees(j, part, candidate, bone, goal, self.seen)
        if not trusted and self.seen is not None:
            candidate = self._snapped(j, self.seen)
        if not trusted or part in _STRAIGHT:
            candidate = _swung(candidate, bone, goal)
        if part in _HINGES and self.seen is not None:
            candidate = self._hinged(j, candidate, goal, f"{_HINGES[part]}.{side}", self.seen)
        self.out[j] = candidate

    def straighten(self) -> None:
        """Put the neck of a spine that no rest pose shows upright over the hips, by one turn of all its joints.

        So takes of one skeleton agree, and a back that is bent in the data stays bent.
        """
        turning = [j for j, role in enumerate(self.roles) if role in (*SPINE, "neck")]
        if self.seen is None or not turning:
            return
        first, last = turning[0], turning[-1]
        root, trunk = self._between(0, first), self._between(first, last)
        height = max(float(np.hypot(trunk[1], trunk[2])), 1e-9)
        pitch = np.arctan2(trunk[1], trunk[2]) + np.arcsin(np.clip(root[1] / height, -0.5, 0.5))
        for j in turning:
            self.out[j] = quat.multiply(quat.from_axis("X", np.clip(pitch, -_LEAN, _LEAN)), self.out[j])

    def _between(self, ancestor: int, j: int) -> Array:
        """From a joint to one below it `(3,)` in T-pose."""
        way = np.zeros(3)
        for child in reversed(hierarchy.path(self.parents, ancestor, j)[1:]):
            p = int(self.parents[child])
            offset = quat.rotate(quat.conjugate(self.rest[p]), self.positions[child] - self.positions[p])
            way += quat.rotate(self.out[p], offset)
        return way

    def _on_parent(self, j: int, pose: Array) -> Array:
        """Joint `j` turned against its parent as in `pose`, its parent in T-pose."""
        p = int(self.parents[j])
        return quat.multiply(self.out[p], _relative(pose, p, j))

    def _agrees(self, j: int, part: str, candidate: Array, bone: Array, goal: Array, pose: Array) -> bool:
        """Whether the rest pose of one joint is nevertheless what the data shows, but for bends of limbs."""
        if _angle(quat.rotate(candidate, bone), goal) > NEAR:
            return False
        other = self._on_parent(j, pose)
        if part in _STRAIGHT:
            candidate, other = _swung(candidate, bone, goal), _swung(other, bone, goal)
        return _turn(candidate, other) < _AGREES.get(part, float(NEAR))

    def _snapped(self, j: int, pose: Array) -> Array:
        """As `_on_parent`, by the right angles that joint axes differ by: takes of one skeleton agree."""
        p = int(self.parents[j])
        rest = _relative(self.rest, p, j)
        turn = quat.multiply(quat.conjugate(rest), _relative(pose, p, j))
        near = _CUBE[np.argmax(np.abs(_CUBE @ turn))]
        return quat.multiply(self.out[p], quat.multiply(rest, near if _turn(near, turn) < _SNAP else turn))

    def _level(self, j: int, candidate: Array) -> Array:
        """A foot with its sole level: as planted in the data, carried by the shin, or as in the rest pose."""
        if self.seen is not None:
            return self.seen[j]
        flat = quat.multiply(self.out[0], _relative(self.rest, 0, j))
        if self.typical is None:
            return flat
        planted = self.typical[j]
        return candidate if _turn(candidate, planted) < _turn(flat, planted) else flat

    def _unboned(self, j: int, part: str, candidate: Array, pose: Array) -> Array:
        """Head, hands, toes and joints without a role: the rest pose, unless the data belies it."""
        other = self._on_parent(j, pose)
        if part == "toe":
            return other
        return candidate if _turn(other, candidate) < NEAR else self._snapped(j, pose)

    def _hips(self) -> Array:
        """Facing +Y, thighs side by side; level as in the rest pose if that stands, else as in the data."""
        inverse = quat.conjugate(self.rest[0])
        across = quat.rotate(inverse, self._place("thigh.R") - self._place("thigh.L"))
        if self.seen is not None:
            up = quat.rotate(quat.conjugate(self.seen[0]), UP)
            straight = self._straight_spine()
            if straight is not None and _angle(quat.rotate(inverse, straight), up) < _SNAP:
                up = quat.rotate(inverse, straight)
            return _frame(across, up)
        torso = self._place("head") - self.positions[0]
        return _frame(across, quat.rotate(inverse, UP if _angle(torso, UP) < NEAR else torso))

    def _straight_spine(self) -> Array | None:
        """Which way a spine that is straight in the rest pose points there; None for a bent one."""
        chain = [self.index[role] for role in (*SPINE, "neck", "head") if role in self.index]
        bones = np.diff(self.positions[chain], axis=0)
        whole = bones.sum(axis=0)
        return whole if len(bones) and all(_angle(bone, whole) < _SNAP for bone in bones) else None

    def _place(self, role: str) -> Array:
        return self.positions[self.index[role]]

    def _bone(self, j: int) -> Array | None:
        """From a joint to the next one, in the joint's own axes; None where nothing follows."""
        following = next((role for role in next_roles(self.roles[j]) if role in self.index), None)
        if following is None:
            return None
        bone = self._place(following) - self.positions[j]
        return quat.rotate(quat.conjugate(self.rest[j]), bone) if np.linalg.norm(bone) > 1e-9 else None

    def _hinged(self, j: int, candidate: Array, axis: Array, lower: str, pose: Array) -> Array:
        """Turned about its bone so that the elbow's or knee's typical bend goes where joints bend."""
        below = self.index[lower]
        bone = self._bone(below)
        if bone is None:
            return candidate
        bent = quat.rotate(quat.multiply(candidate, _relative(pose, j, below)), bone)
        bend = bent - axis * (bent @ axis)
        if np.linalg.norm(bend) < np.sin(_BEND) * np.linalg.norm(bone):
            return candidate
        goal = FORWARD if lower.startswith("forearm") else -FORWARD
        return quat.multiply(quat.between(bend, goal), candidate)


def _relative(pose: Array, parent: int, joint: int) -> Array:
    return quat.multiply(quat.conjugate(pose[parent]), pose[joint])


def _angle(a: Array, b: Array) -> float:
    """Radians between two directions of any length."""
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))


def _turn(a: Array, b: Array) -> float:
    """Radians between two rotations."""
    return float(np.linalg.norm(quat.to_rotation_vector(quat.multiply(a, quat.conjugate(b)))))


def _swung(rotation: Array, bone: Array, goal: Array) -> Array:
    """A joint's rotation, turned the shortest way so that its bone points to the goal."""
    return quat.multiply(quat.between(quat.rotate(rotation, bone), goal), rotation)


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

"""The joints of a take that matter, in metres and Z up, before the T-pose is known."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body import forward_kinematics as fk
from ..body import hierarchy
from ..body.skeleton import SIDES
from ..maths import quat
from .bvh import BvhFile, local_transforms

Array = NDArray[np.floating[Any]]

UNITS = {"m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001, "in": 0.0254, "CMU": 0.0254 / 0.45}
"""Length units of takes in metres; CMU's own is 5.64 cm."""
_STANDS = 0.75
"""Share of the line from feet to head along an axis from which on that axis surely is up."""
_BODY_LENGTH = 1.5
"""Metres along thigh, shin and from the hips to the head of an average adult."""


@dataclass(frozen=True, slots=True, eq=False)
class RawBody:
    """A take's humanoid joints, hips first, in the file's own joint axes."""

    names: tuple[str, ...]
    roles: tuple[str, ...]
    parents: NDArray[np.intp]
    offsets: Array
    """`(J, 3)` from the parent, in the parent's axes."""
    tips: Array
    """`(J, 3)` from a leaf joint to the end of its bone, in its own axes; zeros where unknown."""
    positions: Array
    """`(T, J, 3)` in the world."""
    rotations: Array
    """`(T, J, 4)` global rotations."""
    slide: Array
    """`(J,)` how far a joint's own position channels move it from its offset, at most."""

    def joint(self, role: str) -> int:
        """Index of a role's joint."""
        return self.roles.index(role)

    def turned(self, rotation: Array, scale: float) -> RawBody:
        """The same in other world axes and another unit."""
        return replace(
            self,
            offsets=self.offsets * scale,
            tips=self.tips * scale,
            positions=quat.rotate(rotation, self.positions) * scale,
            rotations=quat.multiply(rotation, self.rotations),
            slide=self.slide * scale,
        )

    def frames(self, start: int) -> RawBody:
        """The same from frame `start` on."""
        return replace(self, positions=self.positions[start:], rotations=self.rotations[start:])

    def pose(self, rotations: Array) -> Array:
        """Joint positions `(J, 3)`, the hips at the origin, with global rotations `(J, 4)`."""
        return fk.joint_positions(np.zeros((1, 3)), rotations[None], self.offsets, self.parents)[0]


def reduce_to_body(bvh: BvhFile, roles: tuple[str, ...]) -> RawBody:
    """The joints with roles and those between them; file units and axes.

    The hips take over all that moves above them. Other joints keep their median offset.
    """
    parents = bvh.parents.tolist()
    chosen = hierarchy.with_ancestors(parents, [joint for joint, role in enumerate(roles) if role])
    over = hierarchy.above(parents, roles.index("hips"))
    joints = [joint for joint in chosen if joint not in over]
    place = {joint: k for k, joint in enumerate(chosen)}
    local_p, local_r = local_transforms(bvh, np.array(chosen, dtype=np.intp))
    all_parents = hierarchy.part(parents, chosen)
    global_p, global_r = fk.forward(local_p[:, 0], local_r, local_p, all_parents)
    body = np.array([place[joint] for joint in joints], dtype=np.intp)
    offsets = np.median(local_p[:, body], axis=0)
    slide = np.linalg.norm(local_p[:, body] - offsets, axis=-1).max(axis=0)
    slide[0] = 0.0
    inner_parents = hierarchy.part(parents, joints)
    rotations = global_r[:, body]
    held = {parents[joint] for joint in joints}
    return RawBody(
        names=tuple(bvh.names[joint] for joint in joints),
        roles=tuple(roles[joint] for joint in joints),
        parents=inner_parents,
        offsets=offsets,
        tips=np.array([_tip(bvh, joint, roles[joint], leaf=joint not in held) for joint in joints]),
        positions=fk.joint_positions(global_p[:, body[0]], rotations, offsets, inner_parents),
        rotations=rotations,
        slide=slide,
    )


def some_poses(bvh: BvhFile, count: int) -> Array:
    """Positions `(F, J, 3)` of all joints in `count` frames at most, spread over the take; the file's axes and unit."""
    rows = np.unique(np.linspace(0, len(bvh) - 1, count).astype(np.intp))
    part = replace(bvh, values=bvh.values[rows])
    local_p, local_r = local_transforms(part, np.arange(len(bvh.names)))
    return fk.forward(local_p[:, 0], local_r, local_p, bvh.parents)[0]


def with_toes(body: RawBody) -> tuple[RawBody, list[str]]:
    """The body with toes made at the end of the feet where the file has none; which feet got one."""
    made: list[str] = []
    for side in SIDES:
        foot = body.joint(f"foot.{side}")
        if f"toe.{side}" in body.roles or not body.tips[foot].any():
            continue
        name = body.names[foot]
        made.append(name)
        renamed = name.replace("Foot", "Toe").replace("foot", "toe").replace("Ankle", "Toe")
        at, tip = foot + 1, body.tips[foot]
        end = body.positions[:, foot] + quat.rotate(body.rotations[:, foot], tip)
        tips = np.insert(body.tips, at, 0.0, axis=0)
        tips[foot] = 0.0
        toe = renamed if renamed not in body.names else f"{name} toe"
        body = RawBody(
            names=(*body.names[:at], toe, *body.names[at:]),
            roles=(*body.roles[:at], f"toe.{side}", *body.roles[at:]),
            parents=np.insert(body.parents + (body.parents > foot), at, foot),
            offsets=np.insert(body.offsets, at, tip, axis=0),
            tips=tips,
            positions=np.insert(body.positions, at, end, axis=1),
            rotations=np.insert(body.rotations, at, body.rotations[:, foot], axis=1),
            slide=np.insert(body.slide, at, 0.0),
        )
    return body, made


def find_unit(body: RawBody) -> tuple[str, float]:
    """The unit that makes the body nearest in size to an adult's, and the body's length in metres with it.

    The length runs along one thigh and shin and from the hips to the head.
    """
    length = 0.0
    for side in SIDES:
        length += 0.5 * _length(body, body.joint(f"thigh.{side}"), body.joint(f"foot.{side}"))
    length += _length(body, 0, body.joint("head"))

    def unlikely(unit: str) -> float:
        ratio = float(np.log(max(length, 1e-9) * UNITS[unit] / _BODY_LENGTH))
        return 2.0 * ratio if ratio > 0.0 else -ratio  # there are children, but no giants

    name = min(UNITS, key=unlikely)
    return name, length * UNITS[name]


def find_up(body: RawBody) -> tuple[str, float]:
    """Whether Y or Z points up in the file, and the share of the line from feet to head that lies along it.

    A body that stands for most of the time tells it by that line. Of one that lies or crawls the floor does: whatever
    it does, its lowest joint is near the floor and the floor stays where it is.
    """
    feet = 0.5 * (body.positions[:, body.joint("foot.L")] + body.positions[:, body.joint("foot.R")])
    line = body.positions[:, body.joint("head")] - feet
    share = np.mean(line / np.maximum(np.linalg.norm(line, axis=-1, keepdims=True), 1e-9), axis=0)
    standing = max(share[1], share[2])
    if standing >= _STANDS:
        return ("Y" if share[1] >= share[2] else "Z"), float(standing)
    size = float(np.linalg.norm(line, axis=-1).max())
    unlikely = [_off_floor(body.positions[..., axis], size) - share[axis] for axis in (1, 2)]
    axis = "YZ"[int(np.argmin(unlikely))]
    return axis, float(share["XYZ".index(axis)])


def _off_floor(heights: Array, size: float) -> float:
    """How far `heights` `(T, J)` are from those over a floor at 0, in shares of the body's size.

    The lowest joint stays within a narrow band, and that is where the file has its floor.
    """
    lowest = heights.min(axis=1)
    low, middle, high = np.percentile(lowest, (5.0, 50.0, 95.0))
    return float((high - low + 0.5 * abs(middle)) / max(size, 1e-9))


def _length(body: RawBody, first: int, last: int) -> float:
    """Of the bones from joint `first` down to `last`, in the body's unit."""
    joints = hierarchy.path(body.parents, first, last)
    return float(np.linalg.norm(body.offsets[joints[1:]], axis=-1).sum())


def _tip(bvh: BvhFile, joint: int, role: str, *, leaf: bool) -> Array:
    """The end of a leaf's bone: its end site, or for hands, feet and toes the mean of the joints on it."""
    part = role.partition(".")[0]
    if not leaf:
        return np.zeros(3)
    ends = bvh.end_sites[bvh.end_parents == joint]
    if part in ("hand", "foot", "toe") and not ends.any():
        ends = bvh.offsets[bvh.parents == joint]
    return ends.mean(axis=0) if len(ends) else np.zeros(3)

"""The shape of a tree of joints: lengths, branches, and pairs of branches that mirror each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...body import hierarchy

Array = NDArray[np.floating[Any]]

_ALIKE = 0.15
"""Branches whose lengths differ by less than this share may be a body's left and right."""
_MOST_PAIRS = 12
"""Pairs of branches looked at, the longest first."""


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """Joints, how they hang together, and where they are in some poses."""

    parents: tuple[int, ...]
    poses: Array
    """`(F, J, 3)` positions in any axes and unit."""
    children: tuple[tuple[int, ...], ...]
    order: tuple[int, ...]
    """Joints with parents before children."""
    lengths: Array
    """`(J,)` median distance from the parent; 0 for roots."""
    reach: Array
    """`(J,)` length of the longest way down from a joint."""

    def distance(self, a: int, b: int) -> float:
        """Median distance between two joints."""
        return float(np.median(np.linalg.norm(self.poses[:, a] - self.poses[:, b], axis=-1)))

    def branch(self, joint: int) -> float:
        """Length of the longest way from a joint's parent over it to a leaf."""
        return float(self.lengths[joint] + self.reach[joint])

    def chain(self, joint: int) -> list[int]:
        """From a joint down the longest way to a leaf."""
        out = [joint]
        while self.children[out[-1]]:
            out.append(max(self.children[out[-1]], key=self.branch))
        return out

    def below(self, joint: int) -> list[int]:
        """A joint and all below it."""
        out = [joint]
        for at in out:
            out.extend(self.children[at])
        return out

    def above(self, joint: int) -> list[int]:
        """The joints above one, nearest first."""
        return hierarchy.above(self.parents, joint)

    def is_above(self, upper: int, lower: int) -> bool:
        """Whether a joint is above another one, or the same."""
        return upper == lower or upper in self.above(lower)


def make_shape(parents: Sequence[int], poses: Array) -> Shape:
    """The shape of a tree; parents `(J,)` may follow their children."""
    parents = tuple(int(parent) for parent in parents)
    children: list[list[int]] = [[] for _ in parents]
    for joint, parent in enumerate(parents):
        if parent >= 0:
            children[parent].append(joint)
    order = [joint for joint, parent in enumerate(parents) if parent < 0]
    for joint in order:
        order.extend(children[joint])
    lengths = np.zeros(len(parents))
    inner = [joint for joint in order if parents[joint] >= 0]
    if inner:
        way = poses[:, inner] - poses[:, [parents[joint] for joint in inner]]
        lengths[inner] = np.median(np.linalg.norm(way, axis=-1), axis=0)
    reach = np.zeros(len(parents))
    for joint in reversed(order):
        if parents[joint] >= 0:
            reach[parents[joint]] = max(reach[parents[joint]], lengths[joint] + reach[joint])
    return Shape(parents, poses, tuple(map(tuple, children)), tuple(order), lengths, reach)


def mirrored_pairs(shape: Shape) -> list[tuple[int, int]]:
    """Pairs of branches from one joint that are as long as each other and long enough for limbs, longest first."""
    # a root with one child may be anywhere
    size = max((float(shape.reach[j]) for j, kids in enumerate(shape.children) if len(kids) > 1), default=0.0)
    pairs: list[tuple[float, int, int]] = []
    for kids in shape.children:
        # a helper that stands between, such as a joint for each side of the pelvis, is stepped over
        limbs = [k for k in kids if shape.branch(k) > 0.2 * size and _bones(shape, k) >= 2]
        limbs = sorted(limbs, key=shape.branch, reverse=True)[:8]
        for at, a in enumerate(limbs):
            for b in limbs[at + 1 :]:
                if _alike(shape, a, b):
                    pairs.append((shape.branch(a) + shape.branch(b), a, b))
    pairs.sort(key=lambda pair: (-pair[0], pair[1], pair[2]))
    return [(a, b) for _, a, b in pairs[:_MOST_PAIRS]]


def _bones(shape: Shape, joint: int) -> int:
    """Bones with a length down the longest way from a joint."""
    chain = shape.chain(joint)
    return int((shape.lengths[chain[1:]] > 0.02 * shape.branch(joint)).sum())


def _alike(shape: Shape, a: int, b: int) -> bool:
    """Whether two branches have the same lengths, joint by joint."""
    first, second = shape.chain(a), shape.chain(b)
    longest = max(shape.branch(a), shape.branch(b))
    if abs(len(first) - len(second)) > 1 or abs(shape.branch(a) - shape.branch(b)) > _ALIKE * longest:
        return False
    count = min(len(first), len(second))
    apart = np.abs(shape.lengths[first[:count]] - shape.lengths[second[:count]])
    return (
        bool((apart <= _ALIKE * longest).all())
        and shape.distance(a, b) + shape.distance(first[-1], second[-1]) > 0.02 * longest
    )

"""Ways up and down a hierarchy of joints or bones, given as the index of each one's parent; -1 for none."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Parents = Sequence[int] | NDArray[np.integer[Any]]


def above(parents: Parents, joint: int) -> list[int]:
    """The joints above one, nearest first."""
    out: list[int] = []
    at = int(parents[joint])
    while at >= 0:
        out.append(at)
        at = int(parents[at])
    return out


def with_ancestors(parents: Parents, joints: Iterable[int]) -> list[int]:
    """Joints and all joints above them, in ascending order."""
    found: set[int] = set()
    for joint in joints:
        found.update((joint, *above(parents, joint)))
    return sorted(found)


def path(parents: Parents, first: int, last: int) -> list[int]:
    """Joints from `first` down to its descendant `last`, both included.

    Raises:
        ValueError: `last` is not below `first`.
    """
    chain = [last, *above(parents, last)]
    return chain[chain.index(first) :: -1]


def nearest_above(parents: Parents, joint: int, wanted: Collection[int]) -> int:
    """The nearest joint above that is among `wanted`, or -1."""
    return next((other for other in above(parents, joint) if other in wanted), -1)


def below(parents: Parents, roots: Iterable[int]) -> list[int]:
    """The joints of `roots` and all joints below them, in ascending order; parents come before children."""
    found = set(roots)
    for joint, parent in enumerate(parents):
        if parent in found:
            found.add(joint)
    return sorted(found)


def part(parents: Parents, joints: Sequence[int]) -> NDArray[np.intp]:
    """The parents `(K,)` within a part of the hierarchy: indices into `joints`, -1 where the parent is outside."""
    place = {joint: k for k, joint in enumerate(joints)}
    return np.array([place.get(int(parents[joint]), -1) for joint in joints], dtype=np.intp)

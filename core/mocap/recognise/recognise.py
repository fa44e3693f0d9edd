"""Humanoid roles of any skeleton, by words in names and by structure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...body.skeleton import SIDES
from ...errors import InputError
from .shape import make_shape
from .structure import find_roles, front_by_shape
from .words import NameSays, read_names

Array = NDArray[np.floating[Any]]

_SURE = 4.0
"""Squared deviations over which a body is doubted."""
_MIRRORED = -0.4
NAME = "names and structure"


def roles_by_structure(
    names: Sequence[str], parents: Sequence[int] | NDArray[np.intp], poses: Array
) -> tuple[dict[str, int], tuple[str, ...]]:
    """Role -> joint without inner joints of the spine, and a line for each doubt.

    Args:
        names: `(J,)`.
        parents: `(J,)`, -1 for none.
        poses: `(F, J, 3)` positions in some poses, in any axes and unit; the more they differ, the more they tell.

    Raises:
        InputError: no two pairs of limbs with a trunk between and a head, as people have them.
    """
    shape = make_shape([int(parent) for parent in parents], np.asarray(poses, dtype=np.float64))
    says = read_names(names)
    roles, cost = find_roles(shape, says)
    if not roles:
        raise InputError("no arms, legs, trunk and head as a person has them hang together in it")
    doubts = [f"{NAME} told what joints are: look at them"]
    if cost > _SURE:
        doubts = [f"{NAME} told what joints are, not surely: look at them"]
    if front_by_shape(shape, roles, SIDES) < _MIRRORED and _sides_are_named(roles, says):
        doubts.append("left and right are named the other way round than feet, knees and elbows tell")
    return roles, tuple(doubts)


def _sides_are_named(roles: dict[str, int], says: Sequence[NameSays]) -> bool:
    return any(says[joint].side for role, joint in roles.items() if "." in role)

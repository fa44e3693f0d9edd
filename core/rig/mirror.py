"""Armature objects that a negative scale shows as their mirror image.

With S = diag(-1, 1, 1), an object whose matrix W has a negative determinant shows a pose P as W P = (W S)(S P S) S:
the armature of rest S R S on an object with W S is an ordinary one and looks the same; a basis B there is S B S here.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .rig import Rig

Array = NDArray[np.floating[Any]]

MIRROR = np.diag([-1.0, 1.0, 1.0, 1.0])
LOCATION, ROTATION = np.array([-1.0, 1.0, 1.0]), np.array([1.0, 1.0, -1.0, -1.0])
"""A location and a quaternion of a mirrored bone, by multiplication."""

_OTHER = {"L": "R", "R": "L"}


def unmirrored(rig: Rig) -> Rig:
    """The ordinary rig that looks the same; the bones on its left are those that are seen there."""
    if not np.linalg.det(rig.world[:3, :3]) < 0.0:
        return rig
    roles = (role.rpartition(".") for role in rig.roles)
    return replace(
        rig,
        rest=MIRROR @ rig.rest @ MIRROR,
        tails=rig.tails * LOCATION,
        world=rig.world @ MIRROR,
        roles=tuple(f"{part}.{_OTHER[side]}" if part else side for part, _, side in roles),
        mirrored=True,
    )

"""The last look at what is to be keyed: nothing that is no movement of a body in metres leaves."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..bounds import FARTHEST
from ..errors import InputError
from .rig import BoneTracks, Rig

Array = NDArray[np.floating[Any]]

_UNIT = 1e-3
"""How far the length of a quaternion may be from 1."""


def check_finite(values: Array, whose: str) -> None:
    """Raise InputError where values `(T, ...)` are not finite or farther than anything is; `whose` is told."""
    # comparisons with NaN are false
    fine = np.asarray(np.abs(values.reshape(len(values), -1)) <= FARTHEST).all(axis=-1)
    if not fine.all():
        raise InputError(
            f"{whose} gives values at frame {int(np.argmin(fine))} that no body has; use another one or make it again"
        )


def check_rig(rig: Rig) -> None:
    """Raise InputError for a rig whose place or bones are nowhere."""
    advice = "clear its transform, constraints and drivers"
    if not (np.abs(rig.world) <= FARTHEST).all():
        raise InputError(f"{rig.name}: the object is at no place, or more than {FARTHEST:g} m away; {advice}")
    fine = np.isfinite(rig.rest).all(axis=(1, 2)) & np.isfinite(rig.tails).all(axis=1)
    if not fine.all():
        raise InputError(
            f"{rig.name}: the bone {rig.bones[int(np.argmin(fine))]} has no place at rest; repair it"
        )


def check_tracks(tracks: BoneTracks, rig: Rig) -> None:
    """Raise InputError, with bone and second, for keys that are not finite, no rotations, or too far away."""
    scale = float(np.cbrt(np.abs(np.linalg.det(rig.world[:3, :3]))))
    placed = (np.abs(tracks.locations) * scale <= FARTHEST).all(axis=-1)
    turned = np.abs(np.linalg.norm(tracks.rotations, axis=-1) - 1.0) <= _UNIT
    turned[:, 0] &= placed
    for bone, places in zip(tracks.placed, np.moveaxis(tracks.places, 1, 0), strict=True):
        turned[:, tracks.bones.index(bone)] &= (np.abs(places) * scale <= FARTHEST).all(axis=-1)
    if not turned.all():
        frame, bone = np.unravel_index(int(np.argmin(turned)), turned.shape)
        raise InputError(
            f"{rig.name}: the bone {tracks.bones[bone]} would get keys at {frame / tracks.fps:.2f} s that are no "
            "movement; check the recording, the databases and the rig"
        )

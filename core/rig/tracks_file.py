"""Bone tracks as a `.npz`: a bake for programs, without Blender (described in docs/batch.md)."""

from __future__ import annotations

from typing import BinaryIO

import numpy as np

from .. import VERSION
from ..npz import write_npz
from .rig import BoneTracks, Rig

FORMAT = "footwork-tracks"
SCHEMA = 1


def write_tracks(file: BinaryIO, rig: Rig, tracks: BoneTracks) -> None:
    """Write what is keyed on a rig, and the rig's rest pose, which gives the keys their meaning.

    The same tracks give the same bytes. Numbers are float32, rounded from float64.

    Args:
        file: open for writing.
        rig: that the tracks are for.
        tracks: `(T,)` frames of `(K,)` bones.
    """
    arrays = {
        "format": np.array(FORMAT),
        "schema": np.array(SCHEMA),
        "producer": np.array(f"footwork {VERSION}"),
        "fps": np.array(tracks.fps, np.float64),
        "bones": np.array(tracks.bones),
        "locations": tracks.locations.astype(np.float32),
        "rotations": tracks.rotations.astype(np.float32),
        "placed": np.array(tracks.placed, dtype=str),
        "places": tracks.places.astype(np.float32),
        "rig_name": np.array(rig.name),
        "rig_bones": np.array(rig.bones),
        "rig_parents": rig.parents.astype(np.int32),
        "rig_rest": rig.rest.astype(np.float64),
        "rig_world": rig.world.astype(np.float64),
        "rig_roles": np.array(rig.roles),
    }
    write_npz(file, arrays, compressed=True)

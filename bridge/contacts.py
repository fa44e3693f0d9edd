"""A take's foot contacts as two keyed properties of its armature, to be seen and edited like any animation."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.body.skeleton import SIDES
from ..core.errors import InputError
from . import compat
from .action import fill_curve

TAKE = "footwork_take"
"""Custom property of an armature that shows a take: its `file`, `fps` and `frame_start`."""
_FEET = {"L": "left", "R": "right"}


def property_of(side: str) -> str:
    """Name of the custom property that holds a foot's contacts."""
    return f"contact_{side}"


def key_contacts(
    obj: bpy.types.Object, contacts: NDArray[np.bool_], *, file: str, fps: float, frame_start: float
) -> None:
    """Key a take's contacts on the armature object that shows it, a key wherever they change.

    Args:
        obj: an object with an action of its own.
        contacts: `(T, 2)` left, right foot on the ground, a frame of the scene each.
        file: the take's file, as a list of takes keeps it.
        fps: the scene's true frame rate.
        frame_start: frame of the first key.
    """
    action = obj.animation_data.action
    assert action is not None
    for column, side in enumerate(SIDES):
        states, name = contacts[:, column], property_of(side)
        # booleans are held between keys in whatever way those were made
        obj[name] = bool(states[0])
        shown: Any = obj.id_properties_ui(name)
        shown.update(
            description=f"The {_FEET[side]} foot is on the ground; edit the keys, then press Use Edited Contacts"
        )
        path = f'["{name}"]'
        curve = compat.ensure_fcurve(action, obj, path, 0, "Contacts")
        frames = np.flatnonzero(np.diff(states, prepend=~states[:1]))
        fill_curve(curve, frame_start + frames, states[frames], compat.CONSTANT)
        curve.update_autoflags(obj)
    obj[TAKE] = {"file": file, "fps": fps, "frame_start": frame_start}


def shown_take(obj: bpy.types.Object | None) -> str:
    """The file of the take that an armature with contacts shows; "" for any other object."""
    shown = None if obj is None else obj.get(TAKE)
    return "" if shown is None else shown["file"]


def shown_rate(obj: bpy.types.Object) -> float:
    """Frames per second at which the armature shows its take: the scene's when it was made."""
    return float(obj[TAKE]["fps"])


def read_contacts(obj: bpy.types.Object, count: int) -> NDArray[np.bool_]:
    """The contacts `(T, 2)` that an armature shows in its take's first `count` frames.

    Raises:
        InputError: one of the properties is not keyed any more.
    """
    curves = {curve.data_path: curve for curve in compat.fcurves_of(obj)}
    contacts = np.empty((count, len(SIDES)), dtype=np.bool_)
    for column, side in enumerate(SIDES):
        curve = curves.get(f'["{property_of(side)}"]')
        if curve is None or curve.is_empty:
            raise InputError(
                f"{obj.name}: its {property_of(side)} has no keys; show the take in the scene again"
            )
        start = obj[TAKE]["frame_start"]
        contacts[:, column] = [curve.evaluate(start + frame) > 0.5 for frame in range(count)]
    return contacts

"""How a recording's file is to be read, where it does not say so itself."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty

from ..core.bounds import RECORDING_RATE
from ..core.recording.reading.answers import ROTATIONS
from ..core.recording.reading.scores import COMMON, EVERY, UNITS
from .units import unit_property

_AXES = [
    ("AUTO", "Automatic", "The choice that shows how a person moves"),
    *((axes, f"{name} ({axes})", f"x, y and z point {axes}") for axes, name in COMMON.items()),
    *((axes, axes, f"x, y and z point {axes}") for axes in EVERY if axes not in COMMON),
]


def _forget(self, context: bpy.types.Context) -> None:
    footwork = self.id_data.footwork
    footwork.recording_state = "NEW"
    footwork.recording_found = footwork.recording_doubts = ""


class FOOTWORK_PG_reading(bpy.types.PropertyGroup):
    """How a recording's file is to be read"""

    axes: EnumProperty(
        name="Axes",
        description="Where the file's x, y and z point: right or left, up or down, forward or back",
        items=_AXES,
        update=_forget,
    )
    unit: unit_property(UNITS, _forget)
    rotation: EnumProperty(
        name="Rotation",
        description="How the file writes rotations",
        items=[
            ("AUTO", "Automatic", "The choice that shows how a person moves"),
            *((name, name, f"Rotations are {name}") for name in ROTATIONS),
        ],
        update=_forget,
    )
    rate: FloatProperty(
        name="Rate",
        description="Samples per second of a file without times; 0 where it has them",
        min=0.0,
        max=RECORDING_RATE[1],
        update=_forget,
    )
    swap_hands: BoolProperty(
        name="Swap Hands", description="Left and right controller change places", update=_forget
    )
    auto_trim: BoolProperty(
        name="Trim the End",
        description="Leave out what follows when the headset is laid down for good",
        update=_forget,
    )
    force: BoolProperty(
        name="Read Anyway", description="Go on with a recording that can be no person's", update=_forget
    )


CLASSES = (FOOTWORK_PG_reading,)

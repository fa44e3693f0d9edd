"""How a recording's file is to be read, where it does not say so itself."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty

from ..core.bounds import RECORDING_RATE
from ..core.recording.mounts import FITTED, SHAPES
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
    mounts: EnumProperty(
        name="Mounts",
        description="How headset and controllers sit on head and hands",
        items=[
            ("AUTO", "Automatic", "As the file says, else typical of real devices"),
            *((name, shape.title, shape.numbers) for name, shape in SHAPES.items()),
            (FITTED, "Fitted", "As the movement tells, where it does"),
            ("CUSTOM", "Custom", "By the numbers below"),
        ],
        update=_forget,
    )
    headset_ahead: FloatProperty(
        name="Headset Ahead",
        description="From the head joint forward to the headset, metres",
        default=0.08,
        min=-0.1,
        max=0.3,
        precision=3,
        update=_forget,
    )
    headset_above: FloatProperty(
        name="Headset Above",
        description="From the head joint up to the headset, metres",
        default=0.09,
        min=-0.1,
        max=0.3,
        precision=3,
        update=_forget,
    )
    controller_reach: FloatProperty(
        name="From Wrist",
        description="From the wrist along the fingers to the controllers, metres",
        default=0.1,
        min=-0.1,
        max=0.3,
        precision=3,
        update=_forget,
    )
    controller_pitch: FloatProperty(
        name="Controller Pitch",
        description="By which controllers point above the fingers, degrees",
        default=15.0,
        min=-90.0,
        max=90.0,
        update=_forget,
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

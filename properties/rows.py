"""Rows of the lists in a scene: takes, databases, figures of the last bake."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, StringProperty

from ..core.bounds import TAKE_RATE
from ..core.mocap.answers import STATED_UNITS
from .file_path import file_path
from .units import unit_property

STATES = [
    ("NEW", "Not read", "Not read yet", "QUESTION", 0),
    ("OK", "Good", "Read, nothing doubtful", "CHECKMARK", 1),
    ("DOUBT", "Doubtful", "Read, but something should be looked at", "ERROR", 2),
    ("FAULT", "Unusable", "Cannot be used", "CANCEL", 3),
]


class Row:
    """A file in a list, and what was found in it."""

    path: file_path("File", "The file")
    use: BoolProperty(name="Use", description="Take part in the next step", default=True)
    state: EnumProperty(name="State", description="What reading it gave", items=STATES)
    seconds: FloatProperty(name="Length", description="Length in seconds", unit="TIME_ABSOLUTE")
    found: StringProperty(name="Found", description="What was found in the file, a line each")
    doubts: StringProperty(name="Doubts", description="What should be looked at, a line each")


def _forget(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    """What was found belongs to the way in which the file was read."""
    setattr(self, "state", "NEW")  # noqa: B010


class FOOTWORK_PG_take(Row, bpy.types.PropertyGroup):
    """A take in the list."""

    unit: unit_property(STATED_UNITS, _forget)
    up: EnumProperty(
        name="Up",
        description="The file's axis that points up",
        items=[
            ("AUTO", "Automatic", "The axis along which head and feet lie"),
            *((axis, axis, f"{axis} points up") for axis in "XYZ"),
        ],
        update=_forget,
    )
    rate: FloatProperty(
        name="Rate",
        description="Frames per second of the file; 0 takes the rate that the file states",
        min=0.0,
        max=TAKE_RATE[1],
        update=_forget,
    )
    leave_out: StringProperty(
        name="Leave Out",
        description='Seconds that stay out of the database, such as "0-1.5, 30-32"; "90-" is up to the end',
    )
    contacts: StringProperty(
        name="Contacts",
        description="Seconds in which a foot is planted or lifted, whatever is detected, such as "
        '"L:planted:1.2-1.65, R:lifted:3-3.4"',
    )


class FOOTWORK_PG_database(Row, bpy.types.PropertyGroup):
    """A motion database in the list."""

    height_low: FloatProperty(
        name="From",
        description="Used from this headset height on, as a share of the standing eye height",
        min=0.0,
        max=2.0,
        default=0.0,
        step=1,
    )
    height_high: FloatProperty(
        name="To",
        description="Used below this headset height, as a share of the standing eye height",
        min=0.0,
        max=2.0,
        default=2.0,
        step=1,
    )


class FOOTWORK_PG_figure(bpy.types.PropertyGroup):
    """One line of the Quality panel."""

    value: StringProperty(name="Value", description="Mean, with its unit")
    detail: StringProperty(name="Detail", description="Spread of the value")
    text: StringProperty(name="Meaning", description="What the figure says")
    good: EnumProperty(
        name="Rating",
        description="Whether the figure is as it should be",
        items=[
            ("NONE", "None", "Not rated"),
            ("GOOD", "Good", "As it should be"),
            ("POOR", "Poor", "Look at it"),
        ],
    )


CLASSES = (FOOTWORK_PG_take, FOOTWORK_PG_database, FOOTWORK_PG_figure)

"""What the add-on's preferences hold: what belongs to a computer and not to a scene."""

import bpy
from bpy.props import StringProperty

from .version import Versioned

ADD_ON = __package__.rpartition(".")[0]
"""Name under which Blender knows the extension."""


class Preferences(Versioned):
    """The properties of the add-on's preferences; the panel that shows them is their class."""

    training_python: StringProperty(
        name="Python for Training",
        description="A Python with PyTorch to train predictors with; empty for Blender's own. "
        "Nothing else needs it",
        subtype="FILE_PATH",
    )


def preferences_of(context: bpy.types.Context) -> Preferences | None:
    """The stored preferences; None where Footwork runs without being enabled as an extension."""
    add_on = context.preferences.addons.get(ADD_ON)
    return None if add_on is None else add_on.preferences

"""The page of the add-on's preferences."""

import bpy

from ..operators import training
from ..properties.preferences import ADD_ON, Preferences
from . import text


class FOOTWORK_preferences(Preferences, bpy.types.AddonPreferences):
    """What belongs to a computer and not to a scene"""

    bl_idname = ADD_ON

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.use_property_split = True
        self.layout.prop(self, "training_python", placeholder="Blender's own")
        missing = training.find_trainer(context).missing
        if missing:
            text.notes(context, self.layout, missing, "INFO")
        else:
            self.layout.label(text="Training is possible", icon="CHECKMARK")


CLASSES = (FOOTWORK_preferences,)

"""The add-on's preferences: what belongs to a computer and not to a scene."""

import bpy
from bpy.props import StringProperty

from ..operators import training
from . import text


class FOOTWORK_preferences(bpy.types.AddonPreferences):
    """What belongs to a computer and not to a scene"""

    bl_idname = training.ADD_ON

    training_python: StringProperty(
        name="Python for Training",
        description="A Python with PyTorch to train predictors with; empty for Blender's own. "
        "Nothing else needs it",
        subtype="FILE_PATH",
    )

    def draw(self, context):
        self.layout.use_property_split = True
        self.layout.prop(self, "training_python", placeholder="Blender's own")
        missing = training.find_trainer(context).missing
        if missing:
            text.notes(context, self.layout, missing, "INFO")
        else:
            self.layout.label(text="Training is possible", icon="CHECKMARK")


CLASSES = (FOOTWORK_preferences,)

"""The Footwork tab of the 3D viewport's sidebar: one module for each step, in the order of work."""

import bpy

from . import (
    bake,
    databases,
    lists,
    overlays,
    predictor,
    preferences,
    quality,
    recording,
    rig,
    start,
    takes,
)

STEPS = (start, takes, databases, predictor, recording, rig, bake, quality)
CLASSES = (*preferences.CLASSES, *lists.CLASSES, *(cls for step in STEPS for cls in step.CLASSES))


def register() -> None:
    """Add lists and panels to Blender."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    overlays.register()


def unregister() -> None:
    """Take them away again."""
    overlays.unregister()
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)

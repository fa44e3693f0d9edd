"""Properties, panels and lists of the user interface."""

import bpy

from . import lists, properties, sidebar

CLASSES = (*lists.CLASSES, *sidebar.CLASSES)


def register() -> None:
    """Add properties, lists and panels to Blender."""
    properties.register()
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    """Take them away again."""
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
    properties.unregister()

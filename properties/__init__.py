"""What scenes, objects and preferences remember of Footwork."""

import bpy
from bpy.props import PointerProperty

from . import reading, role_map, rows, scene, settings_groups, upgrade

CLASSES = (*settings_groups.CLASSES, *rows.CLASSES, *reading.CLASSES, *scene.CLASSES, *role_map.CLASSES)


def register() -> None:
    """Add the properties to scenes and objects."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    setattr(bpy.types.Scene, scene.NAME, PointerProperty(type=scene.FOOTWORK_PG_scene))
    setattr(bpy.types.Object, role_map.NAME, PointerProperty(type=role_map.FOOTWORK_PG_role_map))
    upgrade.register()


def unregister() -> None:
    """Take them away again; what was saved in files stays there."""
    upgrade.unregister()
    delattr(bpy.types.Object, role_map.NAME)
    delattr(bpy.types.Scene, scene.NAME)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)

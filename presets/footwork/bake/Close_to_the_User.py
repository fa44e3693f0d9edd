"""The avatar stays within ten centimetres of the user."""

import bpy

settings = bpy.context.scene.footwork.bake

for name in settings.__annotations__:
    settings.property_unset(name)
settings.alpha = 0.1

"""Everything as it comes."""

import bpy

settings = bpy.context.scene.footwork.bake

for name in settings.__annotations__:
    settings.property_unset(name)

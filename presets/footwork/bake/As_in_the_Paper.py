"""Causal trajectory with springs, as in the paper's results."""

import bpy

settings = bpy.context.scene.footwork.bake

for name in settings.__annotations__:
    settings.property_unset(name)
settings.trajectory = "causal"
settings.smoothing = "spring"
settings.alpha = 0.3

"""The bake settings of this name in Footwork's `core/settings.py`."""

import bpy

bpy.ops.footwork.use_bake_preset(name="Default")

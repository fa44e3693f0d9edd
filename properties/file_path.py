"""Properties that hold the path of a file."""

from typing import Any

import bpy
from bpy.props import StringProperty

OPTIONS: Any = {"ANIMATABLE"}
if bpy.app.version >= (4, 5, 0):
    # Blender wants to be told that "//" paths are understood
    OPTIONS.add("PATH_SUPPORTS_BLEND_RELATIVE")


def file_path(label: str, text: str, **options: Any):
    """A property for a file that may be relative to the .blend."""
    return StringProperty(name=label, description=text, subtype="FILE_PATH", options=OPTIONS, **options)

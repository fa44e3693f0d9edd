"""What a scene without anything of Footwork begins with."""

import bpy

from ..properties.scene import footwork_of
from . import text
from .parts import Part, job_button


class FOOTWORK_PT_start(Part, bpy.types.Panel):
    """A first bake with nothing at hand"""

    bl_idname = "FOOTWORK_PT_start"
    bl_label = "Start"
    bl_options = {"HIDE_HEADER"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Shown until something is chosen."""
        footwork = footwork_of(context.scene)
        return not (footwork.takes or footwork.databases or footwork.recording_path or footwork.head)

    def draw(self, context: bpy.types.Context) -> None:
        job_button(self.layout, "footwork.try_it", "PLAY", 1.6)
        told = "An example recording on a mannequin. With a recording of your own, begin at step 4"
        text.notes(context, self.layout, told, "INFO")


CLASSES = (FOOTWORK_PT_start,)

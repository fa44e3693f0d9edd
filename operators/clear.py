"""Clear Bake, and older actions that look as before."""

from typing import Any

import bpy
from bpy.app.handlers import persistent

from ..bridge import before
from ..bridge.action import check_writable
from ..properties.scene import footwork_of
from .base import FootworkOperator


class FOOTWORK_OT_clear_bake(FootworkOperator, bpy.types.Operator):
    """Take the bake off the rig: action, pose, switches and strips are as before it"""

    bl_idname = "footwork.clear_bake"
    bl_label = "Clear Bake"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def refusal(cls, context: bpy.types.Context) -> str:
        rig = footwork_of(context.scene).rig
        if rig is None:
            return "Pick a rig first"
        return "" if before.bake_of(rig) else "The rig plays no bake"

    def work(self, context: bpy.types.Context) -> None:
        rig = footwork_of(context.scene).rig
        check_writable(rig)
        name = before.clear_bake(rig)
        self.tell("INFO", f"{rig.name}: {name} is cleared, the rig is as before")


@persistent
def tidy(scene: bpy.types.Scene, depsgraph: Any = None) -> None:
    """Before a frame is evaluated: what a bake left on bones that the action of now does not key."""
    before.watch(before.watched())


@persistent
def notice(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    """After an update: objects whose action may be another one."""
    # by name: the original of an evaluated object may be freed by now
    names = [update.id.name for update in depsgraph.updates if isinstance(update.id, bpy.types.Object)]
    before.watch([obj for obj in map(bpy.data.objects.get, names) if obj is not None])


@persistent
def loaded(*_: Any) -> None:
    """After a file is opened: the bakes in it."""
    before.watch(bpy.data.objects)


HANDLERS = (
    (bpy.app.handlers.frame_change_pre, tidy),
    (bpy.app.handlers.depsgraph_update_post, notice),
    (bpy.app.handlers.load_post, loaded),
)
CLASSES = (FOOTWORK_OT_clear_bake,)

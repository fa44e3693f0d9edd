"""What all parts of the Footwork tab share."""

import textwrap
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import bpy

from ..operators import job_operator
from ..properties.scene import FOOTWORK_PG_scene, footwork_of
from . import text


class Part:
    """What all parts of the tab share."""

    if TYPE_CHECKING:
        layout: bpy.types.UILayout

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Footwork"

    def draw_header_preset(self, context: bpy.types.Context) -> None:
        """Say at the right of the header how far this step is."""
        icon = self.step_icon(footwork_of(context.scene))
        if icon:
            self.layout.label(text="", icon=icon)

    def step_icon(self, footwork: FOOTWORK_PG_scene) -> Any:
        """Icon for the step's state, "" for none."""
        return ""


def job_button(layout: bpy.types.UILayout, operator: str, icon: Any, scale: float) -> None:
    """The button that starts a job; while the job runs, its progress and a button to cancel it."""
    if not job_progress(layout, operator):
        row = layout.row()
        row.scale_y = scale
        row.operator(operator, icon=icon)


def job_progress(layout: bpy.types.UILayout, operator: str) -> bool:
    """How far this operator's job is; False where it does not run."""
    running = job_operator.running
    if running is None or running.operator != operator:
        return False
    row = layout.row(align=True)
    row.progress(factor=running.fraction, text=f"{running.title}: {running.fraction:.0%}")
    row.operator("footwork.cancel_job", text="", icon="X")
    message = layout.column(align=True)
    message.active = False
    message.scale_y = 0.8
    for line in textwrap.wrap(running.message, text.width_of(bpy.context)) or [""]:
        message.label(text=line)
    return True


def settings_column(layout: bpy.types.UILayout, settings: Any, names: Iterable[str]) -> None:
    """Settings below each other: choices beside their name, numbers with the name inside."""
    column = layout.column(align=True)
    weights = False
    for name in names:
        if name.startswith("weight_") != weights:
            weights = not weights
            column = layout.column(align=True)
            if weights:
                column.label(text="Weights in the Search")
        if settings.bl_rna.properties[name].type == "ENUM":
            split = column.split(factor=0.35)
            split.label(text=settings.bl_rna.properties[name].name)
            split.prop(settings, name, text="")
        else:
            column.prop(settings, name)

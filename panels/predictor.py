"""3: where the body's direction comes from."""

import bpy

from ..operators import training
from ..operators.predictor import predictor_path
from ..properties.preferences import ADD_ON
from ..properties.scene import FOOTWORK_PG_scene, footwork_of
from . import text
from .parts import Part, job_button, settings_column


class FOOTWORK_PT_predictor(Part, bpy.types.Panel):
    """Where the body's direction comes from"""

    bl_idname = "FOOTWORK_PT_predictor"
    bl_label = "3  Predictor"
    bl_options = {"DEFAULT_CLOSED"}

    def step_icon(self, footwork: FOOTWORK_PG_scene) -> str:
        missing = footwork.predictor == "FILE" and not footwork.predictor_path
        return "" if missing else "CHECKMARK"

    def draw(self, context: bpy.types.Context) -> None:
        layout, footwork = self.layout, footwork_of(context.scene)
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(footwork, "predictor", text="Source")
        if footwork.predictor == "FILE":
            layout.prop(footwork, "predictor_path", text="File")
        header, body = layout.panel("FOOTWORK_training", default_closed=True)
        header.label(text="Training")
        if not body:
            return
        missing = training.find_trainer(context).missing
        if missing:
            text.notes(context, body, missing, "INFO")
            body.operator("preferences.addon_show", text="Preferences", icon="PREFERENCES").module = ADD_ON
        body.prop(footwork, "train_path", placeholder=predictor_path(footwork).name)
        body.use_property_split = False
        settings = footwork.train_settings
        paper = settings.kind == "paper"
        unused = "voters" if paper else "iterations"
        settings_column(body, settings, [name for name in settings.__annotations__ if name != unused])
        job_button(body, "footwork.train_predictor", "PLAY", 1.3)
        if footwork.trained:
            text.notes(context, body, footwork.trained, "CHECKMARK")


CLASSES = (FOOTWORK_PT_predictor,)

"""Train a body-orientation predictor on the takes."""

from pathlib import Path
from typing import Any

import bpy
from bpy.props import StringProperty

from ..bridge.lookup import keep_scene
from ..bridge.settings import read_settings
from ..core.errors import InputError
from ..core.jobs import Job
from ..nn.settings import TrainSettings
from ..nn.train.checkpoint import checkpoint_path
from ..properties.scene import FOOTWORK_PG_scene, footwork_of
from . import paths, rows, training
from .job_operator import JobOperator


class FOOTWORK_OT_train_predictor(JobOperator, bpy.types.Operator):
    """Train a predictor on the takes that are ticked and use it; runs beside Blender, for some minutes"""

    bl_idname = "footwork.train_predictor"
    bl_label = "Train Predictor"
    bl_options = {"REGISTER", "UNDO"}
    title = "Training the predictor"
    works_elsewhere = True

    filepath: StringProperty(
        name="Save As",
        description="File to write; empty for the panel's",
        subtype="FILE_PATH",
        # hidden, or Adjust Last Operation would do it all again
        options={"SKIP_SAVE", "HIDDEN"},
    )

    @classmethod
    def refusal(cls, context: bpy.types.Context) -> str:
        takes = footwork_of(context.scene).takes
        if not any(take.use and take.state != "FAULT" for take in takes):
            return "Tick at least one usable take" if takes else "Add takes first"
        return training.find_trainer(context).missing

    def start(self, context: bpy.types.Context) -> Job[Any]:
        footwork = footwork_of(context.scene)
        self._scene = keep_scene(context.scene)
        self.kept = (self._scene,)
        self._path = predictor_path(footwork, self.filepath)
        settings = read_settings(footwork.train_settings, TrainSettings)
        if not self._path.parent.is_dir():
            raise InputError(f"{self._path.parent}: no such folder; choose another file under Save As")
        if settings.resume and not self._path.is_file() and not checkpoint_path(self._path).is_file():
            raise InputError(f"{self._path}: no such file to go on from; switch Resume off")
        takes = [
            (bpy.path.abspath(take.path), rows.answers_of(take))
            for take in footwork.takes
            if take.use and take.state != "FAULT"
        ]
        return training.train(training.find_trainer(context).python, takes, self._path, settings)

    def after_cancel(self):
        kept = checkpoint_path(self._path)
        if kept.is_file():
            return f"switch Resume on to go on from {kept.name}"
        return JobOperator.after_cancel(self)

    def finish(self, context: bpy.types.Context, result: Any) -> None:
        footwork = footwork_of(self._scene.find())
        footwork.predictor, footwork.predictor_path = "FILE", paths.stored(str(self._path))
        footwork.trained = in_words(result)
        self.tell("INFO", f"{self._path.name} trained: {footwork.trained}")


def predictor_path(footwork: FOOTWORK_PG_scene, override: str = "") -> Path:
    """Where the next predictor is written."""
    return paths.output(override or footwork.train_path, "predictor")


def in_words(report: dict) -> str:
    """What came of a training."""
    return (
        f"{report['held_out_error_deg']:.1f}° mean error on takes held out, "
        f"the headset's forward {report['headset_forward_error_deg']:.1f}°"
    )


CLASSES = (FOOTWORK_OT_train_predictor,)

"""Train a body-orientation predictor on the takes, in a process of its own."""

import importlib.util
import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import fields
from functools import lru_cache
from pathlib import Path

import bpy
from bpy.props import StringProperty

from ..bridge.lookup import find_scene
from ..bridge.settings import read_settings
from ..core.errors import InputError
from ..nn.settings import TrainSettings
from . import files
from .job_operator import JobOperator

PACKAGE_FOLDER = Path(__file__).parents[1]


@lru_cache(maxsize=1)
def torch_missing() -> str:
    """Why training is not possible here, "" where it is."""
    if importlib.util.find_spec("torch") is None:
        return "Training needs PyTorch in Blender's Python; everything else works without it"
    return ""


class FOOTWORK_OT_train_predictor(JobOperator, bpy.types.Operator):
    """Train a predictor on the takes that are ticked and use it; runs beside Blender, for some minutes"""

    bl_idname = "footwork.train_predictor"
    bl_label = "Train Predictor"
    bl_options = {"REGISTER", "UNDO"}
    title = "Training the predictor"

    filepath: StringProperty(
        name="Save As",
        description="File to write; empty for a name beside the .blend file",
        subtype="FILE_PATH",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def refusal(cls, context):
        if torch_missing():
            return torch_missing()
        takes = context.scene.footwork.takes
        return "" if any(take.use for take in takes) else "Add takes first"

    def start(self, context):
        footwork = context.scene.footwork
        self._scene = context.scene.name
        self._path = predictor_path(self.filepath)
        takes = [bpy.path.abspath(take.path) for take in footwork.takes if take.use and take.state != "FAULT"]
        flags = _flags(read_settings(footwork.train_settings, TrainSettings))
        return _train(["train-predictor", *takes, "-o", str(self._path), *flags])

    def finish(self, context, result):
        footwork = find_scene(self._scene).footwork
        footwork.predictor, footwork.predictor_path = "FILE", files.stored(str(self._path))
        self.report({"INFO"}, f"{self._path.name} trained" + (f": {result}" if result else ""))


def predictor_path(override: str = "") -> Path:
    """Where the next predictor is written."""
    if override:
        return Path(bpy.path.abspath(override)).with_suffix(".npz")
    stem = Path(bpy.data.filepath).stem if bpy.data.filepath else "footwork"
    return Path(files.beside_blend(f"{stem}_predictor.npz"))


def _flags(settings: TrainSettings) -> list[str]:
    """The command line's flags for everything that is not at its default."""
    flags = []
    for item in fields(settings):
        value, flag = getattr(settings, item.name), item.name.replace("_", "-")
        if value == item.default:
            continue
        if isinstance(value, bool):
            flags.append(f"--{flag}" if value else f"--no-{flag}")
        else:
            flags += [f"--{flag}", str(value)]
    return flags


def _train(arguments):
    """Run the command line in Blender's Python; closing the generator ends the process."""
    with tempfile.TemporaryDirectory() as folder:
        log, report = Path(folder) / "log", Path(folder) / "report.json"
        with log.open("wb") as sink:
            process = subprocess.Popen(
                [sys.executable, "-m", "footwork", *arguments, "--json", str(report)],
                stdout=sink,
                stderr=sink,
                env=_environment(),
            )
        try:
            with log.open(encoding="utf-8", errors="replace") as lines:
                fraction, message = 0.0, "Starting"
                while process.poll() is None:
                    for line in lines:
                        fraction, message = _progress(line, fraction, message)
                    yield fraction, message
                    time.sleep(0.02)
        finally:
            if process.poll() is None:
                process.terminate()
                process.wait()
        if process.returncode != 0:
            last = [line for line in log.read_text(encoding="utf-8", errors="replace").splitlines() if line]
            fault = last[-1].removeprefix("footwork train-predictor: ") if last else ""
            raise InputError(fault or f"training ended with code {process.returncode}; try again")
        return _summary(json.loads(report.read_text(encoding="utf-8")))


def _environment() -> dict[str, str]:
    """An environment in which this very package is importable under its own name."""
    places = [str(PACKAGE_FOLDER.parent)] if PACKAGE_FOLDER.name == "footwork" else []
    return {**os.environ, "PYTHONPATH": os.pathsep.join([*places, *filter(None, sys.path)])}


def _progress(line: str, fraction: float, message: str) -> tuple[float, str]:
    """Progress lines are "[ 12%] message"."""
    head, bracket, rest = line.partition("%]")
    if bracket and head.lstrip("[ ").isdigit():
        return int(head.lstrip("[ ")) / 100.0, rest.strip()
    return fraction, message


def _summary(report: dict) -> str:
    error = report.get("held_out_error_deg")
    return f"{error:.1f}° mean error on takes held out" if isinstance(error, float) else ""


CLASSES = (FOOTWORK_OT_train_predictor,)

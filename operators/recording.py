"""The recording: choose and read a file, show it in the scene, make one from a take."""

import math
from pathlib import Path

import bpy
from bpy.props import StringProperty
from bpy_extras.io_utils import ExportHelper, ImportHelper, poll_file_object_drop

from ..bridge.action import scene_fps
from ..bridge.objects import show_recording
from ..bridge.settings import typed
from ..core.errors import InputError
from ..core.recording.csv_format import write_csv
from ..core.recording.cut import cut
from ..core.recording.formats import suffixes
from ..core.recording.read import read_recording
from ..core.recording.reading.answers import Answers
from ..core.recording.simulate import simulate_recording
from ..properties.reading import FOOTWORK_PG_reading
from ..properties.scene import FOOTWORK_PG_scene, footwork_of
from . import paths
from .base import FootworkOperator
from .rows import RowOperator, answers_of, read_take, told


def calibrated(footwork: FOOTWORK_PG_scene) -> float | None:
    """The eye height in metres that was set by hand, if it was."""
    return typed(footwork.eye_height) if footwork.use_eye_height else None


def read_answers(footwork: FOOTWORK_PG_scene) -> Answers:
    """What the panel says of the recording's file."""
    reading = footwork.reading
    return Answers(
        axes="" if reading.axes == "AUTO" else reading.axes,
        unit="" if reading.unit == "AUTO" else reading.unit,
        rate=typed(reading.rate) or None,
        rotation="" if reading.rotation == "AUTO" else reading.rotation,
        swap_hands=reading.swap_hands,
        eye_height=calibrated(footwork),
        mounts=_mounts(reading),
        force=reading.force,
        auto_trim=reading.auto_trim,
    )


def _mounts(reading: FOOTWORK_PG_reading) -> str:
    """How devices sit, as `Answers` has it."""
    if reading.mounts == "CUSTOM":
        numbers = (
            reading.headset_ahead,
            reading.headset_above,
            reading.controller_reach,
            reading.controller_pitch,
        )
        return ",".join(f"{typed(value):g}" for value in numbers)
    return "" if reading.mounts == "AUTO" else reading.mounts


def wanted_part(footwork: FOOTWORK_PG_scene) -> tuple[float, float]:
    """Start and stop in seconds of the part that shall be baked."""
    return typed(footwork.recording_from), typed(footwork.recording_to) or math.inf


class FOOTWORK_OT_load_recording(FootworkOperator, ImportHelper, bpy.types.Operator):
    """Choose a recording of a headset and two controllers, and read what is in it"""

    bl_idname = "footwork.load_recording"
    bl_label = "Load Recording"
    bl_options = {"REGISTER", "UNDO"}

    filter_glob: StringProperty(default=";".join(f"*{suffix}" for suffix in suffixes()), options={"HIDDEN"})
    filename_ext = ".csv"

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        given = self.properties.is_property_set("filepath")
        return self.execute(context) if given else super().invoke(context, event)

    def work(self, context: bpy.types.Context) -> None:
        use_recording(self, footwork_of(context.scene), paths.chosen(self)[0])


class RecordingOperator(FootworkOperator):
    """Mixin for operators on the recording's file."""

    @classmethod
    def refusal(cls, context: bpy.types.Context) -> str:
        footwork = footwork_of(context.scene)
        chosen = footwork.recording_source == "FILE" and footwork.recording_path
        return "" if chosen else "Choose a recording file first"


class FOOTWORK_OT_inspect_recording(RecordingOperator, bpy.types.Operator):
    """Read the recording again and show what is found in it"""

    bl_idname = "footwork.inspect_recording"
    bl_label = "Read Recording"
    bl_options = {"INTERNAL"}

    def work(self, context: bpy.types.Context) -> None:
        inspect(self, footwork_of(context.scene))


class FOOTWORK_OT_show_recording(RecordingOperator, bpy.types.Operator):
    """Show the recording as three animated empties, which can also be edited and baked from"""

    bl_idname = "footwork.show_recording"
    bl_label = "Show Trackers"
    bl_options = {"REGISTER", "UNDO"}

    def work(self, context: bpy.types.Context) -> None:
        scene = context.scene
        footwork = footwork_of(scene)
        recording = read_recording(bpy.path.abspath(footwork.recording_path), read_answers(footwork))
        recording = cut(recording, *wanted_part(footwork))
        empties = show_recording(recording, scene, footwork.frame_start)
        footwork.head, footwork.left, footwork.right = empties
        footwork.tracker_axes = "Y_FORWARD"
        frames = recording.times[-1] * scene_fps(scene)
        self.tell("INFO", f"{recording.name}: three empties, {frames:.0f} frames")


class FOOTWORK_OT_simulate_recording(RowOperator, ExportHelper, bpy.types.Operator):
    """Make a recording with virtual trackers from the selected take, to try things without a headset"""

    bl_idname = "footwork.simulate_recording"
    bl_label = "Recording from Take"
    bl_options = {"REGISTER", "UNDO"}
    what = "take"

    filename_ext = ".csv"
    filter_glob: StringProperty(default="*.csv", options={"HIDDEN"})

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        self.filepath = paths.beside_blend(f"{Path(bpy.path.abspath(self.active(context).path)).stem}.csv")
        return super().invoke(context, event)

    def work(self, context: bpy.types.Context) -> None:
        row = self.active(context)
        take = read_take(bpy.path.abspath(row.path), answers_of(row))
        write_csv(self.filepath, simulate_recording(take.motion, take.name))
        use_recording(self, footwork_of(context.scene), self.filepath)


def use_recording(operator: FootworkOperator, footwork: FOOTWORK_PG_scene, path: str) -> None:
    """Make a file the scene's recording, all of it, and read it."""
    footwork.recording_source = "FILE"
    footwork.recording_path = paths.stored(path)
    footwork.recording_from = footwork.recording_to = 0.0
    inspect(operator, footwork)


def inspect(operator: FootworkOperator, footwork: FOOTWORK_PG_scene) -> None:
    """Show what is found in the recording's file, or what is wrong with it."""
    try:
        recording = read_recording(bpy.path.abspath(footwork.recording_path), read_answers(footwork))
    except InputError as error:
        footwork.recording_state, footwork.recording_found = "FAULT", ""
        footwork.recording_doubts = str(error)
        raise
    footwork.recording_found, footwork.recording_doubts = told(recording)
    footwork.recording_state = "DOUBT" if recording.doubts else "OK"
    footwork.eye_height = recording.eye_height
    operator.tell("INFO", f"{recording.name}: {recording.times[-1]:.1f} s at {recording.fps:.0f} per second")


class FOOTWORK_FH_recording(bpy.types.FileHandler):
    """Dropping a recording loads it"""

    bl_idname = "FOOTWORK_FH_recording"
    bl_label = "Footwork: Load Recording"
    bl_import_operator = "footwork.load_recording"
    bl_file_extensions = ";".join(suffixes())

    @classmethod
    def poll_drop(cls, context: bpy.types.Context) -> bool:
        return poll_file_object_drop(context)


CLASSES = (
    FOOTWORK_OT_load_recording,
    FOOTWORK_OT_inspect_recording,
    FOOTWORK_OT_show_recording,
    FOOTWORK_OT_simulate_recording,
    FOOTWORK_FH_recording,
)

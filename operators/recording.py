"""The recording: choose and read a file, show it in the scene, make one from a take."""

import math
from pathlib import Path

import bpy
from bpy.props import StringProperty
from bpy_extras.io_utils import ExportHelper, ImportHelper, poll_file_object_drop

from ..bridge.action import scene_fps
from ..bridge.objects import show_recording
from ..core.errors import InputError
from ..core.mocap.takes import load_take
from ..core.recording.csv_format import write_csv
from ..core.recording.cut import cut
from ..core.recording.formats import suffixes
from ..core.recording.read import read_recording
from ..core.recording.simulate import simulate_recording
from . import files


def calibrated(footwork) -> float | None:
    """The eye height in metres that was set by hand, if it was."""
    return files.typed(footwork.eye_height) if footwork.use_eye_height else None


def wanted_part(footwork) -> tuple[float, float]:
    """Start and stop in seconds of the part that shall be baked."""
    return files.typed(footwork.recording_from), files.typed(footwork.recording_to) or math.inf


class FOOTWORK_OT_load_recording(bpy.types.Operator, ImportHelper):
    """Choose a recording of a headset and two controllers, and read what is in it"""

    bl_idname = "footwork.load_recording"
    bl_label = "Load Recording"
    bl_options = {"REGISTER", "UNDO"}

    filter_glob: StringProperty(default=";".join(f"*{suffix}" for suffix in suffixes()), options={"HIDDEN"})
    filename_ext = ".csv"

    def invoke(self, context, event):
        given = self.properties.is_property_set("filepath")
        return self.execute(context) if given else super().invoke(context, event)

    def execute(self, context):
        footwork = context.scene.footwork
        footwork.recording_source = "FILE"
        footwork.recording_path = files.stored(bpy.path.abspath(self.filepath))
        return bpy.ops.footwork.inspect_recording()


class FOOTWORK_OT_inspect_recording(bpy.types.Operator):
    """Read the recording again and show what is found in it"""

    bl_idname = "footwork.inspect_recording"
    bl_label = "Read Recording"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context):
        return _poll_file(cls, context)

    def execute(self, context):
        footwork = context.scene.footwork
        try:
            recording = read_recording(bpy.path.abspath(footwork.recording_path), calibrated(footwork))
        except InputError as error:
            footwork.recording_state, footwork.recording_found = "FAULT", ""
            footwork.recording_doubts = str(error)
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        footwork.recording_found, footwork.recording_doubts = files.told(recording)
        footwork.recording_state = "DOUBT" if recording.doubts else "OK"
        footwork.eye_height = recording.eye_height
        self.report(
            {"INFO"}, f"{recording.name}: {recording.times[-1]:.1f} s at {recording.fps:.0f} per second"
        )
        return {"FINISHED"}


class FOOTWORK_OT_show_recording(bpy.types.Operator):
    """Show the recording as three animated empties, which can also be edited and baked from"""

    bl_idname = "footwork.show_recording"
    bl_label = "Show Trackers"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return _poll_file(cls, context)

    def execute(self, context):
        scene = context.scene
        footwork = scene.footwork
        try:
            recording = read_recording(bpy.path.abspath(footwork.recording_path), calibrated(footwork))
            recording = cut(recording, *wanted_part(footwork))
            empties = show_recording(recording, scene, footwork.frame_start)
        except InputError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        footwork.head, footwork.left, footwork.right = empties
        footwork.tracker_axes = "Y_FORWARD"
        frames = recording.times[-1] * scene_fps(scene)
        self.report({"INFO"}, f"{recording.name}: three empties, {frames:.0f} frames")
        return {"FINISHED"}


class FOOTWORK_OT_simulate_recording(bpy.types.Operator, ExportHelper):
    """Make a recording with virtual trackers from the selected take, to try things without a headset"""

    bl_idname = "footwork.simulate_recording"
    bl_label = "Recording from Take"
    bl_options = {"REGISTER", "UNDO"}

    filename_ext = ".csv"
    filter_glob: StringProperty(default="*.csv", options={"HIDDEN"})

    @classmethod
    def poll(cls, context):
        return files.poll_active(cls, context.scene.footwork.takes, "take")

    def invoke(self, context, event):
        take = files.active(context.scene.footwork.takes, context.scene.footwork.take_index)
        self.filepath = files.beside_blend(f"{Path(bpy.path.abspath(take.path)).stem}.csv")
        return super().invoke(context, event)

    def execute(self, context):
        footwork = context.scene.footwork
        row = files.active(footwork.takes, footwork.take_index)
        try:
            take = load_take(bpy.path.abspath(row.path))
            write_csv(self.filepath, simulate_recording(take.motion, take.name))
        except InputError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return bpy.ops.footwork.load_recording(filepath=self.filepath)


class FOOTWORK_FH_recording(bpy.types.FileHandler):
    """Dropping a recording loads it"""

    bl_idname = "FOOTWORK_FH_recording"
    bl_label = "Footwork: Load Recording"
    bl_import_operator = "footwork.load_recording"
    bl_file_extensions = ";".join(suffixes())

    @classmethod
    def poll_drop(cls, context):
        return poll_file_object_drop(context)


def _poll_file(operator, context) -> bool:
    footwork = context.scene.footwork
    if footwork.recording_source != "FILE" or not footwork.recording_path:
        operator.poll_message_set("Choose a recording file first")
        return False
    return True


CLASSES = (
    FOOTWORK_OT_load_recording,
    FOOTWORK_OT_inspect_recording,
    FOOTWORK_OT_show_recording,
    FOOTWORK_OT_simulate_recording,
    FOOTWORK_FH_recording,
)

"""The mapping assistant: what each column of the recording's file was taken for, corrected and kept."""

import functools
from pathlib import Path

import bpy
from bpy.props import CollectionProperty, IntProperty, StringProperty

from ..core.errors import InputError
from ..core.recording.mapping import Look, look, poses_in_words
from ..core.recording.reading.answers import Answers
from ..core.recording.reading.kept import COLUMNS, check_said, keep_map
from ..core.recording.reading.meaning import PARTS
from ..core.recording.recording import TRACKERS
from ..properties.scene import footwork_of
from .recording import RecordingOperator, inspect, read_answers

_MEANINGS = (*COLUMNS, *(f"{tracker}.{part}" for tracker in TRACKERS for part in PARTS), *TRACKERS)
_WIDTH = 620


def _meanings(self, context: bpy.types.Context, edit_text: str) -> list[str]:
    return [text for text in _MEANINGS if edit_text.lower() in text]


class FOOTWORK_PG_map_column(bpy.types.PropertyGroup):
    """A column of a recording's file"""

    example: StringProperty(name="First Value", description="What the column holds first")
    before: StringProperty(name="Taken For", description="What it was taken for when the dialog opened")
    said: StringProperty(
        name="Meaning",
        description="What the column is: time, frame, device, nothing, or a part of a pose such as head.px",
        search=_meanings,
        search_options={"SUGGESTION"},
    )


class FOOTWORK_UL_map_columns(bpy.types.UIList):
    """The columns of a recording's file"""

    bl_idname = "FOOTWORK_UL_map_columns"

    def draw_item(self, context, layout, data, item, icon, active_data, active_property, index=0):
        row = layout.split(factor=0.35)
        row.label(text=item.name, translate=False)
        row = row.split(factor=0.4)
        row.label(text=item.example, translate=False)
        row.prop(item, "said", text="", icon="GREASEPENCIL" if item.said != item.before else "NONE")


class FOOTWORK_OT_map_recording(RecordingOperator, bpy.types.Operator):
    """Show what each column of the recording's file was taken for, correct it, and keep that for files like it"""

    bl_idname = "footwork.map_recording"
    bl_label = "Map Columns"
    bl_options = {"REGISTER", "UNDO"}

    columns: CollectionProperty(type=FOOTWORK_PG_map_column, options={"SKIP_SAVE"})
    active: IntProperty(options={"HIDDEN", "SKIP_SAVE"})
    kept_name: StringProperty(
        name="Keep As",
        description="Name under which the answer is kept in your presets",
        options={"SKIP_SAVE"},
    )

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        path = _path(context)
        try:
            shown = look(path, {}, read_answers(footwork_of(context.scene)))
            if not shown.columns:
                raise InputError(f"{path}: its format says what its numbers are; there are no columns to map")
        except InputError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.columns.clear()
        for column in shown.columns:
            item = self.columns.add()
            item.name, item.example = column.name, column.example[:16]
            item.before = item.said = column.said
        self.kept_name = self.kept_name or Path(path).stem
        return context.window_manager.invoke_props_dialog(self, width=_WIDTH)

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        row = layout.split(factor=0.35)
        row.label(text="Column")
        row = row.split(factor=0.4)
        row.label(text="First Value")
        row.label(text="Taken For")
        layout.template_list(
            FOOTWORK_UL_map_columns.bl_idname, "", self, "columns", self, "active", rows=10, maxrows=14
        )
        box = layout.box().column(align=True)
        for text, fine in _told(_path(context), self._said(), read_answers(footwork_of(context.scene))):
            box.label(text=text, icon="NONE" if fine else "ERROR", translate=False)
        layout.prop(self, "kept_name")

    def work(self, context: bpy.types.Context) -> None:
        footwork, said = footwork_of(context.scene), dict(self._said())
        for name, text in said.items():
            try:
                said[name] = check_said(text)
            except ValueError as error:
                raise InputError(f"{name}: {error}") from None
        answers = read_answers(footwork)
        seen = look(_path(context), said, answers)
        if seen.recording is None:
            raise InputError(seen.fault)
        name = self.kept_name.strip() or Path(_path(context)).stem
        path = keep_map(seen.to_keep(name, said, answers))
        inspect(self, footwork)
        self.tell("INFO", f"kept in {path}")

    def _said(self) -> tuple[tuple[str, str], ...]:
        """What the person has changed, by column."""
        return tuple((item.name, item.said) for item in self.columns if item.said != item.before)


def _path(context: bpy.types.Context) -> str:
    return bpy.path.abspath(footwork_of(context.scene).recording_path)


@functools.lru_cache(maxsize=4)
def _told(path: str, said: tuple[tuple[str, str], ...], answers: Answers) -> tuple[tuple[str, bool], ...]:
    """What comes of the columns, and whether each line is no fault: the poses, or what keeps them from being read."""
    try:
        seen: Look = look(path, dict(said), answers)
    except (InputError, ValueError) as error:
        return ((str(error).removeprefix(f"{path}: "), False),)
    if seen.recording is None:
        return ((seen.fault.removeprefix(f"{path}: "), False),)
    poses = tuple((f"{name}: {text}", True) for name, text in poses_in_words(seen.recording).items())
    reading = seen.recording.found.get("reading", "")
    doubts = tuple((doubt, False) for doubt in seen.recording.doubts)
    return (*poses, *(((f"read as {reading}", True),) if reading else ()), *doubts)


CLASSES = (FOOTWORK_PG_map_column, FOOTWORK_UL_map_columns, FOOTWORK_OT_map_recording)

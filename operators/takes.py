"""The list of takes: add, remove, reorder, look at what is in them, show one in the scene."""

from pathlib import Path
from typing import Any

import bpy
from bpy.props import CollectionProperty, EnumProperty, IntProperty, StringProperty
from bpy_extras.io_utils import ImportHelper, poll_file_object_drop

from ..bridge import preview
from ..bridge.action import scene_fps
from ..bridge.lookup import keep_scene
from ..core.database.contact_edits import ContactEdit
from ..core.errors import InputError
from ..core.jobs import Job
from ..core.mocap.answers import NO_ANSWERS, TakeAnswers
from ..core.mocap.containers import SUFFIXES
from ..properties.scene import FOOTWORK_PG_scene, footwork_of
from . import paths, rows
from .base import FootworkOperator
from .contacts import contacts_to_show, edits_of_row
from .job_operator import JobOperator
from .rows import RowOperator

_GLOB = ";".join(f"*{suffix}" for suffix in SUFFIXES)


class FOOTWORK_OT_add_takes(FootworkOperator, ImportHelper, bpy.types.Operator):
    """Add motion-capture files to the list; each is read to see what is in it"""

    bl_idname = "footwork.add_takes"
    bl_label = "Add Takes"
    bl_options = {"REGISTER", "UNDO"}

    directory: StringProperty(subtype="DIR_PATH", options={"SKIP_SAVE", "HIDDEN"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"SKIP_SAVE", "HIDDEN"})
    filter_glob: StringProperty(default=_GLOB, options={"HIDDEN"})
    filename_ext = ".bvh"

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        # files that were dropped need no file browser
        return self.execute(context) if self.files else super().invoke(context, event)

    def work(self, context: bpy.types.Context) -> None:
        footwork = footwork_of(context.scene)
        listed = {paths.absolute(take.path) for take in footwork.takes}
        for path in paths.chosen(self):
            if paths.absolute(path) not in listed:
                row = footwork.takes.add()
                row.path, row.name = paths.stored(path), Path(path).stem
                footwork.take_index = len(footwork.takes) - 1
        mode = "INVOKE_DEFAULT" if self.options.is_invoke else "EXEC_DEFAULT"
        bpy.ops.footwork.inspect_takes(mode)  # pyright: ignore[reportAttributeAccessIssue]


class FOOTWORK_OT_inspect_takes(JobOperator, bpy.types.Operator):
    """Read the takes again and show what is found in them"""

    bl_idname = "footwork.inspect_takes"
    bl_label = "Read Takes"
    bl_options = {"INTERNAL"}
    title = "Reading takes"

    which: EnumProperty(
        name="Which",
        description="Which takes to read",
        items=[("NEW", "New", "Takes that were not read yet"), ("ALL", "All", "Every take of the list")],
        options={"SKIP_SAVE"},
    )

    @classmethod
    def refusal(cls, context: bpy.types.Context) -> str:
        return "" if footwork_of(context.scene).takes else "Add takes first"

    def start(self, context: bpy.types.Context) -> Job[Any]:
        self._scene = keep_scene(context.scene)
        self.kept = (self._scene,)
        takes = footwork_of(context.scene).takes
        return _inspect(
            [
                (bpy.path.abspath(take.path), rows.answers_of(take))
                for take in takes
                if self.which == "ALL" or take.state == "NEW"
            ]
        )

    def finish(self, context: bpy.types.Context, result: Any) -> None:
        faults = 0
        for take in footwork_of(self._scene.find()).takes:
            if bpy.path.abspath(take.path) in result:
                state, seconds, found, doubts = result[bpy.path.abspath(take.path)]
                take.state, take.seconds, take.found, take.doubts = state, seconds, found, doubts
                faults += state == "FAULT"
                if state == "FAULT":
                    self.tell("WARNING", doubts)
        self.tell("INFO", f"{len(result)} takes read" + (f", {faults} cannot be used" if faults else ""))


def _inspect(asked):
    results = {}
    for number, (path, answers) in enumerate(asked):
        yield number / len(asked), Path(path).name
        try:
            take = rows.read_take(path, answers)
        except InputError as error:
            results[path] = ("FAULT", 0.0, "", str(error))
            continue
        seconds = (len(take.motion) - 1) / take.motion.fps
        found, doubts = rows.told(take)
        results[path] = ("DOUBT" if doubts else "OK", seconds, found, doubts)
    return results


class FOOTWORK_OT_remove_take(RowOperator, bpy.types.Operator):
    """Take the selected take off the list; its file stays"""

    bl_idname = "footwork.remove_take"
    bl_label = "Remove Take"
    bl_options = {"REGISTER", "UNDO"}
    what = "take"

    def work(self, context: bpy.types.Context) -> None:
        self.remove(context)


class FOOTWORK_OT_clear_takes(RowOperator, bpy.types.Operator):
    """Take all takes off the list; their files stay"""

    bl_idname = "footwork.clear_takes"
    bl_label = "Remove All Takes"
    bl_options = {"REGISTER", "UNDO"}
    what = "take"

    def work(self, context: bpy.types.Context) -> None:
        self.rows(context).clear()


class FOOTWORK_OT_move_take(RowOperator, bpy.types.Operator):
    """Move the selected take in the list: the first one gives the database its skeleton"""

    bl_idname = "footwork.move_take"
    bl_label = "Move Take"
    bl_options = {"REGISTER", "UNDO"}
    what = "take"

    step: IntProperty(name="Step", description="Rows to move down by", default=1)

    def work(self, context: bpy.types.Context) -> None:
        self.move(context, self.step)


class FOOTWORK_OT_import_take(FootworkOperator, ImportHelper, bpy.types.Operator):
    """Show a take as an armature in metres, upright, at the scene's frame rate; its foot contacts are keyed, too"""

    bl_idname = "footwork.import_take"
    bl_label = "Import Take as Armature"
    bl_options = {"REGISTER", "UNDO"}

    directory: StringProperty(subtype="DIR_PATH", options={"SKIP_SAVE", "HIDDEN"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"SKIP_SAVE", "HIDDEN"})
    filter_glob: StringProperty(default=_GLOB, options={"HIDDEN"})
    filename_ext = ".bvh"

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        given = self.files or self.properties.is_property_set("filepath")
        return self.execute(context) if given else super().invoke(context, event)

    def work(self, context: bpy.types.Context) -> None:
        scene = context.scene
        footwork = footwork_of(scene)
        shown = []
        for path in paths.chosen(self):
            take = rows.read_take(path, _answers_of(footwork, path))
            contacts = contacts_to_show(take, footwork, scene_fps(scene), _edits_of(footwork, path))
            shown.append((take, contacts, paths.stored(path)))
        for take, contacts, file in shown:
            obj = preview.show_take(take, contacts, file, context.collection, scene, footwork.frame_start)
            for doubt in take.doubts:
                self.tell("WARNING", f"{take.name}: {doubt}")
            _select_only(context, obj)
            self.tell("INFO", f"{take.name}: {len(contacts)} frames at {scene_fps(scene):g} fps")


def _select_only(context: bpy.types.Context, obj: bpy.types.Object) -> None:
    """Make an object the only selected one and the active one."""
    for other in context.view_layer.objects:
        other.select_set(False)
    obj.select_set(True)
    context.view_layer.objects.active = obj


def _row_of(footwork: FOOTWORK_PG_scene, path: str) -> Any:
    """The row of a file in the list of takes; None where it is not in it."""
    return next((row for row in footwork.takes if paths.absolute(row.path) == paths.absolute(path)), None)


def _edits_of(footwork: FOOTWORK_PG_scene, path: str) -> list[ContactEdit]:
    row = _row_of(footwork, path)
    return [] if row is None else edits_of_row(row)


def _answers_of(footwork: FOOTWORK_PG_scene, path: str) -> TakeAnswers:
    row = _row_of(footwork, path)
    return NO_ANSWERS if row is None else rows.answers_of(row)


class FOOTWORK_FH_takes(bpy.types.FileHandler):
    """Dropping takes adds them to the list"""

    bl_idname = "FOOTWORK_FH_takes"
    bl_label = "Footwork: Add to Takes"
    bl_import_operator = "footwork.add_takes"
    bl_file_extensions = ";".join(SUFFIXES)

    @classmethod
    def poll_drop(cls, context: bpy.types.Context) -> bool:
        return poll_file_object_drop(context)


class FOOTWORK_FH_import_take(bpy.types.FileHandler):
    """Dropping takes shows them in the scene"""

    bl_idname = "FOOTWORK_FH_import_take"
    bl_label = "Footwork: Import as Armature"
    bl_import_operator = "footwork.import_take"
    bl_file_extensions = ";".join(SUFFIXES)

    @classmethod
    def poll_drop(cls, context: bpy.types.Context) -> bool:
        return poll_file_object_drop(context)


CLASSES = (
    FOOTWORK_OT_add_takes,
    FOOTWORK_OT_inspect_takes,
    FOOTWORK_OT_remove_take,
    FOOTWORK_OT_clear_takes,
    FOOTWORK_OT_move_take,
    FOOTWORK_OT_import_take,
    FOOTWORK_FH_takes,
    FOOTWORK_FH_import_take,
)

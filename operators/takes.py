"""The list of takes: add, remove, reorder, look at what is in them, show one in the scene."""

from pathlib import Path

import bpy
from bpy.props import CollectionProperty, EnumProperty, IntProperty, StringProperty
from bpy_extras.io_utils import ImportHelper, poll_file_object_drop

from ..bridge import preview
from ..bridge.action import scene_fps
from ..bridge.lookup import find_scene
from ..core.errors import InputError
from ..core.mocap.takes import load_take
from . import files
from .contacts import contacts_to_show, edits_of_row
from .job_operator import JobOperator


class FOOTWORK_OT_add_takes(bpy.types.Operator, ImportHelper):
    """Add motion-capture files to the list; each is read to see what is in it"""

    bl_idname = "footwork.add_takes"
    bl_label = "Add Takes"
    bl_options = {"REGISTER", "UNDO"}

    directory: StringProperty(subtype="DIR_PATH", options={"SKIP_SAVE", "HIDDEN"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"SKIP_SAVE", "HIDDEN"})
    filter_glob: StringProperty(default="*.bvh", options={"HIDDEN"})
    filename_ext = ".bvh"

    def invoke(self, context, event):
        # files that were dropped need no file browser
        return self.execute(context) if self.files else super().invoke(context, event)

    def execute(self, context):
        footwork = context.scene.footwork
        paths = files.chosen(self)
        if not paths:
            self.report({"ERROR"}, "No file chosen")
            return {"CANCELLED"}
        listed = {files.absolute(take.path) for take in footwork.takes}
        for path in paths:
            if files.absolute(path) not in listed:
                row = footwork.takes.add()
                row.path, row.name = files.stored(path), Path(path).stem
                footwork.take_index = len(footwork.takes) - 1
        mode = "INVOKE_DEFAULT" if self.options.is_invoke else "EXEC_DEFAULT"
        bpy.ops.footwork.inspect_takes(mode)
        return {"FINISHED"}


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
    def refusal(cls, context):
        return "" if context.scene.footwork.takes else "Add takes first"

    def start(self, context):
        self._scene = context.scene.name
        takes = context.scene.footwork.takes
        return _inspect([bpy.path.abspath(t.path) for t in takes if self.which == "ALL" or t.state == "NEW"])

    def finish(self, context, result):
        faults = 0
        for take in find_scene(self._scene).footwork.takes:
            if bpy.path.abspath(take.path) in result:
                state, seconds, found, doubts = result[bpy.path.abspath(take.path)]
                take.state, take.seconds, take.found, take.doubts = state, seconds, found, doubts
                faults += state == "FAULT"
                if state == "FAULT":
                    self.report({"WARNING"}, doubts)
        self.report({"INFO"}, f"{len(result)} takes read" + (f", {faults} cannot be used" if faults else ""))


def _inspect(paths):
    results = {}
    for number, path in enumerate(paths):
        yield number / len(paths), Path(path).name
        try:
            take = load_take(path)
        except InputError as error:
            results[path] = ("FAULT", 0.0, "", str(error))
            continue
        seconds = (len(take.motion) - 1) / take.motion.fps
        found, doubts = files.told(take)
        results[path] = ("DOUBT" if doubts else "OK", seconds, found, doubts)
    return results


class FOOTWORK_OT_remove_take(bpy.types.Operator):
    """Take the selected take off the list; its file stays"""

    bl_idname = "footwork.remove_take"
    bl_label = "Remove Take"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return files.poll_active(cls, context.scene.footwork.takes, "take")

    def execute(self, context):
        footwork = context.scene.footwork
        footwork.take_index = files.remove_active(footwork.takes, footwork.take_index)
        return {"FINISHED"}


class FOOTWORK_OT_clear_takes(bpy.types.Operator):
    """Take all takes off the list; their files stay"""

    bl_idname = "footwork.clear_takes"
    bl_label = "Remove All Takes"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return files.poll_active(cls, context.scene.footwork.takes, "take")

    def execute(self, context):
        context.scene.footwork.takes.clear()
        return {"FINISHED"}


class FOOTWORK_OT_move_take(bpy.types.Operator):
    """Move the selected take in the list: the first one gives the database its skeleton"""

    bl_idname = "footwork.move_take"
    bl_label = "Move Take"
    bl_options = {"REGISTER", "UNDO"}

    step: IntProperty(name="Step", description="Rows to move down by", default=1)

    @classmethod
    def poll(cls, context):
        return files.poll_active(cls, context.scene.footwork.takes, "take")

    def execute(self, context):
        footwork = context.scene.footwork
        footwork.take_index = files.move_active(footwork.takes, footwork.take_index, self.step)
        return {"FINISHED"}


class FOOTWORK_OT_import_take(bpy.types.Operator, ImportHelper):
    """Show a take as an armature in metres, upright, at the scene's frame rate; its foot contacts are keyed, too"""

    bl_idname = "footwork.import_take"
    bl_label = "Import Take as Armature"
    bl_options = {"REGISTER", "UNDO"}

    directory: StringProperty(subtype="DIR_PATH", options={"SKIP_SAVE", "HIDDEN"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"SKIP_SAVE", "HIDDEN"})
    filter_glob: StringProperty(default="*.bvh", options={"HIDDEN"})
    filename_ext = ".bvh"

    def invoke(self, context, event):
        given = self.files or self.properties.is_property_set("filepath")
        return self.execute(context) if given else super().invoke(context, event)

    def execute(self, context):
        scene = context.scene
        fps, start = scene_fps(scene), scene.footwork.frame_start
        try:
            for path in files.chosen(self):
                take = load_take(path)
                contacts = contacts_to_show(take, scene.footwork, fps, _edits_of(scene.footwork, path))
                file = files.stored(path)
                obj = preview.show_take(take, contacts, file, context.collection, scene, start)
                for doubt in take.doubts:
                    self.report({"WARNING"}, f"{take.name}: {doubt}")
        except InputError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        files.select_only(context, obj)
        self.report({"INFO"}, f"{take.name}: {len(contacts)} frames at {fps:g} fps")
        return {"FINISHED"}


def _edits_of(footwork, path):
    """The edited contacts of a file that is in the list of takes; none where it is not."""
    rows = [row for row in footwork.takes if files.absolute(row.path) == files.absolute(path)]
    return edits_of_row(rows[0]) if rows else []


class FOOTWORK_FH_takes(bpy.types.FileHandler):
    """Dropping takes adds them to the list"""

    bl_idname = "FOOTWORK_FH_takes"
    bl_label = "Footwork: Add to Takes"
    bl_import_operator = "footwork.add_takes"
    bl_file_extensions = ".bvh"

    @classmethod
    def poll_drop(cls, context):
        return poll_file_object_drop(context)


class FOOTWORK_FH_import_take(bpy.types.FileHandler):
    """Dropping takes shows them in the scene"""

    bl_idname = "FOOTWORK_FH_import_take"
    bl_label = "Footwork: Import as Armature"
    bl_import_operator = "footwork.import_take"
    bl_file_extensions = ".bvh"

    @classmethod
    def poll_drop(cls, context):
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

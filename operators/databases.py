"""Motion databases: build one from the takes, and the list of those that a bake uses."""

from pathlib import Path
from typing import Any

import bpy
from bpy.props import CollectionProperty, IntProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

from ..bridge.lookup import keep_scene
from ..bridge.settings import read_settings
from ..core.database.build import build_database
from ..core.database.clips import parse_exclusion
from ..core.database.describe import describe_database
from ..core.database.motion_database import MotionDatabase
from ..core.database.sidecar import load_database, save_database
from ..core.errors import InputError
from ..core.jobs import Job, part
from ..core.mocap.take import repeated
from ..core.settings import DatabaseSettings
from ..properties.scene import FOOTWORK_PG_scene, footwork_of
from . import paths, rows
from .base import FootworkOperator
from .contacts import edits_of_row
from .job_operator import JobOperator
from .rows import RowOperator


class FOOTWORK_OT_build_database(JobOperator, bpy.types.Operator):
    """Build a motion database from the takes that are ticked, save it and add it to the list below"""

    bl_idname = "footwork.build_database"
    bl_label = "Build Database"
    bl_options = {"REGISTER", "UNDO"}
    title = "Building the database"

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
        if not takes:
            return "Add takes first"
        return (
            ""
            if any(take.use and take.state != "FAULT" for take in takes)
            else "Tick at least one usable take"
        )

    def start(self, context: bpy.types.Context) -> Job[Any]:
        footwork = footwork_of(context.scene)
        self._scene = keep_scene(context.scene)
        self.kept = (self._scene,)
        settings = read_settings(footwork.database_settings, DatabaseSettings)
        if settings.height_low >= settings.height_high:
            raise InputError("the height range is empty: From must be less than To")
        self._path = database_path(footwork, self.filepath)
        used = [take for take in footwork.takes if take.use and take.state != "FAULT"]
        takes = [bpy.path.abspath(take.path) for take in used]
        exclude = [
            parse_exclusion(f"{path}:{text}")
            for path, take in zip(takes, used, strict=True)
            for text in rows.listed(take.leave_out)
        ]
        contact_edits = [edit for take in used for edit in edits_of_row(take)]
        tags = tuple(rows.listed(footwork.database_tags))
        skeleton = bpy.path.abspath(footwork.database_skeleton)
        files = [(path, rows.answers_of(take)) for path, take in zip(takes, used, strict=True)]
        return _build(files, settings, self._path, tags, exclude, contact_edits, skeleton)

    def finish(self, context: bpy.types.Context, result: Any) -> None:
        database, doubts = result
        save_database(self._path, database)
        _show(footwork_of(self._scene.find()), self._path, database)
        for doubt in doubts:
            self.tell("WARNING", doubt)
        minutes = len(database) / database.fps / 60
        self.tell(
            "INFO",
            f"{self._path.name}: {len(database)} frames, {minutes:.1f} min in {len(database.clips)} clips",
        )


def database_path(footwork: FOOTWORK_PG_scene, override: str = "") -> Path:
    """Where the next database is written."""
    return paths.output(override or footwork.database_path, "database")


def _build(files, settings, target, tags, exclude, contact_edits, skeleton):
    if not target.parent.is_dir():
        raise InputError(f"{target.parent}: no such folder; choose another file under Save As")
    takes, doubts = [], []
    for number, (path, answers) in enumerate(files):
        yield 0.5 * number / len(files), f"Reading {Path(path).name}"
        take = rows.read_take(path, answers, settings.fps)
        takes.append(take)
        doubts.extend(f"{take.name}: {doubt}" for doubt in take.doubts)
    doubts.extend(repeated(takes))
    job = build_database(
        takes,
        settings,
        name=target.stem,
        tags=tags,
        exclude=exclude,
        contact_edits=contact_edits,
        skeleton=load_database(skeleton).skeleton if skeleton else None,
    )
    database = yield from part(job, 0.5, 1.0)
    return database, doubts


def _show(footwork: FOOTWORK_PG_scene, path: Path, database: MotionDatabase) -> None:
    """Put a database in the list, over its older version where the file is in it already."""
    known = [row for row in footwork.databases if Path(bpy.path.abspath(row.path)) == path]
    row = known[0] if known else footwork.databases.add()
    row.path, row.name = paths.stored(str(path)), database.name
    row.height_low, row.height_high = database.height_range
    row.state, row.seconds = "OK", len(database) / database.fps
    described = describe_database(database)
    row.found = "\n".join(f"{name}\t{value}" for name, value in _lines(described))
    row.doubts = ""
    footwork.database_index = list(footwork.databases).index(row)


def _lines(described: dict) -> list[tuple[str, str]]:
    """The few facts of a database that the panel shows."""
    coverage, mirrored = described["coverage"], sum(clip["mirrored"] for clip in described["clips"])
    shares = [f"{name} {share:.0%}" for name, share in coverage["direction_shares"].items()]
    speed, turning = coverage["speed_m_s"], coverage["turn_deg_s"]
    low, high = described["suggested_height_range"]
    skate = described["feet"]["foot_skate_cm_s"]
    return [
        ("clips", f"{len(described['clips'])}" + (f", {mirrored} of them mirrored" if mirrored else "")),
        ("standing", f"{coverage['standing_share']:.0%} of the time"),
        ("walking", ", ".join(shares)),
        ("speed", f"median {speed['median']:.1f}, up to {speed['max']:.1f} m/s"),
        ("turning", f"{turning['p5']:.0f} to {turning['p95']:.0f} °/s"),
        *(
            [("body height", f"{described['body_height']:g} of standing")]
            if described["body_height"] != 1.0
            else []
        ),
        ("headset height", f"{low:.2f} to {high:.2f} of standing"),
        ("foot skate", "no contacts" if skate is None else f"{skate:.1f} cm/s"),
    ]


class FOOTWORK_OT_add_database(FootworkOperator, ImportHelper, bpy.types.Operator):
    """Add motion databases that were built before"""

    bl_idname = "footwork.add_database"
    bl_label = "Add Database"
    bl_options = {"REGISTER", "UNDO"}

    directory: StringProperty(subtype="DIR_PATH", options={"SKIP_SAVE", "HIDDEN"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"SKIP_SAVE", "HIDDEN"})
    filter_glob: StringProperty(default="*.npz", options={"HIDDEN"})
    filename_ext = ".npz"

    def work(self, context: bpy.types.Context) -> None:
        loaded = [(Path(path), load_database(path)) for path in paths.chosen(self)]
        for path, database in loaded:
            _show(footwork_of(context.scene), path, database)


class FOOTWORK_OT_remove_database(RowOperator, bpy.types.Operator):
    """Take the selected database off the list; its file stays"""

    bl_idname = "footwork.remove_database"
    bl_label = "Remove Database"
    bl_options = {"REGISTER", "UNDO"}
    what = "database"

    def work(self, context: bpy.types.Context) -> None:
        self.remove(context)


class FOOTWORK_OT_move_database(RowOperator, bpy.types.Operator):
    """Move the selected database in the list: where height ranges overlap, the upper one is used"""

    bl_idname = "footwork.move_database"
    bl_label = "Move Database"
    bl_options = {"REGISTER", "UNDO"}
    what = "database"

    step: IntProperty(name="Step", description="Rows to move down by", default=1)

    def work(self, context: bpy.types.Context) -> None:
        self.move(context, self.step)


CLASSES = (
    FOOTWORK_OT_build_database,
    FOOTWORK_OT_add_database,
    FOOTWORK_OT_remove_database,
    FOOTWORK_OT_move_database,
)

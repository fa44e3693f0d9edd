"""The bake: recording, databases, predictor and rig become an action."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import bpy

from ..bridge import armature
from ..bridge.action import check_writable, scene_fps, write_action
from ..bridge.fewer_keys import thin_out
from ..bridge.ground import chosen_ground
from ..bridge.layers import check_layer, layer
from ..bridge.load import editable
from ..bridge.lookup import Kept, in_view, keep_object, keep_scene, leave_edit_mode, metres_per_unit
from ..bridge.mannequin import create_mannequin
from ..bridge.objects import recording_from_objects
from ..bridge.places import place_of_object, place_of_rig
from ..bridge.proof import prove
from ..bridge.settings import read_settings, typed
from ..bridge.travel import carry_on_root, check_travel, without_way
from ..core import pipeline
from ..core.database.sidecar import load_database
from ..core.errors import InputError
from ..core.jobs import Job, part
from ..core.json_text import to_json
from ..core.recording.cut import cut
from ..core.recording.read import read_recording
from ..core.recording.reading.answers import Answers
from ..core.recording.recording import Recording
from ..core.rig.ground import Ground
from ..core.rig.place import Place
from ..core.rig.rig import Rig
from ..core.settings import BakeSettings
from ..nn import predictor
from ..nn.motion.starter import starter_databases
from ..properties.scene import footwork_of
from . import figures
from .job_operator import JobOperator
from .recording import calibrated, read_answers, wanted_part

REPORT = "Footwork Report"
"""Text data-block that holds the last bake's report as JSON."""


@dataclass(frozen=True, slots=True)
class Source:
    """Everything that a bake reads, as plain data."""

    recording: Recording | str
    """Sampled scene objects, or a file still to be read."""
    answers: Answers
    part: tuple[float, float]
    """Start and stop in seconds of a file's part."""
    databases: tuple[tuple[str, tuple[float, float]], ...]
    """Path and height range of each; none for the starter motion."""
    predictor: str
    """"SHIPPED", "HEADSET" or a path."""
    rig: Rig | None
    ground: Ground | None
    """As it is at the current frame; None for the recording's floor."""
    settings: BakeSettings
    fps: float
    place: Place | None
    """Where the recording is to start; None for its own world."""


class BakeOperator(JobOperator):
    """Mixin for operators that bake: what becomes of the result."""

    title = "Baking"
    _scene: Kept
    _rig: Kept | None = None
    _name = ""
    """Of the action; empty for the recording's."""

    def finish(self, context: bpy.types.Context, result: Any) -> None:
        scene = self._scene.find()
        footwork, unit = footwork_of(scene), metres_per_unit(scene)
        if self._rig is None:
            collection = context.collection if context.scene == scene else scene.collection
            create = create_mannequin if footwork.mannequin else armature.create_armature
            rig = create(result.rig, "Avatar", collection, unit)
            footwork.rig = rig
        else:
            footwork.rig = rig = editable(self._rig.find(), scene)
        result = without_way(result, footwork.travel)
        name = self._name or Path(result.report["inputs"][0]["name"]).stem or "Footwork"
        action = write_action(
            rig,
            result.tracks,
            name,
            fps=scene_fps(scene),
            frame_start=footwork.frame_start,
            marker_times=[float(time) for time in result.transition_times] if footwork.markers else [],
            keep_previous=footwork.keep_previous,
        )
        frames = len(result.tracks.rotations)
        if footwork.fit_range:
            scene.frame_start = footwork.frame_start
            scene.frame_end = footwork.frame_start + max(frames - 1, 1)
        if footwork.travel == "root":
            carry_on_root(rig, scene, result, footwork.frame_start)
        prove(rig, scene, result, footwork.frame_start)
        thin_out(rig, result, footwork.frame_start, typed(footwork.fewer_keys))
        action = layer(rig, footwork.write, footwork.blend)
        figures.show(footwork, result.report, f"{action.name} on {rig.name}", scene_fps(scene))
        text = bpy.data.texts.get(REPORT) or bpy.data.texts.new(REPORT)
        text.from_string(to_json(result.report, indent=2))
        for warning in result.report["warnings"]:
            self.tell("WARNING", warning)
        self.tell("INFO", f"{action.name}: {frames} frames on {rig.name}. {figures.in_short(result.report)}")


class FOOTWORK_OT_bake(BakeOperator, bpy.types.Operator):
    """Bake the recording to a new action of the rig; what the rig was animated with before is kept"""

    bl_idname = "footwork.bake"
    bl_label = "Bake"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def refusal(cls, context: bpy.types.Context) -> str:
        footwork = footwork_of(context.scene)
        if footwork.recording_source == "FILE" and not footwork.recording_path:
            return "Choose a recording first"
        if footwork.recording_source == "OBJECTS" and footwork.head is None:
            return "Pick the object that moves with the headset first"
        if footwork.predictor == "FILE" and not footwork.predictor_path:
            return "Choose a predictor file, or use the built-in one"
        return ""

    def start(self, context: bpy.types.Context) -> Job[Any]:
        scene = context.scene
        footwork = footwork_of(scene)
        rig = footwork.rig
        if rig is not None:
            if rig.library is None:
                check_writable(rig)
            if rig.name not in scene.objects:
                raise InputError(f"{rig.name}: it is not in this scene; pick another rig")
            for doubt in armature.rig_doubts(rig):
                self.tell("WARNING", f"{rig.name}: {doubt}")
        check_layer(rig, footwork.write)
        check_travel(rig, footwork.travel)
        self._scene, self._rig = keep_scene(scene), None if rig is None else keep_object(rig)
        self.kept = (self._scene,) if self._rig is None else (self._scene, self._rig)
        self._name = footwork.action_name
        return bake_job(read_source(scene))


def read_source(scene: bpy.types.Scene) -> Source:
    """All inputs of a bake; objects of the scene are sampled here."""
    footwork = footwork_of(scene)
    for row in footwork.databases:
        if row.use and row.height_low >= row.height_high:
            raise InputError(f"{row.name}: its height range is empty; From must be less than To")
    if footwork.recording_source == "OBJECTS":
        recording: Recording | str = recording_from_objects(
            scene,
            (footwork.head, footwork.left, footwork.right),
            axes=footwork.tracker_axes,
            answers=Answers(
                swap_hands=footwork.reading.swap_hands,
                eye_height=calibrated(footwork),
                force=footwork.reading.force,
            ),
        )
    else:
        recording = bpy.path.abspath(footwork.recording_path)
    unit = metres_per_unit(scene)
    rig = None
    if footwork.rig is not None:
        leave_edit_mode(footwork.rig)
        with in_view(footwork.rig, scene):
            rig = armature.armature_to_rig(footwork.rig, unit)
    ground = chosen_ground(scene, (footwork.ground, footwork.ground_collection), footwork.rig, unit)
    path = bpy.path.abspath(footwork.predictor_path)
    return Source(
        recording=recording,
        answers=read_answers(footwork),
        part=wanted_part(footwork),
        databases=tuple(
            (bpy.path.abspath(row.path), (typed(row.height_low), typed(row.height_high)))
            for row in footwork.databases
            if row.use
        ),
        predictor=path if footwork.predictor == "FILE" else footwork.predictor,
        rig=rig,
        ground=ground,
        settings=read_settings(footwork.bake, BakeSettings),
        fps=scene_fps(scene),
        place=_place(scene),
    )


def _place(scene: bpy.types.Scene) -> Place | None:
    footwork, unit = footwork_of(scene), metres_per_unit(scene)
    if footwork.place == "MARKER":
        if footwork.place_marker is None:
            raise InputError("Place: pick the object at which the bake is to start")
        return place_of_object(footwork.place_marker, unit)
    if footwork.place == "RIG" and footwork.rig is not None:
        with in_view(footwork.rig, scene):
            return place_of_rig(footwork.rig, unit)
    return None


def bake_job(source: Source) -> Job[Any]:
    """The bake of everything that was read."""
    yield 0.0, "Reading the recording"
    recording = source.recording
    if isinstance(recording, str):
        recording = cut(read_recording(recording, source.answers), *source.part)
    databases: list[Any] = []
    notes: list[str] = []
    if not source.databases:
        # the first time they take as long as a short bake
        _, databases, notes = yield from part(starter_databases(), 0.01, 0.4)
    for path, height_range in source.databases:
        yield 0.02, f"Reading {Path(path).name}"
        databases.append(replace(load_database(path), height_range=height_range))
    job = pipeline.bake(
        recording,
        databases,
        _predict(source.predictor),
        source.rig,
        source.settings,
        output_fps=source.fps,
        ground=source.ground,
        place=source.place,
    )
    result = yield from part(job, 0.05 if source.databases else 0.4, 1.0)
    result.report["warnings"] += notes
    return result


def _predict(chosen: str):
    if chosen == "HEADSET":
        return predictor.headset_forward
    made = predictor.shipped_predictor() if chosen == "SHIPPED" else predictor.load_predictor(chosen)
    return lambda recording: predictor.predict(made, recording)


CLASSES = (FOOTWORK_OT_bake,)

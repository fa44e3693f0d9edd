"""Try It: from an empty scene to an avatar that moves, with nothing at hand."""

from typing import Any

import bpy
from bpy.props import BoolProperty
from mathutils import Vector

from ..bridge.action import scene_fps
from ..bridge.layers import check_layer
from ..bridge.lookup import keep_scene
from ..bridge.places import free_place
from ..bridge.travel import check_travel
from ..core.jobs import Job, part
from ..core.recording.reading.answers import Answers
from ..core.settings import BakeSettings
from ..nn.motion.example import example_file
from ..properties.scene import footwork_of
from .bake import BakeOperator, Source, bake_job
from .recording import use_recording

_ABOVE, _AWAY = 0.9, 7.5
"""Metres over the floor that the view turns about, and from there to the eye."""


class FOOTWORK_OT_try_it(BakeOperator, bpy.types.Operator):
    """Bake an example recording on a new mannequin with the starter motion, and play it"""

    bl_idname = "footwork.try_it"
    bl_label = "Try It"
    bl_options = {"REGISTER", "UNDO"}

    play: BoolProperty(name="Play", description="Look at the mannequin and play its action", default=True)

    def start(self, context: bpy.types.Context) -> Job[Any]:
        self._scene = keep_scene(context.scene)
        self.kept = (self._scene,)
        footwork = footwork_of(context.scene)
        check_layer(None, footwork.write)
        check_travel(None, footwork.travel)
        place, rate = free_place(context.scene), scene_fps(context.scene)
        return self._made(place, rate)

    def finish(self, context: bpy.types.Context, result: Any) -> None:
        path, baked = result
        footwork = footwork_of(self._scene.find())
        footwork.rig = None
        use_recording(self, footwork, path)
        super().finish(context, baked)
        if self.play and not bpy.app.background and context.scene == self._scene.find():
            _look_at(context, baked.motion.positions)
            _play(context)

    def _made(self, place: Any, rate: float) -> Job[Any]:
        path = yield from part(example_file(), 0.0, 0.02)
        source = Source(
            recording=str(path),
            answers=Answers(),
            part=(0.0, float("inf")),
            databases=(),
            predictor="SHIPPED",
            rig=None,
            ground=None,
            settings=BakeSettings(),
            fps=rate,
            place=place,
        )
        baked = yield from part(bake_job(source), 0.02, 1.0)
        return str(path), baked


def _look_at(context: bpy.types.Context, places: Any) -> None:
    """Turn 3D views to where the avatar will be; `places` `(T, 3)` of its hips, metres."""
    middle = 0.5 * (places.min(axis=0) + places.max(axis=0))
    for area in context.screen.areas if context.screen else ():
        if area.type == "VIEW_3D":
            space: Any = area.spaces.active
            view = space.region_3d
            if view.view_perspective == "CAMERA":
                view.view_perspective = "PERSP"
            view.view_location = Vector((middle[0], middle[1], _ABOVE))
            # from the front, a little from the side and above
            view.view_rotation = Vector((-0.35, 1.0, -0.22)).to_track_quat("-Z", "Y")
            view.view_distance = _AWAY


def _play(context: bpy.types.Context) -> None:
    context.scene.frame_set(context.scene.frame_start)
    if context.screen is not None and not context.screen.is_animation_playing:
        bpy.ops.screen.animation_play()


CLASSES = (FOOTWORK_OT_try_it,)

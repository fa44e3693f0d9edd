"""Scenes whose unit is no metre: what is read, shown and baked stays metres."""

from __future__ import annotations

import json

import bpy
import helpers
import numpy as np
import pytest
from footwork.bridge import armature, objects
from footwork.core.mocap.bvh import write_bvh
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.export import to_bvh
from footwork.core.mocap.takes import load_take
from footwork.core.recording.read import read_recording
from footwork.core.recording.reading.answers import Answers
from footwork.core.recording.resample import resample
from footwork.core.recording.simulate import simulate_recording
from footwork.core.recording.targets import joint_targets
from footwork.operators.bake import REPORT

UNITS = [("METRIC", 0.01), ("METRIC", 3.0), ("IMPERIAL", 0.3048), ("NONE", 0.01)]
"""System and scale length; without a system a unit is a metre whatever the length says."""


def metres(system: str, length: float) -> float:
    return 1.0 if system == "NONE" else length


@pytest.fixture(params=UNITS, ids=lambda unit: f"{unit[0].lower()} {unit[1]:g}")
def unit(empty, request: pytest.FixtureRequest) -> float:
    """The scene is in another unit: how many metres one is."""
    empty.unit_settings.system, empty.unit_settings.scale_length = request.param
    return metres(*request.param)


@pytest.fixture(scope="module")
def truth(tumble) -> tuple[np.ndarray, np.ndarray]:
    """Positions `(T, 3, 3)` in metres and rotations `(T, 3, 4)` of three devices, each on a way of its own."""
    time = np.arange(90)[:, None, None] / 60.0
    centre = np.array([[0.4, -0.6, 1.63], [0.1, -0.3, 1.1], [0.8, -0.2, 0.9]])
    rate = np.array([[1.1, 0.7, 0.9], [1.7, 2.1, 1.3], [0.8, 1.9, 2.3]])
    return centre + 0.13 * np.sin(rate * time + rate), tumble(90, 60.0, count=3, seed=6)


def keyed(scene: bpy.types.Scene, name: str, places: np.ndarray, turns: np.ndarray) -> bpy.types.Object:
    """An empty keyed by Blender's own means, in scene units."""
    obj = bpy.data.objects.new(name, None)
    scene.collection.objects.link(obj)
    obj.rotation_mode = "QUATERNION"
    for frame, (place, turn) in enumerate(zip(places, turns, strict=True)):
        obj.location, obj.rotation_quaternion = place, turn
        obj.keyframe_insert("location", frame=frame + 1)
        obj.keyframe_insert("rotation_quaternion", frame=frame + 1)
    return obj


def same_turns(a: np.ndarray, b: np.ndarray) -> bool:
    return bool(np.abs(np.sum(a * b, axis=-1)).min() > 1.0 - 1e-6)


TOLD = Answers(eye_height=1.7, force=True)
"""The trackers here are of no person."""


def test_objects_are_sampled_in_metres(empty, unit: float, truth) -> None:
    places, turns = truth
    trackers = [keyed(empty, str(i), places[:, i] / unit, turns[:, i]) for i in range(3)]
    empty.frame_end = len(places)
    found = objects.recording_from_objects(empty, trackers, answers=TOLD)
    np.testing.assert_allclose(found.positions, places, atol=1e-4)
    assert same_turns(found.rotations, turns) and found.eye_height == 1.7
    # a controller that is not there does not move the other one to its place
    without = objects.recording_from_objects(empty, (trackers[0], None, trackers[2]), answers=TOLD)
    np.testing.assert_allclose(without.positions[:, [0, 2]], places[:, [0, 2]], atol=1e-4)


def test_a_recording_is_shown_where_it_is_in_metres(empty, unit: float) -> None:
    recording = simulate_recording(demo_motion("turn", 2), "turn")
    shown = objects.show_recording(recording, empty, 11.0)
    wanted = resample(recording, 60.0)
    for frame in (0, 71, 300):
        empty.frame_set(11 + frame)
        for i, obj in enumerate(shown):
            posed = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
            place, turn, _ = posed.matrix_world.decompose()
            np.testing.assert_allclose(np.array(place) * unit, wanted.positions[frame, i], atol=1e-4)
            assert same_turns(np.array(turn), wanted.rotations[frame, i])
            assert obj.empty_display_size * unit == pytest.approx(0.15)
    empty.frame_start, empty.frame_end = 11, 10 + len(wanted)
    back = objects.recording_from_objects(empty, shown)
    np.testing.assert_allclose(back.positions, wanted.positions, atol=1e-4)
    np.testing.assert_allclose(back.mounts.offsets, recording.mounts.offsets, atol=1e-6)
    assert back.eye_height == pytest.approx(recording.eye_height, abs=1e-6)


def test_a_take_is_shown_in_its_size(empty, unit: float, tmp_path) -> None:
    write_bvh(tmp_path / "walk.bvh", to_bvh(demo_motion("walk", height=1.6), "walk"))
    bpy.ops.footwork.import_take(directory=str(tmp_path), files=helpers.files("walk.bvh"))
    motion = load_take(tmp_path / "walk.bvh", 60.0).motion
    for frame in (0, 200):
        empty.frame_set(1 + frame)
        heads = helpers.world_heads(bpy.context.object, motion.skeleton.names) * unit
        np.testing.assert_allclose(heads, motion.forward()[0][frame], atol=1e-4)


@pytest.mark.parametrize("made", [True, False], ids=["rig made", "rig given"])
def test_the_head_of_a_bake_is_at_the_headset(empty, ready, recording, unit: float, made: bool) -> None:
    if not made:
        bpy.ops.footwork.bake()
        # a rig that is an object of another scale, turned and moved
        ready.rig.scale = [1.4 * size for size in ready.rig.scale]
        ready.rig.rotation_euler.z, ready.rig.location = 0.8, (2.0 / unit, -1.0 / unit, 0.0)
        bpy.context.view_layer.update()
    bpy.ops.footwork.bake()
    report = json.loads(bpy.data.texts[REPORT].as_string())
    factor = report["scale"]["user_to_rig"]
    assert (factor > 1.3) != made
    places, _ = joint_targets(resample(read_recording(recording), 60.0))
    head = armature.role_map(ready.rig)["head"]
    for frame in (0, 150, 400):
        empty.frame_set(1 + frame)
        shown = helpers.world_heads(ready.rig, (head,))[0] * unit
        np.testing.assert_allclose(shown, factor * places[frame, 0], atol=2e-3)
    assert report["metrics"]["head_position_error_cm"]["max"] < 0.1

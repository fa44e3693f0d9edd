"""Baked actions, judged by Blender's own evaluation."""

from __future__ import annotations

import time

import bpy
import helpers
import numpy as np
import pytest
from footwork.bridge import action, armature, compat
from footwork.core.errors import InputError
from footwork.core.rig.fit import fit_rig, rig_from_skeleton
from footwork.core.rig.keys import to_bone_tracks
from footwork.core.rig.rig import BoneTracks
from mathutils import Euler, Matrix


def new_rig(scene: bpy.types.Scene, name: str = "Person") -> bpy.types.Object:
    return armature.create_armature(rig_from_skeleton(helpers.skeleton(), name), name, scene.collection)


def assert_shows(obj: bpy.types.Object, scene: bpy.types.Scene, truth, fit, start: int = 1) -> None:
    """Every frame that Blender evaluates is the motion's, to a tenth of a millimetre."""
    expected, _ = truth.forward()
    for frame in range(0, len(truth), 7):
        scene.frame_set(start + frame)
        shown = helpers.world_heads(obj, fit.skeleton.names)
        assert np.abs(shown - expected[frame]).max() < 1e-4


@pytest.mark.parametrize("mode", ["QUATERNION", "XYZ", "ZYX", "YXZ", "AXIS_ANGLE"])
def test_blender_shows_the_motion_in_every_rotation_mode(empty, mode: str) -> None:
    obj = new_rig(empty)
    for bone in obj.pose.bones:
        bone.rotation_mode = mode
    fit = fit_rig(armature.armature_to_rig(obj))
    truth = helpers.motion(fit.skeleton)
    action.write_action(obj, to_bone_tracks(truth, fit, 60.0), "Walk", fps=60.0)
    assert_shows(obj, empty, truth, fit)
    assert {bone.rotation_mode for bone in obj.pose.bones} == {mode}


def test_a_scaled_turned_and_moved_object_stays_as_it_is(empty) -> None:
    obj = new_rig(empty)
    obj.data.transform(Matrix.Scale(100.0, 4))
    placed = Matrix.LocRotScale((0.3, -0.2, 0.0), Euler((np.pi / 2, 0.0, 0.7)), (0.01,) * 3)
    # the armature lies on its back in its own axes, as FBX files have it
    obj.data.transform(Matrix.Rotation(-np.pi / 2, 4, "X"))
    obj.matrix_world = placed
    bpy.context.view_layer.update()
    before = np.array(obj.matrix_world)
    rest = [np.array(bone.matrix_local) for bone in obj.data.bones]
    fit = fit_rig(armature.armature_to_rig(obj))
    truth = helpers.motion(fit.skeleton)
    action.write_action(obj, to_bone_tracks(truth, fit, 60.0), "Walk", fps=60.0)
    assert_shows(obj, empty, truth, fit)
    assert np.array_equal(before, np.array(obj.matrix_world))
    assert all(np.array_equal(old, bone.matrix_local) for old, bone in zip(rest, obj.data.bones, strict=True))


def test_baking_again_keeps_the_first_action_and_shows_the_second(empty) -> None:
    obj = new_rig(empty)
    fit = fit_rig(armature.armature_to_rig(obj))
    first = action.write_action(
        obj, to_bone_tracks(helpers.motion(fit.skeleton), fit, 60.0), "Walk", fps=60.0
    )
    keys = helpers.keys_of(first)
    scene_frame = empty.frame_current
    truth = helpers.motion(fit.skeleton, seed=2)
    second = action.write_action(
        obj, to_bone_tracks(truth, fit, 60.0), "Walk", fps=60.0, frame_start=11, marker_times=[0.5]
    )
    assert first.use_fake_user and helpers.keys_of(first) == keys and first != second
    assert [(marker.name, marker.frame) for marker in second.pose_markers] == [("T", 41)]
    assert empty.frame_current == scene_frame
    assert_shows(obj, empty, truth, fit, start=11)


def test_replacing_removes_only_what_footwork_made(empty) -> None:
    obj = new_rig(empty)
    fit = fit_rig(armature.armature_to_rig(obj))
    tracks = to_bone_tracks(helpers.motion(fit.skeleton, 5), fit, 60.0)
    compat.assign_action(obj, bpy.data.actions.new("By Hand"))
    for _ in range(3):
        action.write_action(obj, tracks, "Bake", fps=60.0, keep_previous=False)
    assert sorted(a.name for a in bpy.data.actions) == ["Bake", "By Hand"]
    assert bpy.data.actions["By Hand"].use_fake_user


def test_another_object_plays_the_action_when_it_is_assigned(empty) -> None:
    one, two = new_rig(empty, "One"), new_rig(empty, "Two")
    fit = fit_rig(armature.armature_to_rig(one))
    truth = helpers.motion(fit.skeleton)
    made = action.write_action(one, to_bone_tracks(truth, fit, 60.0), "Walk", fps=60.0)
    compat.assign_action(two, made)
    assert_shows(two, empty, truth, fit)
    assert len(compat.fcurves_of(two)) == len(compat.fcurves_of(one)) > 0


def test_bones_between_keyed_ones_are_held_at_rest_and_others_left(empty) -> None:
    obj = new_rig(empty)
    fit = fit_rig(armature.armature_to_rig(obj))
    truth = helpers.motion(fit.skeleton)
    tracks = to_bone_tracks(truth, fit, 60.0)
    kept = [i for i, name in enumerate(tracks.bones) if name not in ("Chest", "LeftToe")]
    obj.pose.bones["Chest"].rotation_quaternion = (0.7, 0.7, 0.0, 0.0)
    obj.pose.bones["Chest"].scale = (1.1, 1.2, 1.3)
    obj.pose.bones["LeftToe"].rotation_quaternion = (0.0, 1.0, 0.0, 0.0)
    obj.pose.bones["LeftElbow"].location = (0.0, 0.2, 0.0)
    obj.pose.bones["LeftWrist"].scale = (2.0, 2.0, 2.0)
    subset = BoneTracks(
        tuple(tracks.bones[i] for i in kept), tracks.fps, tracks.locations, tracks.rotations[:, kept]
    )
    action.write_action(obj, subset, "Walk", fps=60.0)
    empty.frame_set(10)
    chest = obj.pose.bones["Chest"]
    assert np.allclose(chest.rotation_quaternion, (1.0, 0.0, 0.0, 0.0)) and np.allclose(chest.location, 0.0)
    assert np.allclose(chest.scale, (1.1, 1.2, 1.3))
    assert np.allclose(obj.pose.bones["LeftWrist"].scale, 2.0)
    assert obj.pose.bones["LeftToe"].rotation_quaternion[1] == pytest.approx(1.0)
    assert np.allclose(obj.pose.bones["LeftElbow"].location, 0.0)
    keys: dict[str, list[int]] = {}
    for curve in compat.fcurves_of(obj):
        keys.setdefault(curve.data_path, []).append(len(curve.keyframe_points))
    assert keys['pose.bones["Chest"].rotation_quaternion'] == [1] * 4
    assert keys['pose.bones["LeftElbow"].location'] == [1] * 3
    assert not any("LeftToe" in path or "scale" in path for path in keys)
    moved = {path.split('"')[1] for path in keys if "location" in path}
    assert moved == {"Hips", "Chest", "LeftElbow"}


def test_constant_channels_take_two_keys(empty) -> None:
    obj = new_rig(empty)
    still = BoneTracks(("Hips",), 60.0, np.zeros((500, 3)), np.tile([1.0, 0, 0, 0], (500, 1, 1)))
    made = action.write_action(obj, still, "Still", fps=60.0)
    assert helpers.keys_of(made) == 2 * 7


def test_keys_fall_on_scene_frames_of_fractional_rates(empty) -> None:
    empty.render.fps, empty.render.fps_base = 30, 1.001
    obj = new_rig(empty)
    fit = fit_rig(armature.armature_to_rig(obj))
    fps = action.scene_fps(empty)
    assert fps == pytest.approx(29.97, abs=1e-2)
    tracks = to_bone_tracks(helpers.motion(fit.skeleton), fit, fps)
    action.write_action(obj, tracks, "Walk", fps=fps)
    frames = np.empty(2 * len(tracks.rotations))
    curve = compat.fcurves_of(obj)[0]
    curve.keyframe_points.foreach_get("co", frames)
    assert np.allclose(frames[::2], np.arange(1, 1 + len(tracks.rotations)))


def test_missing_bones_and_tweaked_strips_are_refused_before_anything_is_made(empty) -> None:
    obj = new_rig(empty)
    ghost = BoneTracks(("Nobody",), 60.0, np.zeros((2, 3)), np.tile([1.0, 0, 0, 0], (2, 1, 1)))
    with pytest.raises(InputError, match="Nobody"):
        action.write_action(obj, ghost, "Ghost", fps=60.0)
    assert not bpy.data.actions


@pytest.mark.skipif(bpy.app.version < (4, 2, 0), reason="needs overrides")
def test_a_linked_rig_is_refused_and_its_override_is_baked(empty, tmp_path) -> None:
    obj = new_rig(empty, "Hero")
    path = str(tmp_path / "hero.blend")
    bpy.data.libraries.write(path, {obj})
    bpy.ops.wm.read_homefile(use_empty=True)
    with bpy.data.libraries.load(path, link=True) as (there, here):
        here.objects = there.objects
    linked = bpy.data.objects["Hero"]
    scene = bpy.context.scene
    scene.collection.objects.link(linked)
    bpy.context.view_layer.update()
    fit = fit_rig(armature.armature_to_rig(linked))
    truth = helpers.motion(fit.skeleton)
    tracks = to_bone_tracks(truth, fit, 60.0)
    with pytest.raises(InputError, match="library override"):
        action.write_action(linked, tracks, "Walk", fps=60.0)
    assert not bpy.data.actions
    own = linked.override_create(remap_local_usages=True)
    action.write_action(own, tracks, "Walk", fps=60.0)
    bpy.context.view_layer.update()
    assert_shows(own, scene, truth, fit)
    assert own.override_library is not None and own.data.library is not None


def test_five_minutes_are_written_in_a_second(empty) -> None:
    obj = new_rig(empty)
    fit = fit_rig(armature.armature_to_rig(obj))
    tracks = to_bone_tracks(helpers.motion(fit.skeleton, 18000), fit, 60.0)
    began = time.perf_counter()
    made = action.write_action(obj, tracks, "Long", fps=60.0)
    print(f"\n{helpers.keys_of(made)} keys in {time.perf_counter() - began:.2f} s")
    assert helpers.keys_of(made) > 1_500_000

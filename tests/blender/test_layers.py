"""A bake beside the animation that a rig has, and at a place of the scene."""

from __future__ import annotations

from typing import Any

import bpy
import helpers
import numpy as np
import pytest
from footwork.bridge import compat
from footwork.bridge.layers import weights
from test_before import looks, whole
from test_control_rigs import control_rig, plain_rig

FIRST, LAST = 31, 151
"""Two seconds from frame 31 on."""


@pytest.fixture
def animated(empty, ready) -> bpy.types.Object:
    """A rig in Euler angles and quaternions with an action of its own over frames 1 to 300."""
    obj = plain_rig(empty)
    obj.pose.bones["Neck"].rotation_mode, obj.pose.bones["LeftHip"].rotation_mode = "ZXY", "AXIS_ANGLE"
    random = np.random.default_rng(5)
    for name in ("Hips", "Chest", "LeftElbow"):
        bone = obj.pose.bones[name]
        for frame in (1, 20, 44, 100, 170, 300):
            bone.rotation_quaternion = [1.0, *random.uniform(-0.5, 0.5, 3)]
            bone.keyframe_insert("rotation_quaternion", frame=frame)
    for frame in (25, 160):
        obj.pose.bones["Hips"].location = random.uniform(-1.0, 1.0, 3)
        obj.pose.bones["Hips"].keyframe_insert("location", frame=frame)
    obj.pose.bones["Neck"].rotation_euler = (0.2, 6.5, -0.1)
    obj.pose.bones["RightHip"].rotation_quaternion = (0.9, 0.3, 0.0, 0.1)
    obj.animation_data.action.name = "By Hand"
    ready.rig, ready.recording_to, ready.frame_start = obj, 2.0, FIRST
    empty.frame_set(1)
    return obj


def shown(obj: bpy.types.Object, scene: bpy.types.Scene, frames: Any) -> np.ndarray:
    """Evaluated matrices `(N, B, 4, 4)`."""
    out = []
    for frame in frames:
        scene.frame_set(frame)
        evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
        out.append([np.array(bone.matrix) for bone in evaluated.pose.bones])
    return np.array(out)


OUTSIDE = (1, 10, 21, 27, 30, 152, 155, 163, 171, 250, 300)
INSIDE = (51, 80, 101, 131)


@pytest.mark.parametrize("how", ["RANGE", "STRIP"])
@pytest.mark.parametrize("blend", [0, 15])
def test_the_bake_shows_inside_and_the_older_animation_outside(empty, ready, animated, how, blend) -> None:
    before = shown(animated, empty, OUTSIDE)
    fading = shown(animated, empty, (FIRST, LAST))
    empty.frame_set(1)
    text = whole(animated)
    assert bpy.ops.footwork.bake() == {"FINISHED"}
    baked = shown(animated, empty, INSIDE)
    empty.frame_set(1)
    assert bpy.ops.footwork.clear_bake() == {"FINISHED"}
    assert whole(animated) == text
    ready.write, ready.blend = how, blend
    assert bpy.ops.footwork.bake() == {"FINISHED"}
    np.testing.assert_allclose(shown(animated, empty, OUTSIDE), before, atol=2e-4)
    np.testing.assert_allclose(shown(animated, empty, INSIDE), baked, atol=2e-4)
    if blend:
        np.testing.assert_allclose(shown(animated, empty, (FIRST, LAST)), fading, atol=2e-4)
        # from one to the other without a jump
        way = shown(animated, empty, range(FIRST - 5, FIRST + 25))[:, :, :3, :3]
        assert np.abs(np.diff(way, axis=0)).max() < 0.5
    if how == "RANGE":
        assert animated.animation_data.action.name == "visit" and len(animated.animation_data.nla_tracks) == 0
    else:
        tracks = animated.animation_data.nla_tracks
        assert [track.name for track in tracks] == [
            "visit base",
            "By Hand",
            "visit",
        ] and animated.animation_data.action is None
    empty.frame_set(1)
    assert bpy.ops.footwork.clear_bake() == {"FINISHED"}
    assert whole(animated) == text


def test_switches_hold_in_a_range_alone(empty, ready) -> None:
    obj = control_rig(empty)
    obj.pose.bones["LeftAnkle_ik"].keyframe_insert("location", frame=1)
    obj.pose.bones["LeftHip"].keyframe_insert('["IK_FK"]', frame=1)
    before = looks(obj, empty)[0]
    ready.rig, ready.recording_to, ready.frame_start, ready.write = obj, 2.0, FIRST, "RANGE"
    assert bpy.ops.footwork.bake() == {"FINISHED"}
    values = []
    for frame in (1, FIRST - 1, FIRST, LAST, LAST + 1, 300):
        empty.frame_set(frame)
        values.append(obj.pose.bones["LeftHip"]["IK_FK"])
    assert values == [0.0, 0.0, 1.0, 1.0, 0.0, 0.0]
    np.testing.assert_allclose(looks(obj, empty)[0], before, atol=1e-4)


def test_without_an_action_there_is_no_range(empty, ready) -> None:
    ready.rig, ready.write = plain_rig(empty), "RANGE"
    with pytest.raises(RuntimeError, match="no action to write a range into"):
        bpy.ops.footwork.bake()


def test_the_share_goes_up_and_down() -> None:
    share = weights(20, 5)
    assert share[0] == share[-1] == 0.0 and (share[5:15] == 1.0).all() and (np.diff(share[:6]) > 0.0).all()
    assert (weights(20, 0) == 1.0).all() and weights(3, 50).max() == 1.0


def faces(obj: bpy.types.Object) -> float:
    """The way that a body's hips face, radians from +Y."""
    left, right = helpers.world_heads(obj, ("LeftHip", "RightHip"))
    across = right - left
    return float(np.arctan2(across[1], across[0]))


def test_a_bake_starts_at_a_marker(empty, ready) -> None:
    marker = bpy.data.objects.new("Mark", None)
    empty.collection.objects.link(marker)
    marker.location, marker.rotation_euler = (3.0, -2.0, 1.5), (0.3, 0.0, 2.0)
    obj = plain_rig(empty)
    obj.location, obj.rotation_euler = (-5.0, 4.0, 0.0), (0.0, 0.0, 1.0)
    bpy.context.view_layer.update()
    ready.rig, ready.recording_to = obj, 2.0
    assert bpy.ops.footwork.bake() == {"FINISHED"}
    empty.frame_set(1)
    low = helpers.world_heads(obj, ("LeftToe", "RightToe"))[:, 2].min()
    ready.place, ready.place_marker = "MARKER", marker
    assert bpy.ops.footwork.bake() == {"FINISHED"}
    empty.frame_set(1)
    head, left, right = helpers.world_heads(obj, ("Head", "LeftToe", "RightToe"))
    assert head[:2] == pytest.approx((3.0, -2.0), abs=0.01)
    assert min(left[2], right[2]) == pytest.approx(1.5 + low, abs=0.02)
    ahead = np.array(marker.matrix_world)[:2, 1]
    off = faces(obj) - np.arctan2(-ahead[0], ahead[1])
    assert abs((off + np.pi) % (2.0 * np.pi) - np.pi) < 0.5


@pytest.mark.parametrize("by", ["object", "bone"])
def test_a_bake_starts_where_the_rig_stands_and_faces(empty, ready, by: str) -> None:
    obj = control_rig(empty)
    if by == "object":
        obj.location, obj.rotation_euler = (-5.0, 4.0, 0.0), (0.0, 0.0, 1.0)
    else:
        root = obj.pose.bones["root"]
        root.location, root.rotation_quaternion = (2.0, 0.0, 1.0), (0.8, 0.0, 0.0, 0.6)
    bpy.context.view_layer.update()
    rest = helpers.world_heads(obj, ("Hips",))[0]
    facing = faces(obj)
    ready.rig, ready.recording_to, ready.place = obj, 2.0, "RIG"
    assert bpy.ops.footwork.bake() == {"FINISHED"}
    assert "meant to be" not in ready.warnings
    empty.frame_set(1)
    head = helpers.world_heads(obj, ("Head",))[0]
    assert np.linalg.norm(head[:2] - rest[:2]) < 0.1
    assert abs((faces(obj) - facing + np.pi) % (2.0 * np.pi) - np.pi) < 0.5
    assert compat.fcurves_of(obj)


def test_the_command_line_puts_and_layers_a_bake(database, recording, tmp_path) -> None:
    from footwork.cli import main

    bpy.ops.wm.read_homefile(use_empty=True)
    scene = bpy.context.scene
    scene.render.fps = 60
    obj = plain_rig(scene)
    obj.pose.bones["Head"].keyframe_insert("rotation_quaternion", frame=1)
    obj.animation_data.action.name = "By Hand"
    mark = bpy.data.objects.new("Mark", None)
    mark.location = (2.0, 1.0, 0.0)
    scene.collection.objects.link(mark)
    rig, out = str(tmp_path / "rig.blend"), str(tmp_path / "out.blend")
    bpy.ops.wm.save_as_mainfile(filepath=rig)
    words = ["bake", str(recording), "--database", str(database), "--to", "1", "--rig", rig, "-o", out]
    assert main([*words, "--at", "Nobody"]) == 2
    glb = tmp_path / "out.glb"
    assert main([*words, "--at", "Mark", "--layer", "strip", "--blend", "5", "--export", str(glb)]) == 0
    assert glb.stat().st_size > 10000
    bpy.ops.wm.open_mainfile(filepath=out)
    obj = bpy.data.objects["Plain"]
    (strip,) = obj.animation_data.nla_tracks[-1].strips
    assert (strip.name, strip.blend_in, strip.blend_out) == ("visit", 5.0, 5.0)
    bpy.context.scene.frame_set(10)
    assert np.linalg.norm(helpers.world_heads(obj, ("Head",))[0, :2] - (2.0, 1.0)) < 0.3

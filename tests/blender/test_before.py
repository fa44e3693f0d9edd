"""Nothing of a bake is left over: older actions look as before, and Clear Bake gives everything back."""

from __future__ import annotations

import json
import random
from typing import Any

import bpy
import numpy as np
import pytest
from footwork.bridge import before, compat
from test_control_rigs import control_rig, plain_rig, unsettle


def posed(scene: bpy.types.Scene, make: Any = control_rig) -> bpy.types.Object:
    """A rig in a pose, with scales, an action of its own that keys one arm, and muted strips."""
    obj = make(scene)
    unsettle(obj, 7)
    rnd = random.Random(2)
    for bone in obj.pose.bones:
        if bone.name.startswith(("Left", "Head")):
            bone.scale = [rnd.uniform(0.9, 1.1) for _ in range(3)]
    elbow = obj.pose.bones["LeftElbow"]
    for frame, turn in ((1, (1.0, 0.0, 0.0, 0.0)), (40, (0.8, 0.6, 0.0, 0.0))):
        elbow.rotation_quaternion = turn
        elbow.keyframe_insert("rotation_quaternion", frame=frame)
    data = obj.animation_data
    data.action.name = "By Hand"
    data.nla_tracks.new().strips.new("old", 1, bpy.data.actions["By Hand"].copy())
    data.nla_tracks[0].mute = True
    data.action_influence = 0.75
    scene.frame_set(12)
    return obj


def whole(obj: bpy.types.Object) -> str:
    """Everything of the object that can be read, as text."""
    data = obj.animation_data
    bones = {
        bone.name: [
            [
                tuple(bone.location),
                tuple(bone.rotation_quaternion),
                tuple(bone.rotation_euler),
                tuple(bone.scale),
            ],
            tuple(bone.rotation_axis_angle),
            {prop: bone[prop] for prop in ("IK_FK", "neck_follow") if prop in bone},
        ]
        for bone in obj.pose.bones
    }
    curves = [
        (c.data_path, c.array_index, [tuple(k.co) for k in c.keyframe_points]) for c in compat.fcurves_of(obj)
    ]
    played = data and (
        data.action and (data.action.name, data.action.use_fake_user),
        compat.slot_of(obj),
        (data.action_influence, data.action_blend_type, data.action_extrapolation),
        [(t.name, t.mute, t.is_solo, [s.name for s in t.strips]) for t in data.nla_tracks],
    )
    return json.dumps([bones, curves, played, sorted(a.name for a in bpy.data.actions)])


def looks(obj: bpy.types.Object, scene: bpy.types.Scene) -> np.ndarray:
    """Evaluated matrices of all bones in some frames."""
    out = []
    for frame in (1, 20, 40):
        scene.frame_set(frame)
        shown = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
        out.append([np.array(bone.matrix) for bone in shown.pose.bones])
    return np.array(out)


def bake(scene: bpy.types.Scene, obj: bpy.types.Object) -> None:
    scene.footwork.rig, scene.footwork.recording_to = obj, 2.0
    assert bpy.ops.footwork.bake() == {"FINISHED"}


def test_clear_bake_gives_everything_back(empty, ready) -> None:
    obj = posed(empty)
    first = whole(obj)
    bake(empty, obj)
    second = whole(obj)
    bake(empty, obj)
    assert len({first, second, whole(obj)}) == 3
    assert bpy.ops.footwork.clear_bake() == {"FINISHED"}
    assert obj.animation_data.action.get(before.BEFORE)
    assert bpy.ops.footwork.clear_bake() == {"FINISHED"}
    assert whole(obj) == first
    assert not bpy.ops.footwork.clear_bake.poll()


def test_a_bake_in_place_of_another_is_cleared_to_what_was_before_both(empty, ready) -> None:
    obj = posed(empty)
    first = whole(obj)
    ready.keep_previous = False
    for _ in range(3):
        bake(empty, obj)
    assert bpy.ops.footwork.clear_bake() == {"FINISHED"}
    assert whole(obj) == first


def test_a_rig_without_animation_has_none_again(empty, ready) -> None:
    obj = plain_rig(empty)
    first = whole(obj)
    bake(empty, obj)
    assert bpy.ops.footwork.clear_bake() == {"FINISHED"}
    assert whole(obj) == first and obj.animation_data is None


@pytest.mark.parametrize("how", ["update", "frame"])
def test_an_older_action_looks_as_before(empty, ready, how: str) -> None:
    obj = posed(empty)
    own = obj.animation_data.action
    obj.animation_data.action_influence = 1.0
    expected = looks(obj, empty)
    bake(empty, obj)
    made = obj.animation_data.action
    baked = looks(obj, empty)
    assert np.abs(baked - expected).max() > 0.1
    compat.assign_action(obj, own)
    if how == "update":
        bpy.context.view_layer.update()
    np.testing.assert_allclose(looks(obj, empty), expected, atol=1e-5)
    # and the bake as it was, when that is assigned again
    compat.assign_action(obj, made)
    np.testing.assert_allclose(looks(obj, empty), baked, atol=1e-5)
    # what is posed by hand since stays
    compat.assign_action(obj, own)
    looks(obj, empty)
    obj.pose.bones["Head"].rotation_quaternion = (0.6, 0.8, 0.0, 0.0)
    looks(obj, empty)
    assert obj.pose.bones["Head"].rotation_quaternion[1] == pytest.approx(0.8)


def test_older_actions_in_a_file_from_the_command_line_look_as_before(empty, ready, tmp_path) -> None:
    from footwork.bridge.targets import open_target
    from footwork.core.jobs import run
    from footwork.core.transaction import Transaction
    from footwork.operators.bake import bake_job, read_source

    obj = posed(empty)
    obj.animation_data.action_influence = 1.0
    empty.footwork.rig, empty.footwork.recording_to = obj, 2.0
    result = run(bake_job(read_source(empty)))
    rig, out = str(tmp_path / "rig.blend"), str(tmp_path / "out.blend")
    expected, pose = looks(obj, empty), before.state_of(obj)["pose"]
    bpy.ops.wm.save_as_mainfile(filepath=rig)
    target = open_target(rig, 60.0)
    target.write(result, "Take")
    with Transaction() as outputs:
        target.save([out], outputs)
    bpy.ops.wm.open_mainfile(filepath=out)
    obj = bpy.data.objects["Controls"]
    assert obj.animation_data.action.name == "Take"
    compat.assign_action(obj, bpy.data.actions["By Hand"])
    np.testing.assert_allclose(looks(obj, bpy.context.scene), expected, atol=1e-5)
    found = before.state_of(obj)["pose"]
    assert all(found[bone] == pytest.approx(pose[bone], abs=1e-6) for bone in pose)

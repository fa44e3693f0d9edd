"""A bake is where it was meant to be as Blender shows it, or a line says which bone is not and why.

Where it was meant to be is told by the same bake onto a plain copy of the rig.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import bpy
import helpers
import numpy as np
import pytest
from footwork.bridge import armature
from footwork.bridge.action import scene_fps
from footwork.core.rig.fit import rig_from_skeleton
from footwork.operators.bake import REPORT
from mathutils import Euler

BONES = ("Hips", "Head", "LeftWrist", "RightWrist", "LeftAnkle", "RightAnkle", "LeftKnee")
PLACE = ((0.7, -0.4, 0.0), (0.0, 0.0, 0.9))


def make_rig(scene: bpy.types.Scene, connected: bool = False) -> bpy.types.Object:
    """A person under a root bone, on an object that is moved and turned."""
    obj = armature.create_armature(
        rig_from_skeleton(helpers.skeleton(), "Person"), "Person", scene.collection
    )
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.mode_set(mode="EDIT")
    bones = obj.data.edit_bones
    root = bones.new("Root")
    root.head, root.tail, root.roll = (
        (0.0, 0.3, 0.1),
        bones["Hips"].head if connected else (0.1, 0.5, 0.3),
        0.4,
    )
    bones["Hips"].parent, bones["Hips"].use_connect = root, connected
    bpy.ops.object.mode_set(mode="OBJECT")
    obj.location, obj.rotation_euler = PLACE
    bpy.context.view_layer.update()
    return obj


def shown(obj: bpy.types.Object, scene: bpy.types.Scene) -> np.ndarray:
    """World heads `(N, B, 3)` in some frames."""
    frames = []
    for frame in (1, 40, 111, 162):
        scene.frame_set(frame)
        frames.append(helpers.world_heads(obj, BONES))
    return np.array(frames)


def report() -> dict[str, Any]:
    return json.loads(bpy.data.texts[REPORT].as_string())


def baked(scene: bpy.types.Scene, obj: bpy.types.Object) -> np.ndarray:
    scene.footwork.rig, scene.footwork.recording_to = obj, 3.0
    assert bpy.ops.footwork.bake() == {"FINISHED"}
    return shown(obj, scene)


@pytest.fixture
def plain(empty, ready) -> np.ndarray:
    """What a bake onto the rig shows where nothing disturbs it."""
    obj = make_rig(empty)
    out = baked(empty, obj)
    assert report()["proof"]["bone"] == "" and not report()["proof"]["compensated"]
    assert report()["proof"]["position_mm"] < 0.1 and 15 <= report()["proof"]["frames"] <= 22
    bpy.data.objects.remove(obj)
    empty.frame_set(1)
    return out


def moving_parent(scene: bpy.types.Scene, obj: bpy.types.Object) -> None:
    carrier = bpy.data.objects.new("Carrier", None)
    scene.collection.objects.link(carrier)
    obj.parent = carrier
    for frame, x in ((1, 0.0), (100, 3.0), (200, -1.0)):
        carrier.location, carrier.rotation_euler = (x, 0.2 * x, 0.1), Euler((0.1 * x, 0.0, 0.5 * x))
        carrier.keyframe_insert("location", frame=frame)
        carrier.keyframe_insert("rotation_euler", frame=frame)


def constrained_root(scene: bpy.types.Scene, obj: bpy.types.Object) -> None:
    mark = bpy.data.objects.new("Mark", None)
    scene.collection.objects.link(mark)
    mark.location, mark.rotation_euler = (2.0, 1.0, 0.3), (0.2, -0.3, 1.1)
    constraint = obj.pose.bones["Root"].constraints.new("COPY_TRANSFORMS")
    constraint.target = mark


def travelling_root(scene: bpy.types.Scene, obj: bpy.types.Object) -> None:
    root = obj.pose.bones["Root"]
    for frame, x in ((1, 0.0), (150, 5.0)):
        root.location = (x, 0.0, 0.3 * x)
        root.keyframe_insert("location", frame=frame)
    data = obj.animation_data
    data.nla_tracks.new().strips.new("travel", 1, data.action)
    data.action = None


def driven_root(scene: bpy.types.Scene, obj: bpy.types.Object) -> None:
    obj.pose.bones["Root"].rotation_mode = "XYZ"
    driver = obj.pose.bones["Root"].driver_add("rotation_euler", 2).driver
    driver.expression = "frame * 0.01"


def solo_track(scene: bpy.types.Scene, obj: bpy.types.Object) -> None:
    travelling_root(scene, obj)
    obj.animation_data.nla_tracks[0].is_solo = True


def added_action(scene: bpy.types.Scene, obj: bpy.types.Object) -> None:
    travelling_root(scene, obj)
    obj.animation_data.nla_tracks[0].mute = True
    obj.animation_data.action_influence, obj.animation_data.action_blend_type = 0.3, "ADD"


def no_local_location(scene: bpy.types.Scene, obj: bpy.types.Object) -> None:
    obj.data.bones["Hips"].use_local_location = False


def excluded(scene: bpy.types.Scene, obj: bpy.types.Object) -> None:
    away = bpy.data.collections.new("Away")
    scene.collection.children.link(away)
    away.objects.link(obj)
    scene.collection.objects.unlink(obj)
    bpy.context.view_layer.layer_collection.children["Away"].exclude = True


def in_edit_mode(scene: bpy.types.Scene, obj: bpy.types.Object) -> None:
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.mode_set(mode="EDIT")


def edited(obj: bpy.types.Object, change: Callable[[Any], None]) -> None:
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.mode_set(mode="EDIT")
    change(obj.data.edit_bones)
    bpy.ops.object.mode_set(mode="OBJECT")


def feet_on_root(scene: bpy.types.Scene, obj: bpy.types.Object) -> None:
    def change(bones: Any) -> None:
        for name in ("LeftAnkle", "RightAnkle"):
            bones[name].parent = bones["Root"]

    edited(obj, change)


def feet_on_moving_root(scene: bpy.types.Scene, obj: bpy.types.Object) -> None:
    feet_on_root(scene, obj)
    moving_parent(scene, obj)
    travelling_root(scene, obj)


def feet_on_trunk(scene: bpy.types.Scene, obj: bpy.types.Object) -> None:
    def change(bones: Any) -> None:
        bones["LeftAnkle"].parent, bones["RightAnkle"].parent = bones["Chest"], bones["Hips"]

    edited(obj, change)


def root_in_a_pose(scene: bpy.types.Scene, obj: bpy.types.Object) -> None:
    root = obj.pose.bones["Root"]
    root.location, root.rotation_quaternion = (0.4, 0.2, -0.3), (0.8, 0.1, 0.5, 0.2)


OVERCOME: list[Callable[..., None]] = [
    moving_parent, constrained_root, travelling_root, driven_root, solo_track, added_action, no_local_location,
    excluded, in_edit_mode, feet_on_root, feet_on_moving_root, feet_on_trunk, root_in_a_pose,
]  # fmt: skip


@pytest.mark.parametrize("disturb", OVERCOME, ids=lambda disturb: disturb.__name__)
def test_what_can_be_overcome_is(empty, plain, disturb) -> None:
    obj = make_rig(empty)
    disturb(empty, obj)
    empty.frame_set(1)
    found = baked(empty, obj)
    if disturb is excluded:
        layers = bpy.context.view_layer.layer_collection.children
        assert layers["Away"].exclude and obj.name not in empty.collection.objects
        layers["Away"].exclude = False
        found = shown(obj, empty)
    np.testing.assert_allclose(found, plain, atol=1e-3)
    assert report()["proof"]["bone"] == "" and report()["proof"]["position_mm"] < 1.0
    assert not [line for line in report()["warnings"] if "meant to be" in line]


def test_a_body_that_its_root_makes_larger_is_a_larger_body(empty, plain) -> None:
    """The same bake as onto an object of that scale, whose scale no bone has."""
    obj = make_rig(empty)
    root = obj.pose.bones["Root"]
    root.scale, root.location = (1.2, 1.2, 1.2), (0.3, 0.1, 0.2)
    bpy.context.view_layer.update()
    found = baked(empty, obj)
    assert report()["proof"]["bone"] == "" and report()["proof"]["position_mm"] < 1.0
    assert np.allclose(root.scale, 1.2)
    bpy.data.objects.remove(obj)
    empty.frame_set(1)
    larger = make_rig(empty)
    larger.scale = (1.2, 1.2, 1.2)
    bpy.context.view_layer.update()
    np.testing.assert_allclose(found, baked(empty, larger), atol=1e-3)


def test_hips_that_hang_on_the_root_are_carried_by_it(empty, plain) -> None:
    obj = make_rig(empty, connected=True)
    np.testing.assert_allclose(baked(empty, obj), plain, atol=1e-3)
    assert report()["proof"]["bone"] == ""


def test_an_object_with_a_negative_scale_shows_the_same_body(empty, plain) -> None:
    obj = make_rig(empty)
    obj.scale = (-1.0, 1.0, 1.0)
    bpy.context.view_layer.update()
    swapped = list(range(len(BONES)))
    for side, other in (("Left", "Right"), ("Right", "Left")):
        for k, name in enumerate(BONES):
            if name.startswith(side) and name.replace(side, other) in BONES:
                swapped[k] = BONES.index(name.replace(side, other))
    found = baked(empty, obj)[:, swapped]
    # of the knee that is looked at the other is not
    np.testing.assert_allclose(found[:, :-1], plain[:, :-1], atol=1e-3)
    assert report()["proof"]["bone"] == "" and report()["proof"]["position_mm"] < 1.0


def test_arms_without_hands_bring_their_ends_to_the_wrists(empty, plain) -> None:
    obj = make_rig(empty)

    def change(bones: Any) -> None:
        for name in ("LeftWrist", "RightWrist"):
            for child in bones[name].children_recursive:
                bones.remove(child)
            bones.remove(bones[name])

    edited(obj, change)
    scene = empty
    scene.footwork.rig, scene.footwork.recording_to = obj, 3.0
    assert bpy.ops.footwork.bake() == {"FINISHED"}
    for index, frame in enumerate((1, 40, 111, 162)):
        scene.frame_set(frame)
        for name, elbow in (("LeftWrist", "LeftElbow"), ("RightWrist", "RightElbow")):
            end = obj.matrix_world @ obj.pose.bones[elbow].tail
            np.testing.assert_allclose(end, plain[index, BONES.index(name)], atol=1e-3)
    assert report()["proof"]["bone"] == ""


def ik_on_shin(obj: bpy.types.Object) -> None:
    goal = bpy.data.objects.new("Goal", None)
    bpy.context.scene.collection.objects.link(goal)
    goal.location = (0.4, 0.1, 0.3)
    constraint = obj.pose.bones["LeftKnee"].constraints.new("IK")
    constraint.target, constraint.chain_count = goal, 2


def limited_elbow(obj: bpy.types.Object) -> None:
    constraint = obj.pose.bones["LeftElbow"].constraints.new("LIMIT_ROTATION")
    constraint.use_limit_x = constraint.use_limit_y = constraint.use_limit_z = True
    constraint.owner_space = "LOCAL"


def driven_knee(obj: bpy.types.Object) -> None:
    bone = obj.pose.bones["RightKnee"]
    bone.rotation_mode = "XYZ"
    bone.driver_add("rotation_euler", 0).driver.expression = "0.3"


def at_rest(obj: bpy.types.Object) -> None:
    obj.data.pose_position = "REST"


STAYS = [
    (ik_on_shin, "LeftHip", "inverse kinematics IK on LeftKnee"),
    (limited_elbow, "LeftElbow", "constraint Limit Rotation on LeftElbow"),
    (driven_knee, "RightKnee", "driver on RightKnee"),
    (at_rest, "Hips", "rest position"),
]


@pytest.mark.parametrize(
    ("disturb", "bone", "cause"), STAYS, ids=lambda value: getattr(value, "__name__", "")
)
def test_what_stays_is_told_in_one_line_with_bone_length_and_cause(
    empty, plain, disturb, bone: str, cause: str
) -> None:
    obj = make_rig(empty)
    disturb(obj)
    away = np.linalg.norm(baked(empty, obj) - plain, axis=-1).max()
    found = report()
    (line,) = [line for line in found["warnings"] if "meant to be" in line]
    assert f"Blender shows {bone} up to" in line and cause in line
    # all frames were looked at, of which those here are some
    assert found["proof"]["frames"] >= 180 and 1000.0 * away <= found["proof"]["position_mm"] + 1.0
    assert (found["proof"]["bone"], cause in found["proof"]["cause"]) == (bone, True)
    assert line in empty.footwork.warnings
    current = empty.frame_current
    assert current == 162 and scene_fps(empty) == 60


def test_the_figures_are_of_what_blender_shows(empty, plain) -> None:
    """A hand that a constraint holds at the root is as far from its tracker as one can measure."""
    obj = make_rig(empty)
    constraint = obj.pose.bones["LeftWrist"].constraints.new("COPY_LOCATION")
    constraint.target, constraint.subtarget = obj, "Root"
    found = baked(empty, obj)
    metrics = report()["metrics"]
    away = np.linalg.norm(found[:, 2] - plain[:, 2], axis=-1) * 100.0
    assert away.min() > 20.0
    # of both hands, the other one being where it should
    assert metrics["hand_position_error_cm"]["max"] >= away.max() - 1.0
    assert metrics["hand_position_error_cm"]["mean"] == pytest.approx(away.mean() / 2.0, rel=0.25)
    row = next(row for row in empty.footwork.figures if row.name == "Hands")
    assert row.good == "POOR"

"""Bakes on rigs as people have them: nothing of the rig changes but its action."""

from __future__ import annotations

import bpy
import helpers
import numpy as np
import pytest
from footwork.bridge import armature, compat

RIGS = ("mixamo_ybot.fbx", "rocketbox_male_biped.fbx", "readyplayerme.glb")


@pytest.fixture(params=RIGS)
def rig(request, data, ready) -> bpy.types.Object:
    """A rig in a scene that is ready, placed as in somebody's shot."""
    path = data / "rigs" / request.param
    importer = bpy.ops.import_scene.gltf if path.suffix == ".glb" else bpy.ops.import_scene.fbx
    importer(filepath=str(path))
    obj = next(obj for obj in bpy.context.scene.objects if obj.type == "ARMATURE")
    obj.location = (1.5, -0.5, 0.0)
    obj.delta_rotation_euler = (0.0, 0.0, 0.5)
    ready.rig = obj
    ready.recording_to = 3.0
    bpy.context.view_layer.update()
    return obj


def curves_of(action: bpy.types.Action) -> list:
    if bpy.app.version < (4, 4, 0):
        return list(action.fcurves)
    bags = [bag for layer in action.layers for strip in layer.strips for bag in strip.channelbags]
    return [curve for bag in bags for curve in bag.fcurves]


def rest(rig: bpy.types.Object) -> list:
    return [
        (
            bone.name,
            bone.parent and bone.parent.name,
            bone.use_connect,
            bone.inherit_scale,
            bone.length,
            [tuple(row) for row in bone.matrix_local],
        )
        for bone in rig.data.bones
    ]


def state(scene: bpy.types.Scene, rig: bpy.types.Object, actions: list[str]) -> dict[str, object]:
    """Everything that a bake must leave alone."""
    objects = [
        (
            obj.name,
            obj.parent and obj.parent.name,
            [tuple(row) for row in obj.matrix_basis],
            [tuple(row) for row in obj.matrix_parent_inverse],
            [tuple(part) for part in (obj.location, obj.rotation_euler, obj.rotation_quaternion, obj.scale)],
            [tuple(part) for part in (obj.delta_location, obj.delta_rotation_euler, obj.delta_scale)],
            obj.rotation_mode,
            [modifier.name for modifier in obj.modifiers],
        )
        for obj in scene.objects
    ]
    keys = {
        name: [
            (curve.data_path, curve.array_index, [tuple(key.co) for key in curve.keyframe_points])
            for curve in curves_of(bpy.data.actions[name])
        ]
        for name in actions
    }
    modes = [(bone.name, bone.rotation_mode, len(bone.constraints)) for bone in rig.pose.bones]
    return {
        "objects": objects,
        "world": [tuple(row) for row in rig.matrix_world],
        "rest": rest(rig),
        "actions": keys,
        "modes": modes,
        "position": rig.data.pose_position,
        "mode": rig.mode,
    }


def give_action(rig: bpy.types.Object) -> bpy.types.Action:
    """An action of the user's own, where the file brought none."""
    if rig.animation_data is None or rig.animation_data.action is None:
        rig.pose.bones[0].keyframe_insert("location", frame=1)
        rig.pose.bones[0].location.x += 0.1
        rig.pose.bones[0].keyframe_insert("location", frame=9)
    return rig.animation_data.action


def test_a_bake_changes_nothing_but_the_action(rig, empty) -> None:
    own = give_action(rig)
    actions = [action.name for action in bpy.data.actions]
    empty.frame_set(1)
    before = state(empty, rig, actions)
    for _ in range(2):
        assert bpy.ops.footwork.bake() == {"FINISHED"}
    after = state(empty, rig, actions)
    for part, value in before.items():
        assert after[part] == value, part
    assert rig.animation_data.action.name not in actions and own.use_fake_user
    # the object itself is not animated
    assert all(curve.data_path.startswith("pose.bones") for curve in compat.fcurves_of(rig))
    rig.animation_data.action = own
    assert state(empty, rig, actions)["actions"] == before["actions"]


def test_only_mapped_bones_are_keyed_and_the_head_is_where_it_should(rig, empty) -> None:
    roles = armature.role_map(rig)
    bones = set(roles.values())
    fingers = rig.pose.bones[roles["hand.L"]].children_recursive
    give_action(rig)
    fingers[0].rotation_mode = "QUATERNION"
    # keyed fingers belong to the old action, so only what is posed by hand may stay
    rig.animation_data.action = None
    fingers[0].rotation_quaternion = (0.8, 0.6, 0.0, 0.0)
    bpy.ops.footwork.bake()
    keyed = {curve.data_path.split('"')[1] for curve in compat.fcurves_of(rig)}
    assert keyed <= bones and {roles[role] for role in ("hips", "head", "hand.L")} <= keyed
    assert tuple(fingers[0].rotation_quaternion) == pytest.approx((0.8, 0.6, 0.0, 0.0))
    for frame in (1, 60, 120, 180):
        empty.frame_set(frame)
        places = helpers.world_heads(rig, tuple(roles[r] for r in ("head", "hips", "foot.L", "foot.R")))
        assert places[0, 2] > places[1, 2] + 0.3 > places[2:, 2].max() + 0.5
        assert -0.02 < places[2:, 2].min() < 0.2
        # the scene's ground is the avatar's, wherever the object stands
        assert np.abs(places[:, :2]).max() < 20.0

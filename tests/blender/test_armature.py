"""Armatures read and made."""

from __future__ import annotations

import json

import bpy
import helpers
import numpy as np
import pytest
from footwork.bridge import armature
from footwork.bridge.action import write_action
from footwork.core.body.retarget import retarget
from footwork.core.errors import InputError
from footwork.core.mocap.families import KIND
from footwork.core.presets import SHIPPED, VARIABLE
from footwork.core.rig.fit import fit_rig, rig_from_skeleton
from footwork.core.rig.keys import to_bone_tracks
from footwork.core.rig.rig import Rig


def test_an_armature_made_from_a_rig_reads_back_the_same(empty) -> None:
    rig = rig_from_skeleton(helpers.skeleton(), "Person")
    obj = armature.create_armature(rig, "Person", empty.collection)
    back = armature.armature_to_rig(obj)
    order = [back.bones.index(bone) for bone in rig.bones]
    assert np.abs(back.rest[order] - rig.rest).max() < 1e-5
    assert np.abs(back.tails[order] - rig.tails).max() < 1e-5
    assert [back.roles[i] for i in order] == list(rig.roles)
    assert all(back.parents[i] < i for i in range(len(back.bones)))
    parents = {
        bone: back.bones[back.parents[i]] if back.parents[i] >= 0 else "" for i, bone in enumerate(back.bones)
    }
    assert parents["LeftWrist"] == "LeftElbow" and parents["Hips"] == ""


def test_random_rest_rotations_survive(empty) -> None:
    random = np.random.default_rng(3)
    from footwork.core.maths import quat

    rest = np.tile(np.eye(4), (6, 1, 1))
    rest[:, :3, :3] = quat.to_matrix(quat.normalize(random.normal(size=(6, 4))))
    rest[:, :3, 3] = random.normal(size=(6, 3))
    tails = rest[:, :3, 3] + 0.3 * rest[:, :3, 1]
    parents = np.array([-1, 0, 1, 0, 3, -1], np.intp)
    rig = Rig("R", tuple("abcdef"), parents, rest, tails, np.eye(4), ("",) * 6)
    obj = armature.create_armature(rig, "R", empty.collection)
    made = np.array([obj.data.bones[name].matrix_local for name in rig.bones])
    assert np.abs(made - rest).max() < 1e-5


def test_making_an_armature_leaves_mode_and_active_object(empty) -> None:
    rig = rig_from_skeleton(helpers.skeleton(), "Person")
    first = armature.create_armature(rig, "First", empty.collection)
    bpy.context.view_layer.objects.active = first
    bpy.ops.object.mode_set(mode="POSE")
    armature.create_armature(rig, "Second", empty.collection)
    assert bpy.context.view_layer.objects.active == first and first.mode == "POSE"


def test_roles_set_by_hand_overrule_the_names_and_are_saved(empty, tmp_path) -> None:
    rig = rig_from_skeleton(helpers.skeleton(), "Person")
    obj = armature.create_armature(rig, "Person", empty.collection)
    assert obj.footwork.hand_L == "LeftWrist"
    obj.footwork.toe_L = ""
    obj.footwork.spine1 = "Chest"
    assert armature.role_overrides(obj) == {"toe.L": ""}
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "rig.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "rig.blend"))
    obj = bpy.data.objects["Person"]
    assert "toe.L" not in armature.armature_to_rig(obj).roles
    bpy.context.scene.footwork.rig = obj
    assert bpy.ops.footwork.reset_roles() == {"FINISHED"}
    assert "toe.L" in armature.armature_to_rig(obj).roles and armature.ROLE_MAP not in obj


def test_unknown_names_are_told_by_structure_and_can_be_mapped_by_hand(empty) -> None:
    rig = rig_from_skeleton(helpers.skeleton(), "Person")
    obj = armature.create_armature(rig, "Person", empty.collection)
    new_names = {bone: f"x{number}" for number, bone in enumerate(rig.bones)}
    for bone in obj.data.bones:
        bone.name = new_names[bone.name]
    told = dict(zip(rig.roles, rig.bones, strict=True))
    found = armature.detected_roles(obj)
    assert found and all(bone == new_names[told[role]] for role, bone in found.items() if "spine" not in role)
    assert any("look at them" in doubt for doubt in armature.rig_doubts(obj))
    armature.set_roles(
        obj, {role: new_names[bone] for role, bone in zip(rig.roles, rig.bones, strict=True) if role}
    )
    back = armature.armature_to_rig(obj)
    assert dict(zip(back.bones, back.roles, strict=True)) == {
        new_names[bone]: role for bone, role in zip(rig.bones, rig.roles, strict=True)
    }
    armature.set_role(obj, "hand.L", "x0")
    with pytest.raises(InputError, match="two roles"):
        armature.armature_to_rig(obj)
    armature.set_role(obj, "hand.L", "gone")
    with pytest.raises(InputError, match="gone"):
        armature.armature_to_rig(obj)


def test_a_bone_map_in_the_users_folder_counts_at_once(empty, tmp_path, monkeypatch) -> None:
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    rig = rig_from_skeleton(helpers.skeleton(), "Person")
    obj = armature.create_armature(rig, "Person", empty.collection)
    for bone in obj.data.bones:
        bone.name = bone.name.replace("i", "y").replace("o", "0").replace("e", "3")
    assert armature.detected_preset(obj)[0] == "names and structure"
    (tmp_path / KIND).mkdir()
    (tmp_path / KIND / "broken.json").write_text("{")
    assert any("broken.json" in doubt for doubt in armature.rig_doubts(obj))
    content = json.loads((SHIPPED / KIND / "xsens.json").read_text())
    own = str.maketrans("ioe", "y03")
    joints = {role: name.replace("{side}", "|").translate(own) for role, name in content["joints"].items()}
    joints = {role: name.replace("|", "{side}") for role, name in joints.items()}
    sides = [side.translate(own) for side in content["sides"]]
    (tmp_path / KIND / "own.json").write_text(
        json.dumps({**content, "name": "Own", "joints": joints, "sides": sides})
    )
    assert armature.detected_preset(obj)[0] == "Own"
    roles = armature.armature_to_rig(obj).roles
    assert {role for role in rig.roles if role} == {role for role in roles if role}


def test_other_objects_are_refused(empty) -> None:
    with pytest.raises(InputError, match="not an armature"):
        armature.armature_to_rig(bpy.data.objects.new("Nothing", None))


def test_what_spoils_a_bake_is_told(empty) -> None:
    rig = rig_from_skeleton(helpers.skeleton(), "Person")
    obj = armature.create_armature(rig, "Person", empty.collection)
    assert not armature.rig_doubts(obj)
    wrist = obj.pose.bones["LeftWrist"]
    wrist.constraints.new("COPY_ROTATION")
    obj.pose.bones["LeftElbow"].driver_add("rotation_quaternion", 0)
    obj.data.bones["RightKnee"].use_inherit_rotation = False
    obj.data.pose_position = "REST"
    obj.animation_data.nla_tracks.new()
    doubts = armature.rig_doubts(obj)
    for text in (
        "Constraints act on LeftWrist",
        "Drivers win over keys on LeftElbow",
        "RightKnee: Inherit",
        "rest position",
        "NLA",
    ):
        assert sum(text in doubt for doubt in doubts) == 1, text


def test_limbs_that_hang_on_a_copy_of_a_control_follow_it(empty) -> None:
    body = helpers.skeleton()
    obj = armature.create_armature(rig_from_skeleton(body, "Person"), "Person", empty.collection)
    armature.set_roles(obj, armature.role_map(obj))
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.mode_set(mode="EDIT")
    edit = obj.data.edit_bones
    for side in ("Left", "Right"):
        copy = edit.new(f"ORG-{side}Collar")
        copy.head, copy.tail, copy.roll = (
            getattr(edit[f"{side}Collar"], p) for p in ("head", "tail", "roll")
        )
        copy.parent, edit[f"{side}Shoulder"].parent = edit["Chest4"], copy
    bpy.ops.object.mode_set(mode="OBJECT")
    for side in ("Left", "Right"):
        constraint = obj.pose.bones[f"ORG-{side}Collar"].constraints.new("COPY_TRANSFORMS")
        constraint.target, constraint.subtarget = obj, f"{side}Collar"
    rig = armature.armature_to_rig(obj)
    above = dict(zip(rig.bones, [rig.bones[p] if p >= 0 else "" for p in rig.parents], strict=True))
    # what the rig moves by itself gets no keys, so it is no joint
    assert above["LeftShoulder"] == above["ORG-LeftCollar"] == "LeftCollar"
    assert all(parent < number for number, parent in enumerate(rig.parents))

    fit = fit_rig(rig)
    moved = retarget(helpers.motion(body), fit.skeleton)
    write_action(obj, to_bone_tracks(moved, fit, 60.0), "x", fps=60.0)
    expected, _ = moved.forward()
    for frame in (0, 25, 59):
        empty.frame_set(1 + frame)
        assert np.abs(helpers.world_heads(obj, fit.skeleton.names) - expected[frame]).max() < 1e-4


@pytest.mark.parametrize("why", ["muted", "weak", "elsewhere", "of itself below"])
def test_other_copies_hang_where_they_are(empty, why: str) -> None:
    body = helpers.skeleton()
    obj = armature.create_armature(rig_from_skeleton(body, "Person"), "Person", empty.collection)
    before = armature.armature_to_rig(obj)
    name, leader = ("LeftElbow", "LeftWrist") if why == "of itself below" else ("LeftWrist", "RightWrist")
    constraint = obj.pose.bones[name].constraints.new("COPY_TRANSFORMS")
    constraint.target, constraint.subtarget = obj, leader
    constraint.mute, constraint.influence = why == "muted", 0.5 if why == "weak" else 1.0
    after = armature.armature_to_rig(obj)
    assert after.bones == before.bones and np.array_equal(after.parents, before.parents)


def test_an_armature_is_made_although_the_active_collection_is_hidden(empty) -> None:
    hidden = bpy.data.collections.new("Hidden")
    empty.collection.children.link(hidden)
    bpy.context.view_layer.layer_collection.children["Hidden"].exclude = True
    obj = armature.create_armature(rig_from_skeleton(helpers.skeleton(), "Person"), "Person", hidden)
    assert obj.name in bpy.context.view_layer.objects and len(obj.data.bones) == len(helpers.skeleton())


def test_scene_units_count(empty) -> None:
    rig = rig_from_skeleton(helpers.skeleton(), "Person")
    obj = armature.create_armature(rig, "Person", empty.collection, metres_per_unit=0.01)
    assert obj.matrix_world.to_scale()[0] == pytest.approx(100.0)
    assert np.abs(armature.armature_to_rig(obj, 0.01).world - np.eye(4)).max() < 1e-6

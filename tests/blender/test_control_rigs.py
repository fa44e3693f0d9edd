"""Rigs of controls: what deforms is where it was meant to be, however switches and other controls stand."""

from __future__ import annotations

import importlib
import json
import random
from typing import Any

import bpy
import helpers
import numpy as np
import pytest
from footwork.bridge import armature, compat
from footwork.bridge.mechanism import SWITCHES
from footwork.core.rig.fit import rig_from_skeleton
from footwork.operators.bake import REPORT

FRAMES = (1, 37, 90, 150)


def edited(obj: bpy.types.Object) -> Any:
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.mode_set(mode="EDIT")
    return obj.data.edit_bones


def twin(bones: Any, name: str, like: str, parent: str) -> None:
    bone = bones.new(name)
    bone.head, bone.tail, bone.roll = (getattr(bones[like], part) for part in ("head", "tail", "roll"))
    bone.parent = bones[parent]
    bone.use_deform = False


def plain_rig(scene: bpy.types.Scene) -> bpy.types.Object:
    rig = rig_from_skeleton(helpers.skeleton(), "Plain")
    return armature.create_armature(rig, "Plain", scene.collection)


def control_rig(scene: bpy.types.Scene) -> bpy.types.Object:
    """FK controls with the plain rig's names, deforming bones that follow them or, as made, inverse kinematics; a
    neck that follows the body's turns by half, and a chest that is half another control's."""
    obj = plain_rig(scene)
    obj.name = "Controls"
    body = [bone.name for bone in obj.data.bones]
    bones = edited(obj)
    for name in body:
        bones[name].use_deform = False
    root = bones.new("root")
    root.head, root.tail, root.use_deform = (0, 0, 0), (0, 0.3, 0), False
    bones["Hips"].parent = root
    for name in body:
        twin(bones, f"DEF-{name}", name, "root")
        bones[f"DEF-{name}"].use_deform = True
    twin(bones, "chest", "Chest4", "Hips")
    twin(bones, "MCH-chest", "Chest4", "Chest")
    twin(bones, "tweak", "Chest4", "MCH-chest")
    bones["Chest4"].parent = bones["tweak"]
    twin(bones, "MCH-ROT-neck", "Neck", "Chest4")
    bones["Neck"].parent = bones["MCH-ROT-neck"]
    for name in ("LeftAnkle", "RightWrist"):
        twin(bones, f"{name}_ik", name, "root")
    for limb in (("LeftHip", "LeftKnee", "LeftAnkle"), ("RightShoulder", "RightElbow", "RightWrist")):
        for k, name in enumerate(limb):
            parent = f"MCH-{limb[k - 1]}" if k else bones[name].parent.name
            twin(bones, f"MCH-{name}", name, parent)
    bpy.ops.object.mode_set(mode="OBJECT")
    pose = obj.pose.bones
    for bone in pose:
        if bone.name.startswith(("MCH-", "DEF-")):
            bone.lock_location = bone.lock_rotation = (True,) * 3
    pose["LeftHip"]["IK_FK"] = pose["RightShoulder"]["IK_FK"] = 0.0
    pose["Hips"]["neck_follow"] = 0.5

    def copy(name: str, leader: str, kind: str = "COPY_TRANSFORMS", influence: float = 1.0) -> Any:
        constraint = pose[name].constraints.new(kind)
        constraint.target, constraint.subtarget, constraint.influence = obj, leader, influence
        return constraint

    def drive(constraint: Any, bone: str, prop: str, expression: str) -> None:
        driver = constraint.driver_add("influence").driver
        variable = driver.variables.new()
        variable.name, driver.expression = "v", expression
        variable.targets[0].id = obj
        variable.targets[0].data_path = f'pose.bones["{bone}"]["{prop}"]'

    half = copy("MCH-chest", "chest", influence=0.5)
    half.owner_space = half.target_space = "LOCAL"
    drive(copy("MCH-ROT-neck", "root", "COPY_ROTATION"), "Hips", "neck_follow", "1 - v")
    limbs = {"LeftHip": "LeftHip", "LeftKnee": "LeftHip", "LeftAnkle": "LeftHip"}
    limbs |= dict.fromkeys(("RightShoulder", "RightElbow", "RightWrist"), "RightShoulder")
    for name in body:
        if name in limbs:
            copy(f"DEF-{name}", f"MCH-{name}")
            drive(copy(f"DEF-{name}", name), limbs[name], "IK_FK", "v")
        else:
            copy(f"DEF-{name}", name)
    roles = dict(zip(helpers.skeleton().roles, helpers.skeleton().names, strict=True))
    armature.set_roles(obj, {**dict.fromkeys(armature.detected_roles(obj), ""), **roles})
    for end, goal in (("LeftKnee", "LeftAnkle_ik"), ("RightElbow", "RightWrist_ik")):
        copy(f"MCH-{end}", goal, "IK").chain_count = 2
    return obj


def heads(obj: bpy.types.Object, scene: bpy.types.Scene, names: tuple[str, ...]) -> np.ndarray:
    """World heads `(N, B, 3)` in some frames."""
    out = []
    for frame in FRAMES:
        scene.frame_set(frame)
        out.append(helpers.world_heads(obj, names))
    return np.array(out)


def bake(scene: bpy.types.Scene, obj: bpy.types.Object) -> dict[str, Any]:
    scene.footwork.rig, scene.footwork.recording_to = obj, 2.5
    assert bpy.ops.footwork.bake() == {"FINISHED"}
    return json.loads(bpy.data.texts[REPORT].as_string())


def keyed(obj: bpy.types.Object) -> set[str]:
    return {curve.data_path.split('"')[1] for curve in compat.fcurves_of(obj)}


def unsettle(obj: bpy.types.Object, seed: int) -> None:
    """Every bone that is not locked in a pose, its switches anywhere."""
    rnd = random.Random(seed)
    for bone in obj.pose.bones:
        for prop in sorted(SWITCHES.keys() & set(bone.keys())):
            bone[prop] = rnd.random()
        if not all(bone.lock_rotation):
            turn = [1.0, *(rnd.uniform(-0.3, 0.3) for _ in range(3))]
            bone.rotation_quaternion, bone.rotation_euler = turn, turn[1:]
        if not all(bone.lock_location):
            bone.location = [rnd.uniform(-0.05, 0.05) for _ in range(3)]


@pytest.mark.parametrize("posed", [False, True], ids=["as made", "posed"])
def test_what_deforms_is_where_a_plain_rig_has_it(empty, ready, posed: bool) -> None:
    names = helpers.skeleton().names
    plain = plain_rig(empty)
    bake(empty, plain)
    expected = heads(plain, empty, names)
    bpy.data.objects.remove(plain)
    empty.frame_set(1)
    obj = control_rig(empty)
    if posed:
        unsettle(obj, 4)
        bpy.context.view_layer.update()
    assert not [line for line in armature.rig_doubts(obj) if "IK_FK" in line]
    report = bake(empty, obj)
    found = heads(obj, empty, tuple(f"DEF-{name}" for name in names))
    np.testing.assert_allclose(found, expected, atol=1e-4)
    assert report["proof"]["bone"] == "" and report["proof"]["position_mm"] < 0.1
    assert keyed(obj) == {*names, "chest", "tweak"}
    values = {(c.data_path, tuple(k.co[1] for k in c.keyframe_points)) for c in compat.fcurves_of(obj)}
    for bone, prop in (("LeftHip", "IK_FK"), ("RightShoulder", "IK_FK"), ("Hips", "neck_follow")):
        assert (f'pose.bones["{bone}"]["{prop}"]', (1.0,)) in values


def test_the_proof_looks_at_what_deforms(empty, ready) -> None:
    """A deforming bone that does not follow its control is told, though the control is where it was meant to be."""
    obj = control_rig(empty)
    obj.pose.bones["DEF-LeftElbow"].constraints[0].influence = 0.0
    report = bake(empty, obj)
    assert report["proof"]["bone"] == "LeftElbow" and report["proof"]["position_mm"] > 50.0


@pytest.mark.parametrize("kind", ["human", "basic_human"])
def test_generated_rigify_shows_what_was_meant(empty, ready, kind: str) -> None:
    addon_utils = importlib.import_module("addon_utils")
    if "rigify" not in [module.__name__ for module in addon_utils.modules()]:
        pytest.skip("this Blender has no Rigify")
    assert bpy.ops.preferences.addon_enable(module="rigify") == {"FINISHED"}
    try:
        getattr(bpy.ops.object, f"armature_{kind}_metarig_add")()
        metarig = bpy.context.object
        bpy.ops.pose.rigify_generate()
        obj = next(o for o in bpy.data.objects if o.type == "ARMATURE" and o != metarig)
        bpy.data.objects.remove(metarig)
        found = {}
        for posed in (False, True):
            if posed:
                unsettle(obj, 1)
                bpy.context.view_layer.update()
            report = bake(empty, obj)
            assert report["proof"]["bone"] == "" and report["proof"]["position_mm"] < 1.0
            deforming = tuple(b.name for b in obj.data.bones if b.use_deform and b.name[4:8] in LIMBS)
            found[posed] = heads(obj, empty, deforming)
            assert not [name for name in keyed(obj) if name.startswith(("MCH-", "ORG-", "DEF-"))]
        assert len(deforming) >= 20
        # all of the body, between joints too
        np.testing.assert_allclose(found[True], found[False], atol=1e-3)
    finally:
        addon_utils.disable("rigify")


LIMBS = ("spin", "thig", "shin", "foot", "toe.", "shou", "uppe", "fore", "hand")

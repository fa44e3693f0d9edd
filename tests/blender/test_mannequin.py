"""Mannequins in Blender: a mesh that its bones carry, made by bakes that are given no rig."""

import bpy
import helpers
import numpy as np
import pytest
from footwork.bridge.armature import armature_to_rig
from footwork.bridge.mannequin import MATERIALS, create_mannequin
from footwork.core.rig.fit import fit_rig, rig_from_skeleton


def body_of(armature):
    (body,) = [obj for obj in armature.children if obj.type == "MESH"]
    return body


def shown(body):
    """World places of the vertices as Blender shows them."""
    bpy.context.view_layer.update()
    evaluated = body.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    places = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.vertices.foreach_get("co", places)
    evaluated.to_mesh_clear()
    matrix = np.array(body.matrix_world)
    return places.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]


def make(scene, unit=1.0):
    rig = rig_from_skeleton(helpers.skeleton(), "Person")
    return rig, create_mannequin(rig, "Person", scene.collection, unit)


def test_a_skinned_mesh_with_two_materials(empty) -> None:
    rig, armature = make(empty)
    body = body_of(armature)
    assert [slot.material.name for slot in body.material_slots] == [name for name, *_ in MATERIALS]
    assert {group.name for group in body.vertex_groups} <= set(rig.bones)
    assert body.find_armature() == armature
    assert not body.data.validate()
    assert all(polygon.use_smooth for polygon in body.data.polygons)
    # a second one shares the materials
    make(empty)
    assert [material.name for material in bpy.data.materials if "Mannequin" in material.name] == [
        name for name, *_ in MATERIALS
    ]


def test_it_faces_as_its_armature_does(empty) -> None:
    _, armature = make(empty)
    body = body_of(armature)
    visor = [p.index for p in body.data.polygons if p.material_index == 1 and p.center.z > 1.5]
    assert np.mean([body.data.polygons[index].center.y for index in visor]) < -0.05
    fingers = [v.co.x for v in body.data.vertices if v.groups and v.co.x > 0.7]
    assert fingers and armature.data.bones["LeftWrist"].head_local.x > 0.5


def test_a_bent_elbow_moves_what_is_beyond_it(empty) -> None:
    _, armature = make(empty)
    body = body_of(armature)
    before = shown(body)
    bone = armature.pose.bones["LeftElbow"]
    bone.rotation_quaternion = (np.cos(0.6), 0.0, 0.0, np.sin(0.6))
    after = shown(body)
    elbow = armature.data.bones["LeftElbow"].head_local.x
    moved = np.linalg.norm(after - before, axis=1)
    assert moved[before[:, 0] < elbow - 0.12].max() < 1e-5
    beyond = before[:, 0] > elbow + 0.12
    radius = np.linalg.norm(before[beyond] - np.array(armature.data.bones["LeftElbow"].head_local), axis=1)
    assert moved[beyond] == pytest.approx(2.0 * np.sin(0.6) * radius, rel=0.05)


def test_its_soles_are_where_the_skeleton_has_the_floor(empty) -> None:
    rig, armature = make(empty)
    again = fit_rig(armature_to_rig(armature)).skeleton
    assert again.offsets[0, 2] == pytest.approx(fit_rig(rig).skeleton.offsets[0, 2], abs=2e-3)


def test_scenes_in_centimetres(empty) -> None:
    _, armature = make(empty, 0.01)
    height = np.ptp(shown(body_of(armature))[:, 2])
    assert 165.0 < height < 185.0

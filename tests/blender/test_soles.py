"""Rigs stand on the soles of their meshes."""

from __future__ import annotations

import bpy
import helpers
import numpy as np
import pytest
from footwork.bridge.armature import armature_to_rig, create_armature
from footwork.core.rig.fit import fit_rig, rig_from_skeleton

THICK = 0.045
"""Metres that the shoes' soles are under the lowest toe joint."""


def with_shoes(scale: float, thickness: float = THICK) -> bpy.types.Object:
    """An armature with a box on each foot whose lower side is so far under the toes, and a longer cloak."""
    obj = create_armature(rig_from_skeleton(helpers.skeleton(), "hero"), "hero", bpy.context.scene.collection)
    obj.scale = (scale,) * 3
    bpy.context.view_layer.update()
    places, faces, owners = [], [], []
    for side in ("Left", "Right"):
        toe = obj.data.bones[f"{side}Toe"].head_local
        for corner in np.ndindex(2, 2, 2):
            x, y, z = corner
            places.append((toe.x + 0.08 * x - 0.04, toe.y + 0.2 * y - 0.1, toe.z - thickness + 0.1 * z))
            owners.append(f"{side}Toe" if y else f"{side}Ankle")
        start = len(places) - 8
        faces += [(start, start + 1, start + 3, start + 2), (start + 4, start + 5, start + 7, start + 6)]
    # what the hips carry is no sole, however low
    places += [(0.3, 0.3, -0.5), (0.4, 0.3, -0.5), (0.3, 0.4, 0.5)]
    owners += ["Hips"] * 3
    faces.append((len(places) - 3, len(places) - 2, len(places) - 1))
    mesh = bpy.data.meshes.new("shoes")
    mesh.from_pydata(places, [], faces)
    shoes = bpy.data.objects.new("shoes", mesh)
    bpy.context.scene.collection.objects.link(shoes)
    shoes.parent = obj
    for index, owner in enumerate(owners):
        group = shoes.vertex_groups.get(owner) or shoes.vertex_groups.new(name=owner)
        group.add([index], 1.0, "REPLACE")
    shoes.modifiers.new("Armature", "ARMATURE").object = obj
    return obj


def toe_height(obj: bpy.types.Object) -> float:
    skeleton = fit_rig(armature_to_rig(obj)).skeleton
    return float(skeleton.tpose_positions()[[skeleton.joint("toe.L"), skeleton.joint("toe.R")], 2].mean())


@pytest.mark.parametrize(("scale", "turned"), [(1.0, False), (0.6, True)])
def test_a_rig_with_shoes_stands_on_their_soles(empty, scale: float, turned: bool) -> None:
    obj = with_shoes(scale)
    # neither the pose nor the place of the object matters
    obj.pose.bones["LeftKnee"].rotation_mode = "XYZ"
    obj.pose.bones["LeftKnee"].rotation_euler = (0.9, 0.1, 0.3)
    if turned:
        obj.location, obj.rotation_euler = (2.0, 1.0, 0.7), (0.0, 0.0, 0.8)
    bpy.context.view_layer.update()
    assert toe_height(obj) == pytest.approx(scale * THICK, abs=1e-4)
    assert obj.data.pose_position == "POSE"


def test_modifiers_of_the_mesh_count(empty) -> None:
    obj = with_shoes(1.0)
    thicker = bpy.data.objects["shoes"].modifiers.new("Sole", "DISPLACE")
    thicker.direction, thicker.mid_level, thicker.strength = "Z", 0.0, -0.02
    assert toe_height(obj) == pytest.approx(THICK + 0.02, abs=1e-4)


def test_what_can_be_no_sole_and_rigs_without_a_mesh_go_by_their_joints(empty) -> None:
    obj = with_shoes(1.0, thickness=0.9)
    low = toe_height(obj)
    bpy.data.objects.remove(bpy.data.objects["shoes"])
    assert toe_height(obj) == low

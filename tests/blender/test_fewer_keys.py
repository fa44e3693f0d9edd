"""Fewer keys: Blender shows each frame within the stated distance of the bake with all keys."""

from __future__ import annotations

import json
from typing import Any

import bpy
import numpy as np
import pytest
from footwork.operators.bake import REPORT
from helpers import keys_of
from test_before import whole
from test_control_rigs import control_rig, plain_rig
from test_proof import make_rig


def shown(obj: bpy.types.Object, scene: bpy.types.Scene) -> np.ndarray:
    """World heads and tails `(T, 2 B, 3)` of deforming bones at every frame, in metres."""
    out = []
    for frame in range(1, 152):
        scene.frame_set(frame)
        found = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
        bones = [bone for bone in found.pose.bones if bone.bone.use_deform]
        out.append([found.matrix_world @ at for bone in bones for at in (bone.head, bone.tail)])
    return np.array(out)


def bake(scene: bpy.types.Scene, limit: float, travel: str = "hips") -> dict[str, Any]:
    scene.footwork.fewer_keys, scene.footwork.recording_to, scene.footwork.travel = limit, 2.5, travel
    assert bpy.ops.footwork.bake() == {"FINISHED"}
    return json.loads(bpy.data.texts[REPORT].as_string())


def in_euler(scene: bpy.types.Scene) -> bpy.types.Object:
    obj = plain_rig(scene)
    for k, bone in enumerate(obj.pose.bones):
        bone.rotation_mode = ("XYZ", "ZXY", "AXIS_ANGLE", "QUATERNION")[k % 4]
    return obj


@pytest.mark.parametrize(
    ("make", "travel"),
    [
        (make_rig, "hips"),
        (make_rig, "root"),
        (control_rig, "hips"),
        (control_rig, "root"),
        (in_euler, "hips"),
    ],
)
def test_all_frames_are_within_the_limit(empty, ready, make: Any, travel: str) -> None:
    obj = empty.footwork.rig = make(empty)
    assert "keys" not in bake(empty, 0.0, travel)
    full, keys = shown(obj, empty), keys_of(obj.animation_data.action)
    report = bake(empty, 2.0, travel)["keys"]
    away = 1000.0 * np.linalg.norm(shown(obj, empty) - full, axis=-1).max()
    assert 0.1 < away <= 2.0 + 0.01
    assert report["limit_mm"] == 2.0 and away <= report["worst_mm"] + 0.01
    assert report["kept"] < 0.6 * report["of"]
    # controls and switches that are held have one key each
    # two bakes differ by a few keys: frames that are equal in single precision share one
    assert abs(keys - report["of"]) < 30
    assert 0 <= keys_of(obj.animation_data.action) - report["kept"] < 30


def test_clear_bake_gives_everything_back(empty, ready) -> None:
    obj = empty.footwork.rig = control_rig(empty)
    before = whole(obj)
    bake(empty, 1.0)
    assert bpy.ops.footwork.clear_bake() == {"FINISHED"}
    assert whole(obj) == before

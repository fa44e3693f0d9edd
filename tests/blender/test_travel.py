"""The way over the ground on a root bone, on the hips, or taken out: what is seen is the same, but for the way."""

from __future__ import annotations

import json
from typing import Any

import bpy
import numpy as np
import pytest
from footwork.operators.bake import REPORT
from mathutils import Euler
from test_before import posed, whole
from test_control_rigs import FRAMES, control_rig, heads, plain_rig
from test_proof import make_rig

BODY = ("Hips", "Head", "LeftWrist", "RightAnkle", "LeftToe")


def bake(scene: bpy.types.Scene, obj: bpy.types.Object, travel: str) -> dict[str, Any]:
    scene.footwork.rig, scene.footwork.recording_to, scene.footwork.travel = obj, 2.5, travel
    assert bpy.ops.footwork.bake() == {"FINISHED"}
    report = json.loads(bpy.data.texts[REPORT].as_string())
    assert report["proof"]["bone"] == "" and report["proof"]["position_mm"] < 1.0
    return report


def roots(obj: bpy.types.Object, scene: bpy.types.Scene, name: str) -> tuple[np.ndarray, np.ndarray]:
    """World places `(N, 3)` of a root bone and how it turned since rest, about the world's axes `(N, 3, 3)`."""
    places, turns = [], []
    rest = np.array((obj.matrix_world @ obj.data.bones[name].matrix_local).to_3x3().normalized())
    for frame in FRAMES:
        scene.frame_set(frame)
        shown = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
        matrix = shown.matrix_world @ shown.pose.bones[name].matrix
        places.append(matrix.to_translation()[:])
        turns.append(np.array(matrix.to_3x3().normalized()) @ rest.T)
    return np.array(places), np.array(turns)


@pytest.mark.parametrize(("make", "root"), [(make_rig, "Root"), (control_rig, "root")])
def test_the_root_goes_below_the_body_and_the_body_is_the_same(empty, ready, make, root: str) -> None:
    obj = make(empty)
    obj.rotation_euler = Euler((0.0, 0.0, 0.8))
    bpy.context.view_layer.update()
    bake(empty, obj, "hips")
    expected = heads(obj, empty, BODY)
    still, _ = roots(obj, empty, root)
    assert np.ptp(still, axis=0).max() < 1e-5
    bake(empty, obj, "root")
    np.testing.assert_allclose(heads(obj, empty, BODY), expected, atol=1e-3)
    rest_hips = obj.matrix_world @ obj.data.bones["Hips"].head_local
    rest_root = obj.matrix_world @ obj.data.bones[root].head_local
    places, turns = roots(obj, empty, root)
    np.testing.assert_allclose(places[:, 2], rest_root.z, atol=1e-4)
    np.testing.assert_allclose(turns[:, 2], np.tile([0.0, 0.0, 1.0], (len(FRAMES), 1)), atol=1e-5)
    # where the body at rest would be if it went with the root
    below = places + turns @ (np.array(rest_hips) - np.array(rest_root))
    assert np.linalg.norm(below[:, :2] - expected[:, 0, :2], axis=-1).max() < 0.08
    assert np.linalg.norm(places[-1] - places[0]) > 0.3


def test_in_place_the_body_stays_where_it_starts(empty, ready) -> None:
    obj = plain_rig(empty)
    bake(empty, obj, "hips")
    expected = heads(obj, empty, BODY)
    bake(empty, obj, "in-place")
    found = heads(obj, empty, BODY)
    away = found - expected
    assert np.ptp(away, axis=1).max() < 1e-4 and np.abs(away[..., 2]).max() < 1e-4
    assert np.linalg.norm(found[:, 0, :2] - found[0, 0, :2], axis=-1).max() < 0.1
    assert np.linalg.norm(expected[-1, 0, :2] - expected[0, 0, :2]) > 0.3


def test_a_rig_without_a_root_cannot_carry_the_way(empty, ready) -> None:
    ready.rig, ready.travel = plain_rig(empty), "root"
    with pytest.raises(RuntimeError, match="no bone above the hips can carry the way"):
        bpy.ops.footwork.bake()


def test_a_root_with_keys_is_cleared_too(empty, ready) -> None:
    obj = posed(empty)
    before = whole(obj)
    ready.rig, ready.recording_to, ready.travel = obj, 2.5, "root"
    assert bpy.ops.footwork.bake() == {"FINISHED"}
    empty.frame_set(12)
    assert bpy.ops.footwork.clear_bake() == {"FINISHED"}
    assert whole(obj) == before


@pytest.mark.parametrize("how", ["RANGE", "STRIP"])
def test_a_root_with_keys_in_a_layer(empty, ready, how: str) -> None:
    obj = control_rig(empty)
    obj.pose.bones["root"].location = (0.5, 0.0, 0.2)
    obj.pose.bones["Head"].keyframe_insert("rotation_quaternion", frame=1)
    ready.frame_start, ready.write = 31, how
    bake(empty, obj, "root")
    empty.frame_set(1)
    assert obj.pose.bones["root"].location[:] == pytest.approx((0.5, 0.0, 0.2))
    empty.frame_set(100)
    assert obj.pose.bones["root"].location[:] != pytest.approx((0.5, 0.0, 0.2), abs=0.01)

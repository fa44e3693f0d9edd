"""Blender's own evaluation of the keyed bones on real rigs, in a process of its own."""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(importlib.util.find_spec("bpy") is None, reason="no Blender module here")

SCRIPT = """
import json, os, sys
import bpy, numpy as np
from mathutils import Matrix
from footwork.bridge.armature import armature_to_rig, create_armature
from footwork.core.maths import quat
from footwork.core.mocap.demo import demo_skeleton
from footwork.core.body.motion import Motion
from footwork.core.rig.fit import fit_rig, rig_from_skeleton
from footwork.core.rig.keys import to_bone_tracks

def check(obj, place):
    obj.matrix_world = place @ obj.matrix_world
    obj.animation_data_clear()
    bpy.context.view_layer.update()
    before = np.array(obj.matrix_world)
    fit = fit_rig(armature_to_rig(obj))
    skeleton, rng = fit.skeleton, np.random.default_rng(1)
    turned = quat.normalize(rng.normal(size=(3, len(skeleton), 4)))
    motion = Motion(skeleton, 60.0, rng.normal(size=(3, 3)), quat.continuous(turned))
    tracks = to_bone_tracks(motion, fit, 60.0)
    wanted = motion.forward()[0]
    worst = 0.0
    for bone in obj.pose.bones:
        bone.rotation_mode = "QUATERNION"
    for frame in range(3):
        obj.pose.bones[tracks.bones[0]].location = tracks.locations[frame]
        for name, rotation in zip(tracks.bones, tracks.rotations[frame]):
            obj.pose.bones[name].rotation_quaternion = rotation
        bpy.context.view_layer.update()
        heads = np.array([obj.matrix_world @ obj.pose.bones[name].head for name in skeleton.names])
        worst = max(worst, float(np.abs(heads - wanted[frame]).max()))
    return {
        "worst": worst, "moved": float(np.abs(np.array(obj.matrix_world) - before).max()),
        "standing": skeleton.tpose_positions().tolist(), "roles": skeleton.roles,
    }

place = Matrix.Translation((1, 2, 0)) @ Matrix.Rotation(0.7, 4, "Z") @ Matrix.Scale(1.3, 4)
out = {}
for path in sys.argv[2:]:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    load = bpy.ops.import_scene.fbx if path.endswith("fbx") else bpy.ops.import_scene.gltf
    load(filepath=path)
    rig = next(obj for obj in bpy.data.objects if obj.type == "ARMATURE")
    out[os.path.basename(path)] = check(rig, place)
own = create_armature(rig_from_skeleton(demo_skeleton(), "own"), "own", bpy.context.scene.collection)
out["own"] = check(own, Matrix())
with open(sys.argv[1], "w") as file:
    json.dump(out, file)
sys.stdout.flush()
os._exit(0)
"""


def evaluate(folder: Path, *rigs: Path) -> dict[str, dict]:
    """What Blender finds on each rig, by file name."""
    script, result = folder / "check.py", folder / "result.json"
    script.write_text(SCRIPT)
    env = {**os.environ, "BLENDER_USER_RESOURCES": str(folder)}
    command = [sys.executable, str(script), str(result), *map(str, rigs)]
    done = subprocess.run(command, env=env, capture_output=True, text=True, timeout=120, check=False)
    assert result.exists(), done.stdout[-2000:] + done.stderr[-2000:]
    return json.loads(result.read_text())


def test_our_own_armature_follows_in_blender(tmp_path: Path) -> None:
    found = evaluate(tmp_path)["own"]
    assert found["worst"] < 1e-4 and found["moved"] == 0.0


def test_real_rigs_follow_in_blender(tmp_path: Path, data: Path) -> None:
    names = ("mixamo_ybot.fbx", "rocketbox_male_biped.fbx", "readyplayerme.glb")
    found = evaluate(tmp_path, *(data / "rigs" / name for name in names))
    for name in names:
        rig = found[name]
        assert rig["worst"] < 1e-4, name
        assert rig["moved"] == 0.0, name
        standing = dict(zip(rig["roles"], rig["standing"], strict=True))
        # a person 1.3 times as tall as usual, toes near the floor, the left side at -X
        assert 1.9 < standing["head"][2] < 2.3, name
        assert -0.02 < standing["toe.L"][2] < 0.07, name
        assert standing["hand.L"][0] < -0.6 and standing["toe.R"][1] > 0.1, name

"""Recordings from the animated objects of files, as the command line reads them."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from footwork.bridge.importing import read_scene_recording
from footwork.bridge.objects import show_recording
from footwork.core.errors import InputError
from footwork.core.mocap.demo import demo_motion
from footwork.core.recording.mounts import DEVICE_MOUNTS
from footwork.core.recording.simulate import simulate_recording


@pytest.fixture
def walk(empty):
    """Someone who walks and turns, as three empties and one at the waist that hangs on the headset."""
    recording = simulate_recording(demo_motion("turn", 3), "turn", DEVICE_MOUNTS)
    empty.frame_start, empty.frame_end = 1, len(recording)
    empties = show_recording(recording, empty)
    waist = bpy.data.objects.new("waist tracker", None)
    empty.collection.objects.link(waist)
    waist.parent, waist.location = empties[0], (0.0, 0.0, -0.7)
    return recording


@pytest.mark.parametrize("kind", ["blend", "fbx", "glb"])
def test_objects_of_a_file_are_a_recording(walk, tmp_path, kind) -> None:
    path = str(tmp_path / f"trackers.{kind}")
    if kind == "blend":
        bpy.ops.wm.save_as_mainfile(filepath=path)
    elif kind == "fbx":
        bpy.ops.export_scene.fbx(
            filepath=path,
            object_types={"EMPTY"},
            bake_anim_use_all_actions=False,
            bake_anim_use_nla_strips=False,
        )
    else:
        bpy.ops.export_scene.gltf(filepath=path, export_format="GLB", export_animation_mode="SCENE")
    found = read_scene_recording(path)
    assert [item.name for item in found.extra] == ["waist tracker"]
    assert found.times[-1] == pytest.approx(walk.times[-1], abs=0.05)
    count = min(len(found), len(walk))
    apart = np.linalg.norm(found.positions[:count] - walk.positions[:count], axis=-1)
    assert np.median(apart) < 0.002
    assert abs(found.eye_height - walk.eye_height) < 0.1


def test_a_file_without_trackers_is_refused(empty, tmp_path) -> None:
    path = str(tmp_path / "nothing.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    with pytest.raises(InputError, match="no animated object of its scene is called head"):
        read_scene_recording(path)

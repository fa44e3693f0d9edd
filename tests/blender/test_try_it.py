"""Try It: an avatar that moves, from an empty scene and an empty folder."""

import json
import time

import bpy
import helpers
import numpy as np
import pytest
from footwork.bridge import compat
from footwork.bridge.places import free_place
from footwork.operators.bake import REPORT
from footwork.panels.start import FOOTWORK_PT_start


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    return tmp_path_factory.mktemp("kept")


def box(size: float, x: float, height: float = 2.0):
    mesh = bpy.data.meshes.new("Box")
    corners = [(x + a * size / 2, b * size / 2, c * height) for a in (-1, 1) for b in (-1, 1) for c in (0, 1)]
    mesh.from_pydata(corners, [], [(0, 1, 3, 2), (4, 5, 7, 6)])
    obj = bpy.data.objects.new("Box", mesh)
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.update()


def test_from_nothing_to_a_moving_mannequin(empty, kept, monkeypatch) -> None:
    monkeypatch.setenv("FOOTWORK_PRESETS", str(kept))
    box(2.0, 0.0)
    assert FOOTWORK_PT_start.poll(bpy.context)
    start = time.perf_counter()
    assert bpy.ops.footwork.try_it() == {"FINISHED"}
    assert time.perf_counter() - start < 60.0
    footwork = empty.footwork
    rig = footwork.rig
    (body,) = [obj for obj in rig.children if obj.type == "MESH"]
    assert len(body.data.vertices) > 5000 and len(body.material_slots) == 2
    assert rig.animation_data.action.name == "example"
    assert footwork.recording_state == "OK" and footwork.recording_path.endswith("example.csv")
    assert not FOOTWORK_PT_start.poll(bpy.context)
    report = json.loads(bpy.data.texts[REPORT].as_string())
    assert {item["name"] for item in report["inputs"] if item["kind"] == "database"} >= {"starter_upright"}
    assert report["metrics"]["hand_position_error_cm"]["mean"] < 0.2
    assert report["warnings"] == []
    # it walks, beside the box, and crouches
    heads = []
    for frame in range(empty.frame_start, empty.frame_end + 1, 12):
        empty.frame_set(frame)
        heads.append(helpers.world_heads(rig, ("Head",))[0])
    heads = np.array(heads)
    assert heads[:, 0].min() > 1.2
    assert np.ptp(heads[:, 1]) > 3.0
    assert heads[:, 2].min() < 1.2 and heads[:, 2].max() > 1.4


def test_a_second_time_makes_a_second_one_beside_it(empty, kept, monkeypatch) -> None:
    monkeypatch.setenv("FOOTWORK_PRESETS", str(kept))
    bpy.ops.footwork.try_it()
    first = empty.footwork.rig
    bpy.ops.footwork.try_it()
    second = empty.footwork.rig
    assert second != first and first.animation_data.action != second.animation_data.action
    empty.frame_set(1)
    apart = [helpers.world_heads(rig, ("Hips",))[0][0] for rig in (first, second)]
    assert apart[1] - apart[0] > 1.0
    assert len(compat.fcurves_of(first)) == len(compat.fcurves_of(second))


def test_a_folder_that_cannot_be_written_is_told_in_one_line_and_nothing_is_made(
    empty, tmp_path, monkeypatch
) -> None:
    (tmp_path / "file").write_text("a file")
    monkeypatch.setenv("FOOTWORK_PRESETS", str(tmp_path / "file"))
    with pytest.raises(RuntimeError, match="file") as told:
        bpy.ops.footwork.try_it()
    assert len(str(told.value).strip().splitlines()) == 1
    assert not empty.footwork.recording_path and not bpy.data.armatures and not bpy.data.actions


def test_places_beside_what_stands_in_the_scene(empty) -> None:
    assert free_place(empty).position[0] == 0.0
    box(50.0, 0.0)  # a landscape
    box(4.0, 0.0, 0.01)  # a floor
    assert free_place(empty).position[0] == 0.0
    box(2.0, 3.0)
    assert free_place(empty).position[0] == pytest.approx(5.2)

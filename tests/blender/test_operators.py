"""The whole work through operators, as a script or a button runs it, on procedural takes."""

from __future__ import annotations

import importlib.util
import json
import runpy
from pathlib import Path

import bpy
import helpers
import numpy as np
import pytest
from footwork.bridge import armature, compat
from footwork.core.database.sidecar import load_database
from footwork.core.mocap.bvh import write_bvh
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.export import to_bvh
from footwork.core.recording import formats
from footwork.operators import figures, job_operator
from footwork.operators import recording as recording_operators
from footwork.operators.bake import REPORT
from helpers import add_takes, files


def test_takes_are_added_once_and_looked_at(empty, demo, tmp_path) -> None:
    (tmp_path / "broken.bvh").write_text("HIERARCHY\nnonsense")
    add_takes(demo, "walk.bvh", "turn.bvh")
    add_takes(demo, "walk.bvh")
    add_takes(tmp_path, "broken.bvh")
    takes = empty.footwork.takes
    assert [(take.name, take.state) for take in takes] == [
        ("walk", "OK"),
        ("turn", "OK"),
        ("broken", "FAULT"),
    ]
    assert takes[0].seconds > 5.0 and "\t" in takes[0].found
    assert "line" in takes[2].doubts or ":" in takes[2].doubts
    empty.footwork.take_index = 2
    bpy.ops.footwork.move_take(step=-1)
    assert [take.name for take in takes] == ["walk", "broken", "turn"] and empty.footwork.take_index == 1
    bpy.ops.footwork.remove_take()
    assert [take.name for take in takes] == ["walk", "turn"]
    bpy.ops.footwork.clear_takes()
    assert not takes


def test_building_writes_a_database_and_lists_it(empty, demo, tmp_path) -> None:
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "shot.blend"))
    scene = bpy.context.scene
    add_takes(demo, "walk.bvh", "turn.bvh")
    scene.footwork.takes[1].use = False
    scene.footwork.database_settings.mirror = True
    scene.footwork.database_tags = "walk, demo"
    bpy.ops.footwork.build_database()
    made = load_database(tmp_path / "shot_database.npz")
    assert {clip.name for clip in made.clips} >= {"walk"} and made.tags == ("walk", "demo")
    assert any(clip.mirrored for clip in made.clips) and not any(
        c.name.startswith("turn") for c in made.clips
    )
    (row,) = scene.footwork.databases
    assert row.path == "//shot_database.npz" and row.name == made.name and row.found
    bpy.ops.footwork.build_database()
    assert len(scene.footwork.databases) == 1


def test_a_database_of_other_people_is_built_on_the_skeleton_of_the_first(empty, demo, tmp_path) -> None:
    first, second, child = tmp_path / "first.npz", tmp_path / "second.npz", tmp_path / "child.bvh"
    add_takes(demo, "walk.bvh")
    bpy.ops.footwork.build_database(filepath=str(first))
    write_bvh(child, to_bvh(demo_motion("walk", height=1.2), "child"))
    bpy.ops.footwork.clear_takes()
    add_takes(tmp_path, "child.bvh")
    empty.footwork.database_skeleton = str(first)
    bpy.ops.footwork.build_database(filepath=str(second))
    ours, theirs = load_database(first).skeleton, load_database(second).skeleton
    np.testing.assert_array_equal(ours.offsets, theirs.offsets)
    empty.footwork.database_skeleton = str(tmp_path / "none.npz")
    with pytest.raises(RuntimeError, match=r"none\.npz"):
        bpy.ops.footwork.build_database(filepath=str(second))


def test_parts_of_a_take_are_left_out(empty, demo, tmp_path) -> None:
    add_takes(demo, "walk.bvh")
    bpy.ops.footwork.build_database(filepath=str(tmp_path / "whole.npz"))
    empty.footwork.takes[0].leave_out = "0-1.5, 8-"
    bpy.ops.footwork.build_database(filepath=str(tmp_path / "part.npz"))
    whole, part = load_database(tmp_path / "whole.npz"), load_database(tmp_path / "part.npz")
    assert len(part) == pytest.approx(6.5 * 60, abs=2) and len(whole) > len(part)
    empty.footwork.takes[0].leave_out = "two seconds"
    with pytest.raises(RuntimeError, match="two seconds"):
        bpy.ops.footwork.build_database(filepath=str(tmp_path / "part.npz"))


@pytest.mark.parametrize("source", ["FILE", "OBJECTS"])
def test_a_bake_without_a_rig_makes_one(empty, ready, source: str) -> None:
    if source == "OBJECTS":
        bpy.ops.footwork.show_recording()
        empty.frame_end = 600
        ready.recording_source = source
    assert bpy.ops.footwork.bake() == {"FINISHED"}
    rig = ready.rig
    assert rig.type == "ARMATURE" and rig.animation_data.action is not None
    assert len(compat.fcurves_of(rig)) > 60
    report = json.loads(bpy.data.texts[REPORT].as_string())
    assert report["metrics"]["root_error_cm"]["mean"] < 30.0
    assert len(ready.figures) > 5 and rig.name in ready.figures_of
    over_time = figures.read_over_time(ready.over_time)
    assert len(over_time.rows) == len(figures.shown_in("graph")) >= 3 and over_time.fps == 60
    assert np.nanmean(over_time.rows[0].values) == pytest.approx(
        report["metrics"]["nsm_skate_cm_s"]["mean"], rel=0.2
    )
    frames = int(compat.fcurves_of(rig)[0].range()[1])
    assert empty.frame_end == frames
    # the head follows the headset in Blender's own evaluation
    empty.frame_set(frames // 2)
    head = helpers.world_heads(rig, (armature.role_map(rig)["head"],))[0]
    feet = helpers.world_heads(rig, tuple(armature.role_map(rig)[f"foot.{side}"] for side in "LR"))
    assert 1.0 < head[2] < 2.0 and feet[:, 2].min() < 0.2 and np.abs(feet).max() < 20.0


def test_a_bake_without_a_database_uses_the_starter_motion(empty, ready, tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("FOOTWORK_PRESETS", str(tmp_path))
    ready.databases.clear()
    assert bpy.ops.footwork.bake() == {"FINISHED"}
    report = json.loads(bpy.data.texts[REPORT].as_string())
    used = [item["name"] for item in report["inputs"] if item["kind"] == "database"]
    assert len(used) == 4 and all(name.startswith("starter_") for name in used)
    assert len(list((tmp_path / "starter").glob("*.npz"))) == 4


def test_baking_twice_keeps_or_replaces(empty, ready) -> None:
    bpy.ops.footwork.bake()
    first = ready.rig.animation_data.action
    bpy.ops.footwork.bake()
    assert first.use_fake_user and ready.rig.animation_data.action != first
    ready.keep_previous = False
    bpy.ops.footwork.bake()
    assert len(bpy.data.actions) == 2


def test_options_of_the_output(empty, ready) -> None:
    ready.action_name, ready.frame_start, ready.fit_range, ready.markers = "Take 5", 101, False, False
    before = (empty.frame_start, empty.frame_end)
    bpy.ops.footwork.bake()
    action = ready.rig.animation_data.action
    assert action.name == "Take 5" and not action.pose_markers
    assert compat.fcurves_of(ready.rig)[0].range()[0] == 101 and before == (
        empty.frame_start,
        empty.frame_end,
    )


def test_a_part_of_the_recording_is_baked(empty, ready) -> None:
    ready.recording_from, ready.recording_to = 2.0, 5.0
    bpy.ops.footwork.bake()
    assert empty.frame_end == 181
    ready.recording_from = 900.0
    with pytest.raises(RuntimeError, match="choose a longer part"):
        bpy.ops.footwork.bake()


def test_bakes_are_the_same_twice(empty, ready) -> None:
    bpy.ops.footwork.bake()
    values = []
    for _ in range(2):
        bpy.ops.footwork.bake()
        curves = compat.fcurves_of(ready.rig)
        values.append([tuple(key.co) for curve in curves[:9] for key in curve.keyframe_points])
    assert values[0] == values[1]


def test_height_ranges_of_the_list_are_used(empty, ready) -> None:
    ready.databases[0].height_low, ready.databases[0].height_high = 0.4, 0.2
    with pytest.raises(RuntimeError, match="height range is empty"):
        bpy.ops.footwork.bake()


def test_bad_input_raises_and_writes_nothing(empty, ready, tmp_path) -> None:
    before = (len(bpy.data.actions), len(bpy.data.armatures), len(bpy.data.texts))
    ready.recording_path = str(tmp_path / "gone.csv")
    with pytest.raises(RuntimeError, match=r"gone\.csv"):
        bpy.ops.footwork.bake()
    assert before == (len(bpy.data.actions), len(bpy.data.armatures), len(bpy.data.texts))
    with pytest.raises(RuntimeError, match=r"gone\.csv"):
        bpy.ops.footwork.load_recording(filepath=str(tmp_path / "gone.csv"))
    assert ready.recording_state == "FAULT"
    (tmp_path / "fake.npz").write_bytes(b"no database")
    with pytest.raises(RuntimeError, match=r"fake\.npz"):
        bpy.ops.footwork.add_database(directory=str(tmp_path), files=files("fake.npz"))


def test_disabled_buttons_say_why(empty) -> None:
    for operator, reason in (
        ("build_database", "Add takes first"),
        ("bake", "Choose a recording first"),
        ("remove_take", "no take"),
        ("remove_database", "no database"),
        ("show_recording", "Choose a recording file first"),
        ("reset_roles", "Pick a rig first"),
        ("use_active_rig", "Select an armature first"),
        ("cancel_job", "Nothing is running"),
    ):
        with pytest.raises(RuntimeError, match=reason):
            getattr(bpy.ops.footwork, operator)()


def test_file_operators_want_a_file(empty) -> None:
    for operator in ("add_takes", "import_take", "add_database"):
        with pytest.raises(RuntimeError, match="No file chosen"):
            getattr(bpy.ops.footwork, operator)()


def test_takes_are_shown_all_or_none(empty, demo, tmp_path) -> None:
    (tmp_path / "broken.bvh").write_text("HIERARCHY\nnonsense")
    (tmp_path / "walk.bvh").write_bytes((demo / "walk.bvh").read_bytes())
    with pytest.raises(RuntimeError, match=r"broken\.bvh"):
        bpy.ops.footwork.import_take(directory=str(tmp_path), files=files("walk.bvh", "broken.bvh"))
    assert not bpy.data.objects and not bpy.data.actions


def test_one_job_at_a_time(empty, ready, monkeypatch) -> None:
    monkeypatch.setattr(job_operator, "running", job_operator.Running("footwork.bake", "Baking"))
    with pytest.raises(RuntimeError, match="Baking is still running"):
        bpy.ops.footwork.bake()


def test_a_dropped_take_becomes_an_armature(empty, demo) -> None:
    empty.render.fps = 24
    bpy.ops.footwork.import_take(directory=str(demo), files=files("walk.bvh"))
    obj = bpy.context.object
    assert obj.name == "walk" and obj.select_get()
    frames = compat.fcurves_of(obj)[-1].range()[1]
    from footwork.core.mocap.takes import load_take

    take = load_take(demo / "walk.bvh", 24.0)
    assert frames == pytest.approx(len(take.motion), abs=1)
    expected, _ = take.motion.forward()
    bones = take.motion.skeleton.names
    for frame in (0, len(take.motion) // 2, len(take.motion) - 1):
        empty.frame_set(1 + frame)
        assert np.abs(helpers.world_heads(obj, bones) - expected[frame]).max() < 1e-4


def test_the_file_handlers_take_their_files() -> None:
    for name, extension in (("takes", ".bvh"), ("import_take", ".bvh"), ("recording", ".csv")):
        handler = getattr(bpy.types, f"FOOTWORK_FH_{name}")
        assert extension in handler.bl_file_extensions
        module, operator = handler.bl_import_operator.split(".")
        assert getattr(getattr(bpy.ops, module), operator).get_rna_type()


def test_a_format_of_the_registry_is_in_the_dialog_and_can_be_dropped(monkeypatch) -> None:
    assert bpy.types.FOOTWORK_FH_recording.bl_file_extensions == ";".join(formats.suffixes())
    toy = formats.Format("Toy", lambda content: False, lambda content, file: None, (".toy",))
    monkeypatch.setattr(formats, "FORMATS", (*formats.FORMATS, toy))
    # the registered classes stay as they are: the module runs once more under another name
    spec = importlib.util.spec_from_file_location(
        f"{recording_operators.__name__}_again", recording_operators.__file__
    )
    again = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(again)
    assert ".toy" in again.FOOTWORK_FH_recording.bl_file_extensions.split(";")
    shown = again.FOOTWORK_OT_load_recording.__annotations__["filter_glob"].keywords["default"]
    assert {"*.toy", "*.csv"} <= set(shown.split(";"))


def test_the_example_job_runs(demo, recording, tmp_path, monkeypatch) -> None:
    script = Path(__file__).parents[2] / "docs" / "example_job.py"
    takes = [str(demo / name) for name in ("walk.bvh", "turn.bvh")]
    output = tmp_path / "baked.blend"
    arguments = ["--takes", *takes, "--recording", str(recording), "--output", str(output)]
    monkeypatch.setattr("sys.argv", ["blender", "--", *arguments])
    runpy.run_path(str(script), run_name="__main__")
    assert output.is_file() and output.with_suffix(".npz").is_file()
    bpy.ops.wm.open_mainfile(filepath=str(output))
    assert bpy.context.scene.footwork.rig.animation_data.action is not None

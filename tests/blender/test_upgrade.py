"""Scenes and preferences that an older Footwork saved.

`old_scene_N.blend` was made with the code before the step from version N to N + 1, in Blender 4.2, by
`make_old_scene.py`; the JSON beside it holds the values that were set, every one beside its default.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import addon_utils
import bpy
import pytest
from footwork.properties import upgrade
from footwork.properties.preferences import ADD_ON
from make_old_scene import read

HERE = Path(__file__).parent
NOW = len(upgrade.SCENE_STEPS)
OLD = sorted(HERE.glob("old_scene_*.blend"))
FIRST = str(HERE / "old_scene_0.blend")


def values_of(path: Path) -> dict[str, Any]:
    """What was set in an old file, under today's names."""
    values = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
    version, scene = int(path.stem.rpartition("_")[2]), values["scene"]
    scene.pop("version", None)
    if version < 1:
        scene["overlays"] = {"graph": scene.pop("show_graph")}
        scene["bake"]["feet"] = "planted" if scene["bake"].pop("foot_lock") else "matched"
    return values


def assert_within(expected: Any, found: Any, where: str) -> None:
    """Every value of `expected` is in `found`, which may have more."""
    if isinstance(expected, dict):
        for name, value in expected.items():
            assert_within(value, found[name], f"{where}.{name}")
    elif isinstance(expected, list):
        assert len(expected) == len(found), where
        for number, value in enumerate(expected):
            assert_within(value, found[number], f"{where}[{number}]")
    else:
        assert found == pytest.approx(expected), where


@pytest.mark.parametrize("path", OLD, ids=lambda path: path.stem)
def test_every_value_of_an_old_scene_arrives(empty, path: Path) -> None:
    bpy.ops.wm.open_mainfile(filepath=str(path))
    footwork = bpy.context.scene.footwork
    assert footwork.version == NOW
    expected = values_of(path)
    assert len(expected["scene"]) > 40 and len(expected["scene"]["takes"]) == 3
    assert_within(expected["scene"], read(footwork), "scene.footwork")
    assert_within(expected["roles"], read(footwork.rig.footwork), "rig.footwork")


def test_old_values_are_moved_once(empty, tmp_path) -> None:
    bpy.ops.wm.open_mainfile(filepath=FIRST)
    footwork = bpy.context.scene.footwork
    assert not footwork.overlays.graph and "show_graph" not in upgrade.stored(footwork)
    footwork.overlays.graph = True
    for _ in range(2):
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "new.blend"))
        bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "new.blend"))
    assert bpy.context.scene.footwork.overlays.graph and bpy.context.scene.footwork.version == NOW


def test_what_was_at_its_default_stays_there(empty) -> None:
    upgrade.to_scene_1(empty.footwork)
    assert not empty.footwork.overlays.is_property_set("graph")


@pytest.mark.parametrize(("locked", "feet"), [(False, "matched"), (True, "planted")])
def test_own_presets_of_an_older_version_still_count(empty, tmp_path, locked: bool, feet: str) -> None:
    bake = empty.footwork.bake
    bake.feet = "planted" if feet == "matched" else "matched"
    preset = tmp_path / "mine.py"
    lines = ["import bpy", "settings = bpy.context.scene.footwork.bake", f"settings.foot_lock = {locked}"]
    preset.write_text("\n".join([*lines, "settings.unlock_distance = 0.375"]))
    bpy.ops.script.execute_preset(filepath=str(preset), menu_idname="FOOTWORK_PT_bake_presets")
    assert (bake.feet, bake.unlock_distance) == (feet, 0.375)
    assert "foot_lock" not in bake.bl_rna.properties and upgrade.stored(bake).get("foot_lock") is None


def test_what_was_set_since_is_kept(empty) -> None:
    upgrade.stored(empty.footwork)["show_graph"] = 0
    empty.footwork.overlays.graph = True
    upgrade.upgrade_all()
    assert empty.footwork.overlays.graph and "show_graph" not in upgrade.stored(empty.footwork)


def test_saved_scenes_have_a_version_and_untouched_ones_nothing_of_ours(empty, tmp_path) -> None:
    empty.footwork.frame_start = 7
    bpy.data.scenes.new("Untouched")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "new.blend"))
    assert empty.footwork.version == NOW
    assert not bpy.data.scenes["Untouched"].is_property_set("footwork")


@pytest.mark.parametrize("link", [False, True])
def test_a_scene_of_an_old_file_is_upgraded_in_a_new_one(empty, tmp_path, link: bool) -> None:
    with bpy.data.libraries.load(FIRST, link=link) as (there, here):
        here.scenes = there.scenes
    (scene,) = here.scenes
    if not hasattr(bpy.app.handlers, "blend_import_post"):
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "with_it.blend"))
    assert scene.footwork.version == NOW and not scene.footwork.overlays.graph


def test_a_file_that_is_open_when_the_extension_is_enabled(empty) -> None:
    addon_utils.disable(ADD_ON)
    bpy.ops.wm.open_mainfile(filepath=FIRST)
    addon_utils.enable(ADD_ON)
    # with a window a timer does it at once; without one timers do not run, and the first operator does it
    assert bpy.app.timers.is_registered(upgrade.upgrade_all)
    bpy.ops.footwork.explain_figure(index=0)
    assert not bpy.context.scene.footwork.overlays.graph


def test_a_later_step_is_one_entry(empty, monkeypatch) -> None:
    def to_next(footwork) -> None:
        upgrade.move(footwork, "speed", footwork, "frame_start", lambda speed: speed * 10)

    monkeypatch.setattr(upgrade, "SCENE_STEPS", (*upgrade.SCENE_STEPS, to_next))
    empty.footwork.version = NOW
    upgrade.stored(empty.footwork)["speed"] = 3
    upgrade.upgrade_all()
    assert empty.footwork.frame_start == 30 and empty.footwork.version == NOW + 1


def test_preferences_have_steps_of_their_own(empty, monkeypatch) -> None:
    preferences = bpy.context.preferences.addons[ADD_ON].preferences
    steps = (lambda old: upgrade.move(old, "python", old, "training_python", str),)
    monkeypatch.setattr(upgrade, "PREFERENCES_STEPS", steps)
    preferences.version = 0
    preferences.property_unset("training_python")
    upgrade.stored(preferences)["python"] = "/opt/python"
    for _ in range(2):
        upgrade.upgrade_all()
        assert preferences.training_python == "/opt/python" and preferences.version == 1
        upgrade.stored(preferences)["python"] = "/other"
    del upgrade.stored(preferences)["python"]
    for name in ("version", "training_python"):
        preferences.property_unset(name)

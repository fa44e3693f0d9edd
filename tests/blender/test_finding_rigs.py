"""Rigs that are not plainly in the open scene, and role maps that are kept for every scene."""

from __future__ import annotations

import json
from pathlib import Path

import bpy
import helpers
import pytest
from footwork.bridge import armature
from footwork.bridge.load import armature_of
from footwork.core import presets
from footwork.core.errors import InputError
from footwork.core.mocap.families import KIND
from footwork.core.rig.fit import rig_from_skeleton


def rig(name: str, numbered: bool = False) -> bpy.types.Object:
    made = rig_from_skeleton(helpers.skeleton(), name)
    obj = armature.create_armature(made, name, bpy.context.scene.collection)
    if numbered:
        for number, bone in enumerate(obj.data.bones):
            bone.name = f"{'xyzq'[number % 4]}_{7 * number:03d}"
    return obj


def test_a_rig_of_another_scene_is_found(empty) -> None:
    obj = rig("hero")
    other = bpy.data.scenes.new("Shot")
    other.collection.objects.link(obj)
    empty.collection.objects.unlink(obj)
    try:
        assert armature_of(Path("a.blend"), "") == obj
        assert bpy.context.scene == other
    finally:
        bpy.context.window.scene = empty


def test_a_rig_that_is_only_instanced_is_named(empty) -> None:
    obj = rig("hero")
    held = bpy.data.collections.new("Char")
    held.objects.link(obj)
    empty.collection.objects.unlink(obj)
    shown = bpy.data.objects.new("Placed", None)
    shown.instance_type, shown.instance_collection = "COLLECTION", held
    empty.collection.objects.link(shown)
    for name in ("", "hero"):
        with pytest.raises(
            InputError, match="armature hero is only in the collection Char that Placed instances"
        ):
            armature_of(Path("a.blend"), name)


def test_linked_rigs_of_one_name_are_named(empty, tmp_path: Path) -> None:
    obj = rig("hero")
    for name in ("one.blend", "two.blend"):
        bpy.data.libraries.write(str(tmp_path / name), {obj})
    bpy.data.objects.remove(obj)
    for name in ("one.blend", "two.blend"):
        with bpy.data.libraries.load(str(tmp_path / name), link=True) as (_, here):
            here.objects = ["hero"]
        empty.collection.objects.link(here.objects[0])
    with pytest.raises(InputError, match=r"2 armatures are called 'hero' .*one.blend.*two.blend"):
        armature_of(Path("a.blend"), "hero")


def test_a_map_made_in_the_panel_counts_in_every_scene(empty, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setenv(presets.VARIABLE, str(tmp_path / "mine"))
    (tmp_path / "mine").mkdir()
    obj = rig("odd one", numbered=True)
    wanted = dict(zip([bone.name for bone in obj.data.bones], helpers.skeleton().roles, strict=True))
    wanted = {role: bone for bone, role in wanted.items()}
    armature.set_roles(obj, wanted)
    bpy.context.scene.footwork.rig = obj
    assert bpy.ops.footwork.keep_roles() == {"FINISHED"}
    (kept,) = presets.user_folder(KIND).glob("*.json")
    assert json.loads(kept.read_text())["joints"]["shin.R"] == wanted["shin.R"]
    bpy.ops.wm.read_homefile(use_empty=True)
    fresh = rig("another", numbered=True)
    assert armature.detected_preset(fresh) == ("odd one", ())
    found = armature.detected_roles(fresh)
    assert {role: found[role] for role in wanted} == wanted


def test_a_linked_character_is_baked_in_the_shot(empty, ready, tmp_path: Path) -> None:
    held = bpy.data.collections.new("Hero")
    empty.collection.children.link(held)
    obj = rig("hero")
    held.objects.link(obj)
    empty.collection.objects.unlink(obj)
    bpy.data.libraries.write(str(tmp_path / "hero.blend"), {held})
    bpy.data.objects.remove(obj)
    bpy.data.collections.remove(held)
    with bpy.data.libraries.load(str(tmp_path / "hero.blend"), link=True) as (_, here):
        here.collections = ["Hero"]
    empty.collection.children.link(here.collections[0])
    linked = bpy.data.objects["hero"]
    assert linked.library is not None
    ready.rig, ready.recording_to = linked, 1.0
    assert bpy.ops.footwork.bake() == {"FINISHED"}
    made = ready.rig
    assert made.library is None and made.override_library.reference == linked
    assert made.animation_data.action is not None and linked.animation_data is None
    heads = []
    for frame in (1, 60):
        empty.frame_set(frame)
        heads.append(helpers.world_heads(made, ("Head", "LeftWrist")))
    assert abs(heads[1] - heads[0]).max() > 0.01

"""The registry of exports: an entry is all that a kind of file needs."""

from __future__ import annotations

import bpy
import helpers
import numpy as np
import pytest
from footwork.bridge import compat, exports
from footwork.bridge.exports import Export
from footwork.cli import main
from footwork.core.mocap.takes import load_take
from test_proof import make_rig

READ_BACK = {".fbx": bpy.ops.import_scene.fbx, ".glb": bpy.ops.import_scene.gltf}
"""What reads the kinds of files that Footwork itself does not read."""


def help_of_bake(capsys) -> str:
    assert main(["bake", "--help"]) == 0
    return " ".join(capsys.readouterr().out.split())


def bake(database, recording, output, *more: str) -> int:
    inputs = [str(recording), "--database", str(database), "--search", "greedy"]
    return main(["bake", *inputs, "--to", "2", "-o", str(output), *more])


def test_an_entry_adds_a_kind_of_file(database, recording, tmp_path, monkeypatch, capsys) -> None:
    def write(baked, path) -> None:
        curves = compat.fcurves_of(baked.armature)
        path.write_text(f"{baked.armature.name} {len(curves)} {len(baked.motion)} {baked.fps}")

    others = exports.in_words()
    assert "FBX (.fbx)" in others and "toy" not in help_of_bake(capsys)
    monkeypatch.setattr(exports, "EXPORTS", (*exports.EXPORTS, Export(".toy", "Toy Train", write)))
    assert f"{others.replace(' or ', ', ')} or Toy Train (.toy)" in help_of_bake(capsys)
    out = tmp_path / "run.TOY"
    assert bake(database, recording, tmp_path / "run.blend", "--export", str(out)) == 0
    name, curves, frames, fps = out.read_text().rsplit(" ", 3)
    assert name in bpy.data.objects and int(curves) > 60 and float(fps) == 60.0 and int(frames) == 121


def test_other_kinds_are_refused_before_any_work(database, recording, tmp_path, capsys) -> None:
    output = tmp_path / "run.blend"
    assert bake(database, recording, output, "--export", str(tmp_path / "run.toy")) == 2
    assert "run.toy: cannot export to this kind of file; use FBX (.fbx)" in capsys.readouterr().err
    assert not output.exists()


@pytest.mark.parametrize("export", exports.EXPORTS, ids=lambda export: export.suffix)
def test_each_kind_is_written(database, recording, tmp_path, export) -> None:
    out = tmp_path / f"run{export.suffix}"
    # the importer of glTF in Blender 4.2 now and then crashes on a mesh with weights
    bare = ("--no-body",) if bpy.app.version < (4, 5) else ()
    assert bake(database, recording, tmp_path / "run.blend", *bare, "--export", str(out)) == 0
    if export.suffix == ".bvh":
        assert len(load_take(out).motion) == pytest.approx(121, abs=1)
        return
    bpy.ops.wm.read_homefile(use_empty=True)
    READ_BACK[export.suffix](filepath=str(out))
    assert "ARMATURE" in {obj.type for obj in bpy.data.objects} and bpy.data.actions


@pytest.mark.parametrize("kind", [".fbx", ".glb"])
@pytest.mark.parametrize("engine", ["", "unreal", "unity", "godot"])
def test_clips_read_back_are_where_the_bake_is(database, recording, tmp_path, kind: str, engine: str) -> None:
    """From their first frame on, with deforming bones alone for engines, and the way on the root."""
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.context.scene.render.fps = 60
    obj = make_rig(bpy.context.scene)
    obj.data.bones["Root"].use_deform = True
    helper = obj.data.bones["LeftToe"].name
    obj.data.bones[helper].use_deform = False
    other = bpy.data.actions.new("Other")
    track = obj.animation_data_create().nla_tracks.new()
    track.strips.new("Other", 5, other)
    track.mute = True
    rig, out, clip = str(tmp_path / "rig.blend"), tmp_path / "run.blend", tmp_path / f"run{kind}"
    bpy.ops.wm.save_as_mainfile(filepath=rig)
    more = ["--engine", engine] if engine else []
    assert bake(database, recording, out, "--rig", rig, "--export", str(clip), *more) == 0
    bpy.ops.wm.open_mainfile(filepath=str(out))
    names = ("Root", "Hips", "Head", "LeftWrist", "RightAnkle")
    person, frames = bpy.data.objects["Person"], (1, 2, 60, 120)
    assert [t.mute for t in person.animation_data.nla_tracks] == [True]
    expected = places(person, names, frames)
    assert (np.linalg.norm(expected[-1, 0] - expected[0, 0]) > 0.1) == bool(engine)
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.context.scene.render.fps = 60
    READ_BACK[kind](filepath=str(clip))
    found = next(o for o in bpy.data.objects if o.type == "ARMATURE")
    (made,) = bpy.data.actions
    start = round(made.frame_range[0])
    assert start == (1 if kind == ".fbx" else 0) and made.frame_range[1] - start == 120
    np.testing.assert_allclose(places(found, names, [f + start - 1 for f in frames]), expected, atol=1e-4)
    assert ("LeftToe" in found.data.bones) != bool(engine)


def places(obj, names, frames) -> np.ndarray:
    out = []
    for frame in frames:
        bpy.context.scene.frame_set(frame)
        out.append(helpers.world_heads(obj, names))
    return np.array(out)

"""A baked file finds the textures and libraries of its rig, from whatever folder it lies in."""

from __future__ import annotations

from pathlib import Path

import bpy
import pytest
from footwork.cli import main


@pytest.fixture
def rig(database, recording, tmp_path) -> Path:
    """A rig's file with a texture and a linked material, both by relative paths."""
    folder = tmp_path / "rigs" / "hero"
    (folder / "textures").mkdir(parents=True)
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.data.materials.new("Skin").use_fake_user = True
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "materials.blend"))
    path = folder / "hero.blend"
    inputs = [str(recording), "--database", str(database), "--search", "greedy", "--to", "1"]
    assert main(["bake", *inputs, "-o", str(path)]) == 0
    bpy.ops.wm.open_mainfile(filepath=str(path))
    image = bpy.data.images.new("Face", 4, 4)
    image.filepath_raw, image.file_format = str(folder / "textures" / "face.png"), "PNG"
    image.save()
    image.filepath_raw, image.use_fake_user = "//textures/face.png", True
    with bpy.data.libraries.load(str(folder / "materials.blend"), link=True, relative=True) as (_, here):
        here.materials = ["Skin"]
    mesh = bpy.data.meshes.new("Body")
    mesh.materials.append(bpy.data.materials["Skin"])
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("Body", mesh))
    bpy.ops.wm.save_mainfile()
    return path


@pytest.mark.parametrize("folder", ["rigs/hero", "rigs", "bakes/monday/morning"])
def test_textures_and_libraries_are_found(rig, database, recording, tmp_path, folder: str) -> None:
    output = tmp_path / folder / "walk.blend"
    output.parent.mkdir(parents=True, exist_ok=True)
    inputs = [str(recording), "--database", str(database), "--search", "greedy", "--to", "1"]
    assert main(["bake", *inputs, "--rig", str(rig), "-o", str(output)]) == 0
    bpy.ops.wm.open_mainfile(filepath=str(output))
    stored = {"texture": bpy.data.images["Face"].filepath, "library": bpy.data.libraries[0].filepath}
    for path in stored.values():
        assert path.startswith("//") and Path(bpy.path.abspath(path)).is_file(), stored
    assert bpy.data.materials["Skin"].library is not None

"""The zip that users get: what is in it, and that it leaves nothing behind."""

from __future__ import annotations

import os
import tomllib
import zipfile
from pathlib import Path

import addon_utils
import bpy
import pytest

ROOT = Path(__file__).parents[2]
MODULE = "bl_ext.user_default.footwork"
REQUIRED = {
    "schema_version",
    "id",
    "version",
    "name",
    "tagline",
    "maintainer",
    "type",
    "blender_version_min",
    "license",
}
OPTIONAL = {
    "blender_version_max",
    "website",
    "copyright",
    "tags",
    "platforms",
    "wheels",
    "permissions",
    "build",
}


@pytest.fixture(scope="module")
def names() -> set[str]:
    with zipfile.ZipFile(os.environ["FOOTWORK_ZIP"]) as file:
        return set(file.namelist())


def test_the_manifest_has_no_unknown_keys() -> None:
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))
    assert set(manifest) - OPTIONAL == REQUIRED
    assert len(manifest["tagline"]) <= 64 and manifest["tagline"][-1].isalnum()
    assert set(manifest["permissions"]) == {"files"}
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert manifest["version"] == project["version"]


def test_the_zip_holds_the_extension_and_nothing_else(names) -> None:
    tops = {name.partition("/")[0] for name in names}
    packages = {"core", "nn", "bridge", "cli", "properties", "operators", "panels", "presets"}
    files = {"blender_manifest.toml", "__init__.py", "__main__.py", "LICENSE", "README.md"}
    assert packages <= tops and tops <= packages | files
    assert not [name for name in names if "__pycache__" in name or name.endswith((".pyc", ".bvh", ".fbx"))]
    for folder in packages - {"presets"}:
        for path in (ROOT / folder).rglob("*.py"):
            assert path.relative_to(ROOT).as_posix() in names


def leftovers() -> dict[str, object]:
    """Whatever Blender holds of Footwork."""
    handlers = {
        name: [
            str(function) for function in getattr(bpy.app.handlers, name) if "footwork" in function.__module__
        ]
        for name in dir(bpy.app.handlers)
        if isinstance(getattr(bpy.app.handlers, name), list)
    }
    return {
        "types": [name for name in dir(bpy.types) if "footwork" in name.lower()],
        "operators": list(dir(bpy.ops.footwork)),
        "properties": [
            (kind, prop.identifier)
            for kind in ("Scene", "Object", "Armature", "WindowManager", "Action")
            for prop in getattr(bpy.types, kind).bl_rna.properties
            if "footwork" in prop.identifier
        ],
        "handlers": [entry for entries in handlers.values() for entry in entries],
    }


def test_it_comes_and_goes_twice_without_leftovers(empty) -> None:
    present = leftovers()
    assert present["types"] and present["operators"] and len(present["properties"]) == 2
    for _ in range(2):
        addon_utils.disable(MODULE)
        assert not any(leftovers().values())
        addon_utils.enable(MODULE)
        assert addon_utils.check(MODULE)[1] and leftovers() == present


def test_scenes_keep_their_settings_while_it_is_away(empty, tmp_path) -> None:
    empty.footwork.bake.alpha = 0.25
    empty.footwork.takes.add().name = "walk"
    path = str(tmp_path / "kept.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    addon_utils.disable(MODULE)
    bpy.ops.wm.open_mainfile(filepath=path)
    bpy.ops.wm.save_mainfile()
    addon_utils.enable(MODULE)
    bpy.ops.wm.open_mainfile(filepath=path)
    kept = bpy.context.scene.footwork
    assert kept.bake.alpha == pytest.approx(0.25) and kept.takes[0].name == "walk"

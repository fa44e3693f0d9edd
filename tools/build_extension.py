"""Build the extension's zip with Blender's own packaging script and validate it; prints the zip's path."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path

import bpy

ROOT = Path(__file__).parents[1]


def packager() -> Path:
    """Blender's command-line packager, which comes with the bpy module."""
    path = Path(bpy.utils.system_resource("SCRIPTS")) / "addons_core" / "bl_pkg" / "cli" / "blender_ext.py"
    if not path.is_file():
        sys.exit("this bpy has no extension packager")
    return path


def build(folder: Path = ROOT / "dist") -> Path:
    """The zip in `folder`, built and validated."""
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))
    target = folder / f"{manifest['id']}-{manifest['version']}.zip"
    folder.mkdir(exist_ok=True)
    target.unlink(missing_ok=True)
    command = [sys.executable, str(packager())]
    subprocess.run(
        [*command, "build", "--source-dir", str(ROOT), "--output-filepath", str(target)],
        check=True,
        timeout=120,
    )
    subprocess.run([*command, "validate", str(target)], check=True, timeout=120)
    return target


if __name__ == "__main__":
    print(build())

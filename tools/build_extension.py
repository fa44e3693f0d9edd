"""Build the extension's zip with Blender's own packaging script and validate it; prints the zip's path."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path

import bpy

ROOT = Path(__file__).parents[1]


def packager() -> Path:
    """Blender's command-line packager inside the bpy module."""
    found = sorted(Path(bpy.__file__).parent.glob("*/scripts/addons_core/bl_pkg/cli/blender_ext.py"))
    if not found:
        sys.exit("this bpy has no extension packager")
    return found[0]


def build() -> Path:
    """The zip in `dist/`, built and validated."""
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))
    target = ROOT / "dist" / f"{manifest['id']}-{manifest['version']}.zip"
    target.parent.mkdir(exist_ok=True)
    target.unlink(missing_ok=True)
    command = [sys.executable, str(packager())]
    subprocess.run(
        [*command, "build", "--source-dir", str(ROOT), "--output-filepath", str(target)], check=True, timeout=120
    )
    subprocess.run([*command, "validate", str(target)], check=True, timeout=120)
    return target


if __name__ == "__main__":
    print(build())

from __future__ import annotations

import tomllib
from pathlib import Path

from footwork.core import VERSION

ROOT = Path(__file__).parents[2]


def test_one_version_everywhere() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text("utf-8"))
    assert project["project"]["version"] == manifest["version"] == VERSION

"""Tests inside Blender: collected only when run.py runs them on the installed extension."""

from __future__ import annotations

import os

import pytest

if os.environ.get("FOOTWORK_BLENDER_TESTS") != "1":
    collect_ignore_glob = ["test_*.py"]


@pytest.fixture
def empty():
    """An empty scene at 60 frames per second, with the extension enabled."""
    import bpy

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=False)
    scene = bpy.context.scene
    scene.render.fps, scene.render.fps_base = 60, 1.0
    return scene

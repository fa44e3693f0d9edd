"""Tests inside Blender: collected only when run.py runs them on the installed extension."""

from __future__ import annotations

import os
from pathlib import Path

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


@pytest.fixture(scope="session")
def database(demo, tmp_path_factory) -> Path:
    """A database of procedural takes, built by its operator."""
    import bpy
    import helpers

    bpy.ops.wm.read_homefile(use_empty=True)
    helpers.add_takes(demo, "walk.bvh", "turn.bvh", "sidestep.bvh", "visit.bvh")
    path = tmp_path_factory.mktemp("database") / "walking.npz"
    assert bpy.ops.footwork.build_database(filepath=str(path)) == {"FINISHED"}
    return path


@pytest.fixture(scope="session")
def recording(demo, tmp_path_factory) -> Path:
    """A recording simulated from a procedural take, by its operator."""
    import bpy
    import helpers

    bpy.ops.wm.read_homefile(use_empty=True)
    helpers.add_takes(demo, "visit.bvh")
    path = tmp_path_factory.mktemp("recording") / "visit.csv"
    assert bpy.ops.footwork.simulate_recording(filepath=str(path)) == {"FINISHED"}
    return path


@pytest.fixture
def ready(database, recording, empty):
    """A scene in which only Bake is left to press."""
    import bpy
    import helpers

    footwork = empty.footwork
    bpy.ops.footwork.add_database(directory=str(database.parent), files=helpers.files(database.name))
    bpy.ops.footwork.load_recording(filepath=str(recording))
    footwork.predictor = "HEADSET"
    return footwork

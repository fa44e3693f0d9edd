"""The list of databases: each row's own range, switch and place count."""

from __future__ import annotations

import json
import shutil

import bpy
import helpers
import numpy as np
import pytest
from footwork.core.database.sidecar import load_database
from footwork.core.jobs import run
from footwork.core.recording.read import read_recording
from footwork.core.recording.resample import resample
from footwork.operators import bake
from footwork.operators.bake import REPORT

RANGES = {"unused": (0.0, 2.0), "low": (0.0, 0.81), "high": (0.94, 1.9), "middle": (0.81, 0.94)}
"""Of four rows; the files say 0 to 2 each."""


@pytest.fixture
def rows(ready, database, tmp_path):
    """A scene whose list has four databases, the first of them switched off."""
    bpy.ops.footwork.remove_database()
    for name in RANGES:
        shutil.copy(database, tmp_path / f"{name}.npz")
        bpy.ops.footwork.add_database(directory=str(tmp_path), files=helpers.files(f"{name}.npz"))
        assert load_database(tmp_path / f"{name}.npz").height_range == (0.0, 2.0)
    for row, (low, high) in zip(ready.databases, RANGES.values(), strict=True):
        row.height_low, row.height_high = low, high
    ready.databases[0].use = False
    return ready


def test_every_row_plays_at_the_heights_that_it_says(rows, recording) -> None:
    source = bake.read_source(bpy.context.scene)
    assert [path.rsplit("/", 1)[-1] for path, _ in source.databases] == ["low.npz", "high.npz", "middle.npz"]
    assert [span for _, span in source.databases] == [RANGES[name] for name in ("low", "high", "middle")]
    played = run(bake.bake_job(source)).playback.database
    user = resample(read_recording(recording), 60.0)
    ratio = user.positions[:, 0, 2] / user.eye_height
    for index, name in enumerate(("low", "high", "middle")):
        low, high = RANGES[name]
        # what lies within the margin of a border may play on
        inside = (ratio > low + 0.025) & (ratio < high - 0.025)
        assert inside.sum() > 5 and (played[inside] == index).all()


def test_the_order_of_the_rows_decides_where_ranges_meet(rows) -> None:
    for row in rows.databases:
        row.height_low, row.height_high = 0.0, 2.0
    for first in ("low", "middle"):
        rows.database_index = [first in row.path for row in rows.databases].index(True)
        while rows.database_index > 1:
            bpy.ops.footwork.move_database(step=-1)
        source = bake.read_source(bpy.context.scene)
        assert f"{first}.npz" in source.databases[0][0]
        assert (run(bake.bake_job(source)).playback.database == 0).all()


def test_the_report_names_what_was_used(rows) -> None:
    bpy.ops.footwork.bake()
    report = json.loads(bpy.data.texts[REPORT].as_string())
    assert [row["kind"] for row in report["inputs"]] == ["recording", *["database"] * 3]
    assert np.isfinite(report["metrics"]["root_error_cm"]["mean"])


def test_an_empty_range_is_refused_by_the_name_of_its_row(rows) -> None:
    rows.databases[2].height_low = 1.9
    with pytest.raises(RuntimeError, match=f"{rows.databases[2].name}: its height range is empty"):
        bpy.ops.footwork.bake()
    rows.databases[2].use = False
    assert bpy.ops.footwork.bake() == {"FINISHED"}


def test_a_take_given_twice_is_doubted_once(demo, tmp_path, empty, capsys) -> None:
    again = tmp_path / "again.bvh"
    again.write_bytes((demo / "walk.bvh").read_bytes())
    helpers.add_takes(demo, "walk.bvh", "turn.bvh")
    helpers.add_takes(tmp_path, "again.bvh")
    assert bpy.ops.footwork.build_database(filepath=str(tmp_path / "twice.npz")) == {"FINISHED"}
    told = capsys.readouterr()
    assert (told.out + told.err).count("counts twice") == 1

"""The mapping assistant as an operator: corrections given by a script are kept and used."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from footwork.core.mocap.demo import demo_motion
from footwork.core.recording.mounts import DEVICE_MOUNTS
from footwork.core.recording.reading.kept import maps
from footwork.core.recording.recording import TRACKERS
from footwork.core.recording.simulate import simulate_recording

PARTS = ("px", "py", "pz", "qw", "qx", "qy", "qz")
MEANINGS = ("time", *(f"{tracker}.{part}" for tracker in TRACKERS for part in PARTS))


@pytest.fixture
def nameless(tmp_path, monkeypatch):
    """A table of names that say nothing, and a folder of presets."""
    monkeypatch.setenv("FOOTWORK_PRESETS", str(tmp_path / "own"))
    walk = simulate_recording(demo_motion("turn", 3), "turn", DEVICE_MOUNTS)
    poses = np.concatenate([walk.positions, walk.rotations], axis=-1).reshape(len(walk), -1)
    header = ",".join(["note", *(f"u{place}" for place in range(22))])
    path = tmp_path / "nameless.csv"
    rows = [",".join(["a", *(f"{value:.7f}" for value in row)]) for row in np.c_[walk.times, poses]]
    path.write_text("\n".join([header, *rows, ""]))
    return path


def _column(name: str, said: str) -> dict[str, str]:
    """As Blender wants an item of a list: with every property."""
    return {"name": name, "example": "", "before": "", "said": said}


def test_corrections_are_kept_and_the_recording_is_read(empty, nameless) -> None:
    footwork = empty.footwork
    with pytest.raises(RuntimeError, match="no known recording format"):
        bpy.ops.footwork.load_recording(filepath=str(nameless))
    footwork.recording_path = str(nameless)
    said = [_column(f"u{place}", text) for place, text in enumerate(MEANINGS)]
    with pytest.raises(RuntimeError, match="none of time"):
        bpy.ops.footwork.map_recording(columns=[_column("u0", "head.foo")], kept_name="Mine")
    assert not maps().entries
    footwork.reading.axes = "RFU"
    assert bpy.ops.footwork.map_recording(columns=said, kept_name="Mine") == {"FINISHED"}
    assert [entry.name for entry in maps().entries] == ["Mine"]
    assert footwork.recording_state in ("OK", "DOUBT")
    assert "Mine" in footwork.recording_found

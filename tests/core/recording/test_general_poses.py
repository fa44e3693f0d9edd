"""Every reader on devices that turn about general axes, each in its own way, written by scipy in the file's axes."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from footwork.core import presets
from footwork.core.recording.read import read_recording
from footwork.core.recording.recording import Recording
from scipy.spatial.transform import Rotation

FRAMES, FPS = 150, 60.0
AXES = {"R": (1, 0, 0), "L": (-1, 0, 0), "F": (0, 1, 0), "B": (0, -1, 0), "U": (0, 0, 1), "D": (0, 0, -1)}
METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001}
SHIPPED = {
    "questset": ("RUB", "m", "s"),
    "unity_hmd_left_right": ("RUF", "m", "ms"),
    "who_is_alyx": ("RUB", "cm", "ms"),
    "who_is_alyx_controllers": ("RUB", "cm", "ms"),
}
"""Axes and units of the recorders, by what they are: OpenXR and OpenVR, Unity, SteamVR in centimetres."""
SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}


@pytest.fixture(scope="module")
def poses(tumble) -> tuple[np.ndarray, np.ndarray]:
    """Positions `(T, 3, 3)` and rotations `(T, 3, 4)` of three devices, in metres and Footwork's axes."""
    times = np.arange(FRAMES)[:, None, None] / FPS
    centre = np.array([[0.3, -0.2, 1.62], [-0.15, 0.21, 1.13], [0.52, 0.34, 0.97]])
    rate, phase = np.random.default_rng(5).uniform(1.0, 3.0, (2, 3, 3))
    return centre + 0.11 * np.sin(rate * times + 2.0 * phase), tumble(FRAMES, FPS, count=3, seed=8)


def in_axes(poses: tuple[np.ndarray, np.ndarray], axes: str) -> tuple[np.ndarray, list[list[Rotation]]]:
    """The same poses with x, y and z along `axes`, by matrices: positions, and rotations `[frame][device]`.

    The matrix of a turn between mirrored axes is a turn as well: M R M^T.
    """
    change = np.array([AXES[letter] for letter in axes], dtype=np.float64)
    positions, rotations = poses
    matrices = Rotation.from_quat(np.roll(rotations, -1, axis=-1).reshape(-1, 4)).as_matrix()
    turned = (change @ matrices @ change.T).reshape(FRAMES, 3, 3, 3)
    return positions @ change.T, [[Rotation.from_matrix(m) for m in row] for row in turned]


def assert_read(found: Recording, poses: tuple[np.ndarray, np.ndarray], atol: float = 1e-6) -> None:
    positions, rotations = poses
    assert len(found) == FRAMES and found.valid.all()
    np.testing.assert_allclose(found.times, np.arange(FRAMES) / FPS, atol=1e-3)
    shift = np.zeros(3)
    if "relative to the start" in " ".join(found.doubts):
        shift[2] = found.positions[0, 0, 2] - positions[0, 0, 2]
    np.testing.assert_allclose(found.positions - shift, positions, atol=atol)
    cosine = np.abs(np.sum(found.rotations * rotations, axis=-1))
    assert np.degrees(2.0 * np.arccos(np.minimum(cosine, 1.0))).max() < 0.1
    assert (np.sum(found.rotations[1:] * found.rotations[:-1], axis=-1) > 0.0).all()


def bsor(poses: tuple[np.ndarray, np.ndarray]) -> bytes:
    """Unity's axes, x y z w."""
    positions, turns = in_axes(poses, "RUF")
    head = struct.pack("<IBB", 0x442D3D69, 1, 0)
    head += b"".join(struct.pack("<i", 1) + b"t" for _ in range(13)) + struct.pack("<i", 9)
    head += b"".join(struct.pack("<i", 1) + b"m" for _ in range(3))
    head += struct.pack("<fBffff", 0, 0, 0, 0, 0, 0) + struct.pack("<Bi", 1, FRAMES)
    rows = [
        struct.pack("<fi", i / FPS, 60)
        + b"".join(struct.pack("<7f", *positions[i, k], *turns[i][k].as_quat()) for k in range(3))
        for i in range(FRAMES)
    ]
    return head + b"".join(rows)


def aframe(poses: tuple[np.ndarray, np.ndarray]) -> bytes:
    """WebXR's axes, degrees in the order YXZ."""
    positions, turns = in_axes(poses, "RUB")
    tracks = {}
    for k, key in enumerate(("camera", "left", "right")):
        tracks[key] = {"poses": []}
        for i in range(FRAMES):
            y, x, z = turns[i][k].as_euler("YXZ", degrees=True)
            place = dict(zip("xyz", positions[i, k].tolist(), strict=True))
            pose = {"position": place, "rotation": {"x": x, "y": y, "z": z}, "timestamp": 1000.0 * i / FPS}
            tracks[key]["poses"].append(pose)
    return json.dumps(tracks).encode()


def own(poses: tuple[np.ndarray, np.ndarray]) -> bytes:
    """Footwork's own table, its columns in another order than it writes them."""
    positions, turns = in_axes(poses, "RFU")
    names = [f"{device}_{part}" for device in ("right", "head", "left") for part in PARTS]
    lines = ["# footwork-recording 1", "# eye_height: 1.65", ",".join([*names, "time"])]
    for i in range(FRAMES):
        cells: list[float] = []
        for k in (2, 0, 1):
            x, y, z, w = turns[i][k].as_quat()
            cells += [*positions[i, k], z, 1, w, y, x]
        lines.append(",".join(f"{cell:.9g}" for cell in [*cells, i / FPS]))
    return "\n".join(lines).encode()


LAYOUTS = sorted((presets.SHIPPED / "recording_layouts").glob("*.json"))
PARTS = ("px", "py", "pz", "qz", "valid", "qw", "qy", "qx")


@pytest.mark.parametrize("write", [bsor, aframe, own])
def test_devices_are_where_they_were_and_turned_as_they_were(
    tmp_path: Path, poses: tuple[np.ndarray, np.ndarray], write: Callable[..., bytes]
) -> None:
    (tmp_path / "recording.dat").write_bytes(write(poses))
    assert_read(read_recording(tmp_path / "recording.dat"), poses)


@pytest.mark.parametrize(
    "path", sorted((presets.SHIPPED / "recording_layouts").glob("*.json")), ids=lambda path: path.stem
)
def test_tables_of_every_layout(tmp_path: Path, poses: tuple[np.ndarray, np.ndarray], path: Path) -> None:
    """By the meaning of the column names: what stands for w, x, y and z is their last letter."""
    layout = json.loads(path.read_text())
    layout["axes"], layout["unit"], layout["time_unit"] = SHIPPED[path.stem]
    assert_read(table(tmp_path, poses, layout), poses)


@pytest.mark.parametrize(
    ("axes", "unit", "time_unit"), [("BLD", "mm", "us"), ("UFL", "cm", "ns"), ("FUR", "m", "s")]
)
def test_tables_in_any_axes_and_units(
    tmp_path: Path,
    poses: tuple[np.ndarray, np.ndarray],
    axes: str,
    unit: str,
    time_unit: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    folder = tmp_path / "recording_layouts"
    folder.mkdir()
    layout = {
        "name": "any",
        "time": "t",
        "time_unit": time_unit,
        "unit": unit,
        "axes": axes,
        "on_floor": True,
    }
    for device in ("head", "left", "right"):
        layout[device] = {
            "position": [f"{device} place {axis}" for axis in "xyz"],
            "rotation": [f"{device} turn {axis}" for axis in "wxyz"],
        }
    (folder / "any.json").write_text(json.dumps(layout))
    monkeypatch.setenv(presets.VARIABLE, str(tmp_path))
    assert_read(table(tmp_path, poses, layout), poses)


def table(folder: Path, poses: tuple[np.ndarray, np.ndarray], layout: dict) -> Recording:
    """A table in a layout, read again; its columns backwards, among others that mean nothing."""
    positions, turns = in_axes(poses, layout["axes"])
    columns = {layout["time"]: np.arange(FRAMES) / FPS / SECONDS[layout["time_unit"]] + 5.0}
    for k, device in enumerate(("head", "left", "right")):
        xyzw = np.array([turns[i][k].as_quat() for i in range(FRAMES)])
        for name in layout[device]["position"]:
            columns[name] = positions[:, k, "xyz".index(name[-1].lower())] / METRES[layout["unit"]]
        for name in layout[device]["rotation"]:
            columns[name] = xyzw[:, "xyzw".index(name[-1].lower())]
    names = [*reversed(columns), "battery"]
    rows = zip(*[columns.get(name, np.full(FRAMES, 7.0)) for name in names], strict=True)
    lines = [",".join(names), *(",".join(f"{cell:.12g}" for cell in row) for row in rows)]
    (folder / "table.csv").write_text("\n".join(lines))
    return read_recording(folder / "table.csv")

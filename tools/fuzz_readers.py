"""The readers that are fuzzed: a sound file of each kind, and what is done with a file that was read.

A new reader is one entry in `readers`.
"""

from __future__ import annotations

import json
import os
import random
import shutil
import struct
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from footwork.cli.common import read_report
from footwork.core import presets
from footwork.core.body.edit import resample as resample_motion
from footwork.core.bounds import EYE_HEIGHT, FARTHEST
from footwork.core.database.build import build_database
from footwork.core.database.describe import describe_database
from footwork.core.database.motion_database import MotionDatabase
from footwork.core.database.sidecar import load_database, save_database
from footwork.core.errors import InputError
from footwork.core.evaluation.compare import check_report, compare_reports, comparison_in_words
from footwork.core.jobs import run
from footwork.core.json_text import parse_json, to_json
from footwork.core.maths import quat
from footwork.core.measure.words import report_in_words
from footwork.core.mocap import families
from footwork.core.mocap.bvh import format_bvh
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.export import to_bvh
from footwork.core.mocap.families import NamingFamily, read_family
from footwork.core.mocap.take import Take
from footwork.core.mocap.takes import load_take
from footwork.core.pipeline import bake
from footwork.core.recording import layouts
from footwork.core.recording.body_estimate import BodyEstimate
from footwork.core.recording.csv_format import write_csv
from footwork.core.recording.cut import cut
from footwork.core.recording.layouts import TableLayout, read_layout
from footwork.core.recording.read import read_recording, to_recording
from footwork.core.recording.reading.kept import RecordingMap, check_said, read_map
from footwork.core.recording.recording import Recording
from footwork.core.recording.resample import resample
from footwork.core.recording.simulate import simulate_recording
from footwork.core.settings import BakeSettings, DatabaseSettings
from footwork.nn.inputs import INPUTS, Scaler
from footwork.nn.network import Network
from footwork.nn.predictor import headset_forward, load_predictor, predict
from footwork.nn.train.checkpoint import Checkpoint, Progress, read_checkpoint, write_checkpoint
from footwork.nn.weights import Predictor, save_predictor
from fuzz_changes import change_json, change_npz, change_replay, change_text
from fuzz_mvnx import format_mvnx
from fuzz_verbs import WITH_BPY

Change = Callable[[random.Random, bytes], bytes]


@dataclass(frozen=True, slots=True)
class Reader:
    """One kind of file: how sound ones look, how they are changed, and what is done with them."""

    name: str
    suffix: str
    sound: bytes
    change: Callable[[random.Random, bytes], bytes]
    read: Callable[[Path], Any]
    carry: Callable[[Any, Path], None]
    """All that a user would do with what was read; the path is where it was."""
    verbs: tuple[str, ...] = ()
    """Commands that read it, as `run_verb` takes them."""


def check(condition: bool, what: str) -> None:
    """Nonsense that was let in is a fault, too."""
    if not condition:
        raise AssertionError(f"nonsense accepted: {what}")


def short_motion():
    """Two and a half seconds of a walk."""
    motion = resample_motion(demo_motion("walk"), 30.0)
    return replace(motion, positions=motion.positions[:75], rotations=motion.rotations[:75])


MOTION = short_motion()
TRACKED = simulate_recording(MOTION, "walk")
SECOND = cut(TRACKED, 0.0, 1.0)
SETTINGS = DatabaseSettings(fps=30.0)
LONGEST_BAKED_S = 5.0
"""Of a recording: a small file can have long pauses in it, and a bake of all of that is work, not a fault."""
TAKE = Take("walk", "walk.bvh", "", MOTION, {}, ())
DATABASE = run(build_database([TAKE], SETTINGS, name="walk", tags=("upright",)))


def baked(
    recording: Recording, database: MotionDatabase, predict_with: Callable[[Recording], BodyEstimate]
) -> dict[str, Any]:
    """A bake's report, after a look at whether keys and report are in order."""
    result = run(bake(recording, [database], predict_with, None, BakeSettings(search="greedy")))
    tracks = result.tracks
    check(bool(np.isfinite(tracks.rotations).all()), "keys of rotations")
    check(float(np.abs(tracks.locations).max(initial=0.0)) < FARTHEST, "keys of locations")
    check_report(parse_json(to_json(result.report).encode()))
    report_in_words(result.report)
    return result.report


def carry_take(take: Take, path: Path) -> None:
    """To a recording, and to a database, which is kept, described, baked with and measured."""
    check(
        bool(np.isfinite(take.motion.rotations).all() and np.isfinite(take.motion.positions).all()), "a take"
    )
    recording = simulate_recording(take.motion, take.name)
    check(bool(np.isfinite(recording.positions).all()), "its trackers")
    made = path.with_suffix(".made.npz")
    save_database(made, run(build_database([take], SETTINGS, name="fuzz")))
    carry_database(load_database(made), path)


def carry_recording(recording: Recording, path: Path) -> None:
    """To an even rate and a measured bake."""
    even = resample(recording, 60.0)
    check(bool(np.isfinite(even.positions).all() and np.isfinite(even.rotations).all()), "a recording")
    check(EYE_HEIGHT[0] <= recording.eye_height <= EYE_HEIGHT[1], "an eye height")
    long = recording.times[-1] > LONGEST_BAKED_S
    baked(cut(recording, 0.0, LONGEST_BAKED_S) if long else recording, DATABASE, headset_forward)


def carry_database(database: MotionDatabase, path: Path) -> None:
    """To its description, and a measured bake."""
    to_json(describe_database(database))
    baked(SECOND, database, headset_forward)


def carry_predictor(predictor: Predictor, path: Path) -> None:
    """To directions, and a measured bake with them."""
    found = predict(predictor, TRACKED)
    check(bool(np.isfinite(found.yaws).all()), "directions")
    check(found.doubt is None or bool(np.isfinite(found.doubt).all()), "a doubt")
    baked(SECOND, DATABASE, lambda recording: predict(predictor, recording))


def carry_report(report: dict[str, Any], path: Path) -> None:
    """Beside itself and a sound one, both ways, in words."""
    sound = read_report(str(path.parent / "report.json"))
    for pair in ((report, report), (sound, report), (report, sound)):
        comparison = compare_reports(*pair)
        to_json(comparison)
        comparison_in_words(comparison)


def as_preset(path: Path, kind: str, use: Callable[[], None]) -> None:
    """Use a preset as the user's own."""
    own = presets.user_folder(kind) / path.name
    own.parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(path, own)
    try:
        use()
    finally:
        own.unlink()


def carry_layout(layout: TableLayout, path: Path) -> None:
    """To a recording of its table, and a bake."""

    def use() -> None:
        content = (path.parent / "table.csv").read_bytes()
        if not layouts.recognise(content, layout):
            raise InputError("table.csv: no table of this layout")
        raw = layouts.read_table(content, "table.csv", layout)
        carry_recording(to_recording(raw, "table.csv", ""), path)
        read_recording(path.parent / "table.csv")

    as_preset(path, layouts.KIND, use)


def carry_family(family: NamingFamily, path: Path) -> None:
    """To a take with such names, or with the names of those that ship, and all that follows."""
    as_preset(path, families.KIND, lambda: carry_take(load_take(path.parent / "t.bvh", 30.0), path))


def carry_checkpoint(checkpoint: Checkpoint, path: Path) -> None:
    """To the predictor that its training has come to, and a bake with it."""
    networks = (*checkpoint.progress.found, checkpoint.progress.best or checkpoint.network)
    made = path.with_suffix(".made.npz")
    save_predictor(made, Predictor("made", networks, checkpoint.scaler, None, 0.1, {}))
    carry_predictor(load_predictor(made), path)


def network(rng: np.random.Generator) -> Network:
    """A small one of the paper's kind."""
    sizes = ((INPUTS, 8), (8, 6))
    return Network(
        tuple(rng.normal(size=size).astype(np.float32) * 0.1 for size in sizes),
        tuple(rng.normal(size=size[1]).astype(np.float32) * 0.1 for size in sizes),
    )


def aframe() -> bytes:
    """The tracked walk as a browser records it."""
    change = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
    places = TRACKED.positions @ change.T
    matrices = change @ quat.to_matrix(TRACKED.rotations) @ change.T
    # Y, X, Z: the angles of R = Ry Rx Rz
    x = np.arcsin(np.clip(-matrices[..., 1, 2], -1.0, 1.0))
    y = np.arctan2(matrices[..., 0, 2], matrices[..., 2, 2])
    z = np.arctan2(matrices[..., 1, 0], matrices[..., 1, 1])
    turns = np.degrees(np.stack([x, y, z], axis=-1))
    data = {
        name: {
            "poses": [
                {
                    "timestamp": round(1000.0 * time, 3),
                    "position": dict(zip("xyz", place[i].round(5).tolist(), strict=True)),
                    "rotation": dict(zip("xyz", turn[i].round(4).tolist(), strict=True)),
                }
                for time, place, turn in zip(TRACKED.times.tolist(), places, turns, strict=True)
            ]
        }
        for i, name in enumerate(("camera", "left", "right"))
    }
    return json.dumps(data).encode()


def replay() -> bytes:
    """The tracked walk as a Beat Saber replay."""
    text = struct.pack("<i", 4) + b"walk"
    info = text * 13 + bytes(4) + text * 3 + bytes(struct.calcsize("<fBffff"))
    rotations = TRACKED.rotations[..., (1, 3, 2, 0)] * (-1.0, -1.0, -1.0, 1.0)
    poses = np.concatenate([TRACKED.positions[..., (0, 2, 1)], rotations], axis=-1)
    count = len(TRACKED.times)
    frames = np.zeros((count, 23), "<f4")
    frames[:, 0], frames[:, 2:] = TRACKED.times, poses.reshape(count, 21)
    return b"\x69\x3d\x2d\x44\x01\x00" + info + b"\x01" + struct.pack("<i", count) + frames.tobytes()


def table() -> bytes:
    """The tracked walk in the columns, units and axes of the layout that is changed."""
    data = json.loads(LAYOUT)
    names = [data["time"]]
    for tracker in ("head", "left", "right"):
        names += [*data[tracker]["position"], *data[tracker]["rotation"]]
    # right, up, backwards
    positions = TRACKED.positions[..., (0, 2, 1)] * (100.0, 100.0, -100.0)
    rotations = TRACKED.rotations[..., (0, 1, 3, 2)] * (1.0, 1.0, 1.0, -1.0)
    rows = np.concatenate([positions, rotations], axis=-1).reshape(len(TRACKED.times), -1)
    lines = [",".join(f"{value:.6f}" for value in row) for row in np.c_[TRACKED.times * 1e3, rows]]
    return "\n".join([",".join(names), *lines, ""]).encode()


def named(long: bool) -> bytes:
    """The tracked walk in Unity's axes, with columns of our own naming: wide, or one row a device."""
    positions = TRACKED.positions[..., (0, 2, 1)]
    rotations = TRACKED.rotations[..., (1, 3, 2, 0)] * (-1.0, -1.0, -1.0, 1.0)
    poses = np.concatenate([positions, rotations], axis=-1)
    parts = [f"{kind}{axis}" for kind, axes in (("pos", "XYZ"), ("rot", "XYZW")) for axis in axes]
    if long:
        lines = [
            ",".join([f"{time:.4f}", device, *(f"{value:.6f}" for value in pose)])
            for time, row in zip(TRACKED.times, poses, strict=True)
            for device, pose in zip(("HMD", "LeftController", "RightController"), row, strict=True)
        ]
        return "\n".join([",".join(["time", "device", *parts]), *lines, ""]).encode()
    names = [f"{tracker}_{part}" for tracker in ("camera", "leftHand", "rightHand") for part in parts]
    lines = [
        ";".join([f"{time:.4f}", *(f"{value:.6f}" for value in row.ravel())]).replace(".", ",")
        for time, row in zip(TRACKED.times, poses, strict=True)
    ]
    return "\n".join([";".join(["timestamp", *names]), *lines, ""]).encode()


def one_device(tracker: int) -> bytes:
    """A tracker of the walk in a table of its own, as folders have it."""
    positions = TRACKED.positions[:, tracker][:, (0, 2, 1)]
    rotations = TRACKED.rotations[:, tracker][:, (1, 3, 2, 0)] * (-1.0, -1.0, -1.0, 1.0)
    rows = np.c_[TRACKED.times, positions, rotations]
    lines = [",".join(f"{value:.6f}" for value in row) for row in rows]
    return "\n".join(["time,pos_x,pos_y,pos_z,rot_x,rot_y,rot_z,rot_w", *lines, ""]).encode()


def read_folder(path: Path) -> Recording:
    """A folder with a changed table of the headset and sound ones of the hands."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        shutil.copy(path, folder / "head_T001.csv")
        for place, hand in enumerate(("left", "right"), 1):
            (folder / f"{hand}hand_T001.csv").write_bytes(one_device(place))
        return read_recording(folder)


MAP = json.dumps(
    {
        "name": "own",
        "columns": ["a", "b", "c"],
        "said": {"a": "time", "b": "head.px", "c": "nothing"},
        "axes": "RUF",
        "rate": 72.0,
        "swap_hands": True,
    }
).encode()


def carry_map(found: RecordingMap, path: Path) -> None:
    """Every meaning can be told again, and the answers stand."""
    for text in found.said.values():
        check(check_said(text) == text, "a meaning is not kept as it is")
    found.answers.check()


def messages() -> bytes:
    """The tracked walk as messages of VMC."""
    positions = TRACKED.positions[..., (0, 2, 1)]
    rotations = TRACKED.rotations[..., (1, 3, 2, 0)] * (-1.0, -1.0, -1.0, 1.0)
    names = ("Hmd/Pos hmd", "Con/Pos left", "Con/Pos right")
    lines = [
        f"{time:.4f} /VMC/Ext/{name} " + " ".join(f"{value:.6f}" for value in pose)
        for time, row in zip(TRACKED.times, np.concatenate([positions, rotations], axis=-1), strict=True)
        for name, pose in zip(names, row, strict=True)
    ]
    return "\n".join([*lines, ""]).encode()


def objects() -> bytes:
    """The tracked walk as JSON of OpenXR's kind."""

    def pose(place: Any, turn: Any) -> dict[str, Any]:
        x, y, z = (float(value) for value in place)
        w, a, b, c = (float(value) for value in turn)
        return {
            "position": {"x": x, "y": z, "z": -y},
            "orientation": {"x": a, "y": c, "z": -b, "w": w},
        }

    frames = [
        {
            "time": float(time),
            **{name: pose(*of) for name, of in zip(NAMES, zip(*row, strict=True), strict=True)},
        }
        for time, *row in zip(TRACKED.times, TRACKED.positions, TRACKED.rotations, strict=True)
    ]
    return json.dumps({"runtime": "any", "frames": frames}).encode()


NAMES = ("view", "/user/hand/left", "/user/hand/right")


LAYOUT = (presets.SHIPPED / layouts.KIND / "who_is_alyx.json").read_bytes()
BONE_MAP = (presets.SHIPPED / families.KIND / "xsens.json").read_bytes()
BAKE = "--predictor headset --to 1 -o OUT/b.blend --json OUT/r.json"
TAKE_VERBS = (
    "build-database INPUT -o OUT/d.npz --fps 30 --json OUT/r.json",
    "evaluate INPUT --database d.npz --true-orientation --json OUT/r.json",
    "simulate-recording INPUT -o OUT/r.csv",
    "inspect INPUT --json OUT/r.json",
)
RECORDING_VERBS = (
    *([f"bake INPUT --database d.npz {BAKE}"] if WITH_BPY else []),
    "inspect INPUT --json OUT/r.json",
)
DATABASE_VERBS = (
    *([f"bake r.csv --database INPUT {BAKE}"] if WITH_BPY else []),
    "evaluate t.bvh --database INPUT --true-orientation --json OUT/r.json",
    "build-database t.bvh --skeleton INPUT --fps 30 -o OUT/e.npz",
    "database-info INPUT --json OUT/r.json",
)
PREDICTOR_VERBS = (
    *([f"bake r.csv --database d.npz {BAKE} --predictor INPUT"] if WITH_BPY else []),
    "evaluate t.bvh --database d.npz --predictor INPUT --json OUT/r.json",
    "evaluate-predictor t.bvh --predictor INPUT --json OUT/r.json",
)
REPORT_VERBS = (
    "compare-reports INPUT report.json --json OUT/r.json",
    "compare-reports report.json INPUT --fail-if-worse --tolerance 0.5 --json OUT/r.json",
    "evaluate t.bvh --database d.npz --true-orientation --against INPUT --json OUT/r.json",
)


def readers(folder: Path) -> list[Reader]:
    """Every reader, with a sound file of its kind; what verbs need besides is put into the folder."""
    os.environ[presets.VARIABLE] = str(folder / "presets")
    (folder / "presets").mkdir()
    rng = np.random.default_rng(4)
    save_database(folder / "d.npz", DATABASE)
    write_csv(folder / "r.csv", TRACKED)
    scaler = Scaler(rng.normal(size=INPUTS), rng.uniform(0.5, 2.0, INPUTS))
    predictor = Predictor("p", (network(rng),), scaler, None, 0.1, {"held_out_error_deg": 12.0})
    save_predictor(folder / "p.npz", predictor)
    origin = {"settings": {"kind": "paper", "voters": 2}, "takes": [["walk", "ab"]], "held-out takes": []}
    progress = Progress([network(rng)], [{"step": 3.0}], 7, network(rng), 12.5, 1, [0.5, 0.25])
    state = {"order": np.arange(9), "numpy": np.array("{}")}
    write_checkpoint(folder / "c", Checkpoint(origin, progress, scaler, network(rng), network(rng), state))
    (folder / "t.bvh").write_text(format_bvh(to_bvh(MOTION, "walk")))
    (folder / "table.csv").write_bytes(table())
    (folder / "report.json").write_text(to_json(baked(SECOND, DATABASE, headset_forward)))

    def content(name: str) -> bytes:
        return (folder / name).read_bytes()

    def recording(name: str, suffix: str, sound: bytes, change: Change) -> Reader:
        return Reader(name, suffix, sound, change, read_recording, carry_recording, RECORDING_VERBS)

    def from_checkpoint(path: Path) -> Checkpoint:
        return read_checkpoint(path, origin)

    def from_report(path: Path) -> dict[str, Any]:
        return read_report(str(path))

    return [
        Reader(
            "bvh",
            ".bvh",
            content("t.bvh"),
            change_text,
            lambda path: load_take(path, 30.0),
            carry_take,
            TAKE_VERBS,
        ),
        Reader(
            "mvnx",
            ".mvnx",
            format_mvnx(MOTION).encode(),
            change_text,
            lambda path: load_take(path, 30.0),
            carry_take,
            TAKE_VERBS,
        ),
        recording("csv", ".csv", content("r.csv"), change_text),
        recording("aframe", ".json", aframe(), change_json),
        recording("table", ".csv", named(long=False), change_text),
        recording("long table", ".csv", named(long=True), change_text),
        Reader("folder", ".csv", one_device(0), change_text, read_folder, carry_recording),
        Reader("map", ".json", MAP, change_json, read_map, carry_map),
        recording("messages", ".log", messages(), change_text),
        recording("objects", ".json", objects(), change_json),
        recording("bsor", ".bsor", replay(), change_replay),
        Reader("layout", ".json", LAYOUT, change_json, read_layout, carry_layout),
        Reader("bone map", ".json", BONE_MAP, change_json, read_family, carry_family),
        Reader(
            "database", ".npz", content("d.npz"), change_npz, load_database, carry_database, DATABASE_VERBS
        ),
        Reader(
            "predictor",
            ".npz",
            content("p.npz"),
            change_npz,
            load_predictor,
            carry_predictor,
            PREDICTOR_VERBS,
        ),
        Reader("checkpoint", ".training", content("c"), change_npz, from_checkpoint, carry_checkpoint),
        Reader(
            "report", ".json", content("report.json"), change_json, from_report, carry_report, REPORT_VERBS
        ),
    ]

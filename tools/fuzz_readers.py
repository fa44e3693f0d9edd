"""The readers that are fuzzed: a sound file of each kind, and what is done with a file that was read.

A new reader is one entry in `readers`.
"""

from __future__ import annotations

import json
import random
import struct
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from footwork.cli.common import read_report
from footwork.core import presets
from footwork.core.body.edit import resample as resample_motion
from footwork.core.database.build import build_database
from footwork.core.database.describe import describe_database
from footwork.core.database.sidecar import load_database, save_database
from footwork.core.evaluation.compare import compare_reports, comparison_in_words
from footwork.core.jobs import run
from footwork.core.mocap.bvh import format_bvh
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.export import to_bvh
from footwork.core.mocap.families import read_family
from footwork.core.mocap.take import Take
from footwork.core.mocap.takes import load_take
from footwork.core.pipeline import bake
from footwork.core.recording import layouts
from footwork.core.recording.csv_format import write_csv
from footwork.core.recording.cut import cut
from footwork.core.recording.read import read_recording
from footwork.core.recording.resample import resample
from footwork.core.recording.simulate import simulate_recording
from footwork.core.settings import BakeSettings, DatabaseSettings
from footwork.nn.inputs import INPUTS, Scaler
from footwork.nn.network import Network
from footwork.nn.predictor import headset_forward, load_predictor, predict
from footwork.nn.train.checkpoint import Checkpoint, Progress, read_checkpoint, write_checkpoint
from footwork.nn.weights import Predictor, save_predictor
from fuzz_changes import change_json, change_npz, change_replay, change_text

BAKED = 0.05
"""Share of the databases that are read which are baked with, too; it takes long."""


@dataclass(frozen=True, slots=True)
class Reader:
    """One kind of file: how sound ones look, how they are changed, and what is done with them."""

    name: str
    suffix: str
    sound: bytes
    change: Callable[[random.Random, bytes], bytes]
    carry: Callable[[Path, random.Random], None]


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
SETTINGS = DatabaseSettings(fps=30.0)


def carry_take(path: Path, rng: random.Random) -> None:
    """To a database, and to a recording."""
    take = load_take(path, 30.0)
    check(
        bool(np.isfinite(take.motion.rotations).all() and np.isfinite(take.motion.positions).all()), "a take"
    )
    recording = simulate_recording(take.motion, take.name)
    check(bool(np.isfinite(recording.positions).all()), "its trackers")
    if rng.random() < 0.2:
        database = run(build_database([take], SETTINGS, name="fuzz"))
        save_database(path.with_suffix(".made.npz"), database)
        describe_database(load_database(path.with_suffix(".made.npz")))


def carry_recording(path: Path, rng: random.Random) -> None:
    """To an even rate."""
    recording = read_recording(path)
    even = resample(recording, 60.0)
    check(bool(np.isfinite(even.positions).all() and np.isfinite(even.rotations).all()), "a recording")
    check(0.3 <= recording.eye_height <= 3.0, "an eye height")


def carry_database(path: Path, rng: random.Random) -> None:
    """To its description, and a short bake."""
    database = load_database(path)
    json.dumps(describe_database(database), allow_nan=False)
    if rng.random() < BAKED:
        result = run(
            bake(cut(TRACKED, 0.0, 1.0), [database], headset_forward, None, BakeSettings(search="greedy"))
        )
        check(bool(np.isfinite(result.tracks.locations).all()), "keys")


def carry_predictor(path: Path, rng: random.Random) -> None:
    """To a direction."""
    found = predict(load_predictor(path), TRACKED)
    check(bool(np.isfinite(found.yaws).all()), "directions")
    check(found.doubt is None or bool(np.isfinite(found.doubt).all()), "a doubt")


def carry_report(path: Path, rng: random.Random) -> None:
    """Beside itself."""
    report = read_report(str(path))
    comparison_in_words(compare_reports(report, report))


def network(rng: np.random.Generator) -> Network:
    """A small one of the paper's kind."""
    sizes = ((INPUTS, 8), (8, 6))
    return Network(
        tuple(rng.normal(size=size).astype(np.float32) * 0.1 for size in sizes),
        tuple(rng.normal(size=size[1]).astype(np.float32) * 0.1 for size in sizes),
    )


def aframe() -> bytes:
    """A recording of a second."""
    pose = [
        {
            "timestamp": 1000.0 / 60.0 * i,
            "position": {"x": 0.01 * i, "y": 1.6, "z": -0.02 * i},
            "rotation": {"x": 3.0, "y": 0.5 * i, "z": -2.0},
        }
        for i in range(60)
    ]
    return json.dumps({name: {"poses": pose} for name in ("camera", "left", "right")}).encode()


def replay() -> bytes:
    """A Beat Saber replay of a second."""
    text = struct.pack("<i", 4) + b"walk"
    info = text * 13 + bytes(4) + text * 3 + bytes(struct.calcsize("<fBffff"))
    frames = np.zeros((60, 23), "<f4")
    frames[:, 0] = np.arange(60) / 60.0
    frames[:, 2:] = np.tile([0.1, 1.6, 0.2, 0.0, 0.1, 0.0, 1.0], 3)
    frames[:, 2] += 0.01 * np.arange(60)
    return b"\x69\x3d\x2d\x44\x01\x00" + info + b"\x01" + struct.pack("<i", 60) + frames.tobytes()


def readers(folder: Path) -> list[Reader]:
    """Every reader, with a sound file of its kind."""
    rng = np.random.default_rng(4)
    take = Take("walk", "walk.bvh", "", MOTION, {}, ())
    database = run(build_database([take], SETTINGS, name="walk", tags=("upright",)))
    save_database(folder / "d.npz", database)
    write_csv(folder / "r.csv", TRACKED)
    scaler = Scaler(rng.normal(size=INPUTS), rng.uniform(0.5, 2.0, INPUTS))
    predictor = Predictor("p", (network(rng),), scaler, None, 0.1, {"held_out_error_deg": 12.0})
    save_predictor(folder / "p.npz", predictor)
    origin = {"settings": {"kind": "paper", "voters": 2}, "takes": [["walk", "ab"]], "held-out takes": []}
    progress = Progress([network(rng)], [{"step": 3.0}], 7, network(rng), 12.5, 1, [0.5, 0.25])
    state = {"order": np.arange(9), "numpy": np.array("{}")}
    write_checkpoint(folder / "c", Checkpoint(origin, progress, scaler, network(rng), network(rng), state))
    baked = run(
        bake(cut(TRACKED, 0.0, 1.0), [database], headset_forward, None, BakeSettings(search="greedy"))
    )
    shipped = presets.SHIPPED
    layout = (shipped / layouts.KIND / "who_is_alyx.json").read_bytes()
    bone_map = sorted((shipped / "bone_maps").glob("*.json"))[0].read_bytes()

    def content(name: str) -> bytes:
        return (folder / name).read_bytes()

    take_text = format_bvh(to_bvh(MOTION, "walk")).encode()
    return [
        Reader("bvh", ".bvh", take_text, change_text, carry_take),
        Reader("csv", ".csv", content("r.csv"), change_text, carry_recording),
        Reader("aframe", ".json", aframe(), change_json, carry_recording),
        Reader("bsor", ".bsor", replay(), change_replay, carry_recording),
        Reader("layout", ".json", layout, change_json, lambda path, _: layouts.read_layout(path) and None),
        Reader("bone map", ".json", bone_map, change_json, lambda path, _: read_family(path) and None),
        Reader("database", ".npz", content("d.npz"), change_npz, carry_database),
        Reader("predictor", ".npz", content("p.npz"), change_npz, carry_predictor),
        Reader(
            "checkpoint",
            ".training",
            content("c"),
            change_npz,
            lambda p, _: read_checkpoint(p, origin) and None,
        ),
        Reader("report", ".json", json.dumps(baked.report).encode(), change_json, carry_report),
    ]

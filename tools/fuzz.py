"""Seeded fuzzing of every reader: whatever a file holds, it is read, or refused with one line.

Half of the inputs are sound files with changed values, shapes and counts; the others have changed bytes. What is read
is carried on: takes are resampled and become databases, databases are described and baked with, predictors predict,
reports are compared. Only InputError may come of it, within a second and 300 MB. What fails is kept in out/fuzz.
"""

from __future__ import annotations

import argparse
import copy
import hashlib
import io
import json
import random
import re
import resource
import signal
import struct
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from footwork.cli.common import read_report
from footwork.core import presets
from footwork.core.body.edit import resample as resample_motion
from footwork.core.database.build import build_database
from footwork.core.database.describe import describe_database
from footwork.core.database.sidecar import load_database, save_database
from footwork.core.errors import InputError
from footwork.core.evaluation.compare import compare_reports, comparison_in_words
from footwork.core.jobs import run
from footwork.core.mocap.bvh import format_bvh
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.export import to_bvh
from footwork.core.mocap.families import read_family
from footwork.core.mocap.take import Take
from footwork.core.mocap.takes import load_take
from footwork.core.npz import write_npz
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

ROOT = Path(__file__).parents[1]
SECONDS, GROWTH, ADDRESSES = 1.0, 300 << 20, 3 << 30
NUMBERS = (
    "0",
    "-1",
    "1",
    "nan",
    "inf",
    "-inf",
    "1e300",
    "1e-310",
    "1e6",
    "-1e9",
    "99999999",
    "9" * 400,
    "",
    "x",
    "0.5",
)
VALUES: tuple[Any, ...] = (
    None,
    True,
    0,
    -1,
    3,
    1e6,
    1e300,
    10**250,
    2.5,
    "",
    "text",
    [],
    {},
    [1],
    {"a": 1},
    [[[]]],
)
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


def change_bytes(rng: random.Random, content: bytes) -> bytes:
    """Bits, bytes and stretches changed, lost, doubled or put elsewhere."""
    out = bytearray(content)
    for _ in range(rng.choice((1, 1, 2, 5, 20))):
        at, length = rng.randrange(max(1, len(out))), min(rng.choice((1, 2, 8, 100)), len(out))
        way = rng.randrange(6)
        if way == 0 and out:
            out[at] ^= 1 << rng.randrange(8)
        elif way == 1:
            out[at : at + length] = rng.randbytes(length)
        elif way == 2:
            del out[at : at + length]
        elif way == 3:
            out[at:at] = out[at : at + length] * rng.choice((1, 3, 50))
        elif way == 4 and rng.random() < 0.3:
            del out[at:]
        else:
            other = rng.randrange(max(1, len(out)))
            out[at:at] = out[other : other + length]
    return bytes(out)


def change_text(rng: random.Random, content: bytes) -> bytes:
    """Numbers replaced, lines lost, doubled or swapped."""
    lines = content.decode().split("\n")
    for _ in range(rng.choice((1, 1, 2, 4))):
        at, way = rng.randrange(len(lines)), rng.randrange(8)
        if way == 0 and len(lines) > 1:
            del lines[at]
        elif way == 1:
            lines[at:at] = [lines[at]] * rng.choice((1, 2, 300))
        elif way == 2:
            other = rng.randrange(len(lines))
            lines[at], lines[other] = lines[other], lines[at]
        else:
            # half of them where the words are, not among the rows
            at = rng.randrange(min(len(lines), 150)) if rng.random() < 0.5 else at
            found = list(re.finditer(r"-?\d+(?:\.\d+)?(?:e-?\d+)?", lines[at]))
            if found:
                number = rng.choice(found)
                lines[at] = (
                    lines[at][: number.start()] + new_number(rng, number[0]) + lines[at][number.end() :]
                )
    return "\n".join(lines).encode()


def new_number(rng: random.Random, old: str) -> str:
    """Another one in its place."""
    if rng.random() < 0.5:
        return rng.choice(NUMBERS)
    return repr(float(old) * rng.choice((-1.0, 0.0, 0.5, 1.1, 10.0, 1e3, 1e6, 1e-6)))


def change_json(rng: random.Random, content: bytes) -> bytes:
    """Values replaced, lost, doubled or nested."""
    value = json.loads(content)
    for _ in range(rng.choice((1, 1, 2, 4))):
        change_value(rng, value)
    return json.dumps(value).encode()


def change_value(rng: random.Random, value: Any) -> None:
    """One place within a value."""
    while True:
        keys = list(value) if isinstance(value, dict) else list(range(len(value)))
        if not keys:
            return
        key = rng.choice(keys)
        inner = value[key]
        if isinstance(inner, dict | list) and inner and rng.random() < 0.8:
            value = inner
            continue
        if rng.random() < 0.2:
            del value[key]
        elif isinstance(inner, int | float) and rng.random() < 0.5:
            value[key] = inner * rng.choice((-1, 0, 10, 1000, 10**9, 0.1))
        else:
            value[key] = copy.deepcopy(rng.choice((*VALUES, [inner], {"x": inner}, [inner] * 50)))
        return


def change_npz(rng: random.Random, content: bytes) -> bytes:
    """Values, kinds, shapes and lengths of arrays changed, arrays lost."""
    with np.load(io.BytesIO(content)) as found:
        arrays = {name: found[name] for name in found.files}
    whole = dict(arrays)
    for _ in range(rng.choice((1, 1, 2, 3))):
        name = rng.choice(list(arrays))
        if name == "header" and arrays[name] is whole[name] and rng.random() < 0.9:
            arrays[name] = np.frombuffer(change_json(rng, arrays[name].tobytes()), np.uint8)
        elif rng.random() < 0.05 and len(arrays) > 1:
            del arrays[name]
        else:
            arrays[name] = change_array(rng, arrays[name])
    file = io.BytesIO()
    write_npz(file, arrays, compressed=rng.random() < 0.3)
    return file.getvalue()


def change_array(rng: random.Random, array: np.ndarray) -> np.ndarray:
    """One array, in one way."""
    out = np.array(array)
    way = rng.randrange(7)
    with np.errstate(all="ignore"):
        if way <= 2 and out.size:
            at = np.unravel_index(rng.randrange(out.size), out.shape)
            if out.dtype.kind == "f":
                out[at] = rng.choice(
                    (0.0, -1.0, 1e30, -1e30, np.nan, np.inf, 1e-38, float(out[at]) * 1.01, 1e4)
                )
            elif out.dtype.kind in "iu":
                out[at] = rng.choice((0, 1, 2, 100))
            elif out.dtype.kind == "b":
                out[at] = not out[at]
            else:
                out[at] = rng.choice(("", "x", "hips", "{}", "\x1b[2J\n"))
        elif way == 3 and out.dtype.kind in "fiu":
            out = np.asarray(out * rng.choice((0, -1, 2, 1000, 1.01))).astype(out.dtype)
        elif way == 4 and out.ndim:
            out = rng.choice(
                (out[:-1], np.concatenate([out, out]), out[::-1].copy(), out[:0], out[None], out.T)
            )
        elif way == 5:
            out = (
                out.astype(rng.choice(("<f8", ">f4", "<i8", "?", "<U9", "<f2")))
                if out.dtype.kind != "U"
                else out
            )
        elif way == 6 and out.size:
            out = rng.choice((out.reshape(-1), np.asarray(out.flat[0]), np.repeat(out.reshape(-1), 3)))
    return out


def change_replay(rng: random.Random, content: bytes) -> bytes:
    """Counts and floats of a binary replay."""
    out = bytearray(content)
    for _ in range(rng.choice((1, 2, 5))):
        at = 4 * rng.randrange(2, len(out) // 4 - 1) + rng.randrange(4)
        value = rng.choice((0, 1, -1, 2**31 - 1, 1000)) if rng.random() < 0.3 else None
        number = rng.choice((0.0, np.nan, np.inf, 1e30, -1.0, 1e-40, 90.0))
        out[at : at + 4] = struct.pack("<i", value) if value is not None else struct.pack("<f", number)
    return bytes(out)


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


def fault_of(reader: Reader, path: Path, rng: random.Random) -> tuple[str, bool]:
    """What is wrong with how a file is taken, "" for nothing, and whether it was read."""
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    start, read = time.process_time(), False
    signal.setitimer(signal.ITIMER_REAL, 60.0)
    try:
        reader.carry(path, rng)
        read = True
    except InputError as error:
        text = str(error)
        if not text.isprintable() or len(text) > 300:
            return f"message {text!r}", False
    except Exception as error:
        at = traceback.extract_tb(error.__traceback__)[-1]
        return f"{type(error).__name__} at {Path(at.filename).name}:{at.lineno}: {error}"[:200], False
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
    seconds = time.process_time() - start
    grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024
    if seconds > SECONDS * (1 if not read else 5):
        return f"{seconds:.1f} s", read
    return (f"{grown >> 20} MB" if grown > GROWTH else ""), read


def give_up(*_: object) -> None:
    """A minute is more than slow."""
    raise TimeoutError("takes more than a minute")


def fuzz(count: int, seed: int, only: str, output: Path) -> int:
    """Try `count` inputs; the number that failed."""
    failed: Counter[str] = Counter()
    tally: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        kinds = [reader for reader in readers(folder) if only in ("", reader.name)]
        for reader in kinds:
            (folder / "sound").with_suffix(reader.suffix).write_bytes(reader.sound)
            reader.carry((folder / "sound").with_suffix(reader.suffix), random.Random(0))
        resource.setrlimit(resource.RLIMIT_AS, (ADDRESSES, resource.getrlimit(resource.RLIMIT_AS)[1]))
        signal.signal(signal.SIGALRM, give_up)
        start = time.perf_counter()
        for number in range(count):
            rng = random.Random(f"{seed} {number}")
            reader = kinds[number % len(kinds)]
            structured = rng.random() < 0.5
            content = (reader.change if structured else change_bytes)(rng, reader.sound)
            path = (folder / "input").with_suffix(reader.suffix)
            path.write_bytes(content)
            fault, read = fault_of(reader, path, rng)
            tally["structured" if structured else "bytes"] += 1
            tally["read"] += read
            if fault:
                if failed[f"{reader.name}: {fault}"] == 0:
                    output.mkdir(parents=True, exist_ok=True)
                    digest = hashlib.sha256(content).hexdigest()[:8]
                    kept = output / f"{reader.name.replace(' ', '_')}_{number}_{digest}{reader.suffix}"
                    kept.write_bytes(content)
                    print(f"{kept}: {fault}", flush=True)
                failed[f"{reader.name}: {fault}"] += 1
        seconds = time.perf_counter() - start
    print(
        f"{count} inputs in {seconds:.0f} s ({count / seconds:.0f} per second), {tally['structured']} structured, "
        f"{tally['read']} read and carried on, {failed.total()} failed in {len(failed)} ways"
    )
    return failed.total()


def main() -> int:
    """Exit code 1 where an input failed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=100_000, help="inputs (default: 100000)")
    parser.add_argument("--seed", type=int, default=1, help="same seed, same inputs (default: 1)")
    parser.add_argument("--only", default="", help="one reader, by name")
    parser.add_argument(
        "--output", type=Path, default=ROOT / "out" / "fuzz", help="where failing inputs are kept"
    )
    options = parser.parse_args()
    np.seterr(all="ignore")
    return int(fuzz(options.count, options.seed, options.only, options.output) > 0)


if __name__ == "__main__":
    sys.exit(main())

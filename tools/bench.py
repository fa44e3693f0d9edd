"""Speed and memory, each beside what a user would otherwise use, in one run.

Takes come from the data folder (see tests/conftest.py) where it is there, else from the procedural demo. Times are
medians; what counts is the ratio in a line, since machines differ and are shared.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import textwrap
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

# one core for every figure; must be said before numpy loads
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

import numpy as np
from footwork.core import jobs
from footwork.core.database.build import build_database
from footwork.core.database.motion_database import MotionDatabase
from footwork.core.mocap.bvh import read_bvh, write_bvh
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.export import to_bvh
from footwork.core.mocap.takes import load_take
from footwork.core.pipeline import bake
from footwork.core.recording.simulate import simulate_recording
from footwork.core.settings import BakeSettings, DatabaseSettings
from footwork.nn.predictor import predict_yaw, shipped_predictor

DATA = Path(os.environ.get("FOOTWORK_DATA", Path(__file__).parents[2] / "shared" / "data"))
Row = tuple[str, float, str]


def median_s(work: Callable[[], Any], runs: int = 5) -> float:
    """Median seconds of `runs` calls."""
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def in_blender(script: str, *arguments: str, limit_s: float = 600.0) -> float:
    """Run a script that prints seconds as its last line, in a process of its own with bpy."""
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(script), *arguments],
        capture_output=True,
        text=True,
        timeout=limit_s,
        check=False,
    )
    lines = [line for line in done.stdout.splitlines() if line.startswith("seconds ")]
    if not lines:
        sys.exit(f"the Blender part of the bench failed:\n{done.stderr[-2000:]}")
    return float(lines[-1].split()[1])


IMPORT_BVH = """
    import os, sys, time, bpy
    times = []
    for _ in range(3):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        start = time.perf_counter()
        bpy.ops.import_anim.bvh(filepath=sys.argv[1])
        times.append(time.perf_counter() - start)
    print("seconds", sorted(times)[1], flush=True)
    os._exit(0)
"""

WRITE_KEYS = """
    import os, sys, time, bpy, numpy as np
    from footwork.bridge.action import write_action
    from footwork.bridge.armature import create_armature
    from footwork.core.mocap.demo import demo_skeleton
    from footwork.core.rig.armature import rig_from_skeleton
    from footwork.core.rig.rig import BoneTracks
    how, frames = sys.argv[1], int(sys.argv[2])
    bpy.ops.wm.read_factory_settings(use_empty=True)
    rig = rig_from_skeleton(demo_skeleton(), "Bench")
    obj = create_armature(rig, "Bench", bpy.context.scene.collection)
    rotations = np.random.default_rng(0).normal(size=(frames, 22, 4)) + [4, 0, 0, 0]
    rotations /= np.linalg.norm(rotations, axis=-1, keepdims=True)
    tracks = BoneTracks(rig.bones[:22], 60.0, np.zeros((frames, 3)), rotations)
    start = time.perf_counter()
    if how == "bulk":
        write_action(obj, tracks, "Bench", fps=60.0)
    else:
        for frame in range(frames):
            for bone, rotation in zip(tracks.bones, rotations[frame]):
                obj.pose.bones[bone].rotation_quaternion = rotation
                obj.pose.bones[bone].keyframe_insert("rotation_quaternion", frame=frame)
    print("seconds", time.perf_counter() - start, flush=True)
    os._exit(0)
"""


def bench_reading(take: Path) -> list[Row]:
    """BVH text to arrays: ours, upc-pymotion, Blender's importer."""
    from pymotion.io.bvh import BVH

    ours = median_s(lambda: read_bvh(take))
    whole = median_s(lambda: load_take(take))
    pymotion = median_s(lambda: BVH().load(str(take)), 3)
    blender = in_blender(IMPORT_BVH, str(take))
    return [
        ("read BVH: Footwork", ours, "1"),
        ("read BVH and find roles, T-pose, floor: Footwork", whole, f"{whole / ours:.1f}"),
        ("read BVH: upc-pymotion", pymotion, f"{pymotion / ours:.1f}"),
        ("import BVH: Blender", blender, f"{blender / ours:.1f}"),
    ]


def make_database(paths: list[Path]) -> tuple[MotionDatabase, float]:
    """A mirrored database from takes on disk, and the seconds it took from BVH text."""
    start = time.perf_counter()
    takes = [load_take(path, 60.0) for path in paths]
    database = jobs.run(build_database(takes, DatabaseSettings(mirror=True), name="bench"))
    return database, time.perf_counter() - start


def bench_search(database: MotionDatabase) -> list[Row]:
    """One exact search: ours, plain differences, scipy's tree."""
    from footwork.core.matching.search import feature_weights, make_search
    from scipy.spatial import cKDTree

    weights = feature_weights(BakeSettings())
    search = make_search(database.features, weights)
    values = np.asarray(database.features.values)
    rows = np.flatnonzero(database.features.trajectory_valid)
    rng = np.random.default_rng(0)
    queries = values[rng.choice(rows, 200)] + 0.3 * rng.normal(size=(200, values.shape[1])).astype(np.float32)
    scaled = values[rows] * np.sqrt(weights).astype(np.float32)
    tree = cKDTree(scaled)

    def brute() -> None:
        for query in queries:
            int(np.argmin(np.sum((scaled - query * np.sqrt(weights)) ** 2, axis=-1)))

    ours = median_s(lambda: [search.nearest(query) for query in queries], 3) / len(queries)
    plain = median_s(brute, 1) / len(queries)
    scipy = median_s(lambda: [tree.query(q * np.sqrt(weights)) for q in queries], 3) / len(queries)
    size = f"{len(database) / 1000:.0f} k frames"
    return [
        (f"one search in {size}: Footwork", ours, "1"),
        (f"one search in {size}: differences", plain, f"{plain / ours:.1f}"),
        (f"one search in {size}: scipy cKDTree", scipy, f"{scipy / ours:.1f}"),
    ]


def main() -> None:
    """Run every bench and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", type=Path, help="also write the table here")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        rows = run(Path(folder))
    width = max(len(row[0]) for row in rows)
    for name, seconds, ratio in rows:
        print(f"{name:<{width}}  {seconds * 1000:12.2f} ms  {ratio:>12}")
    if options.json:
        options.json.write_text(json.dumps([{"what": n, "s": s, "ratio": r} for n, s, r in rows], indent=2))
    sys.stdout.flush()
    os._exit(0)


def run(folder: Path) -> list[Row]:
    """All benches, a row each: what, seconds, ratio."""
    if DATA.is_dir():
        takes = sorted((DATA / "takes/lafan1").glob("*subject[12]*walk*.bvh"))
        long, user = DATA / "takes/xsens/JL_mm_run.bvh", DATA / "takes/xsens/JL_mm_run.bvh"
    else:
        takes = []
        for seed, script in enumerate(("walk", "turn", "sidestep", "visit")):
            takes.append(folder / f"{script}.bvh")
            write_bvh(takes[-1], to_bvh(demo_motion(script, seed), script))
        long = user = takes[0]
    rows = bench_reading(long)
    database, seconds = make_database(takes)
    recorded = (
        sum(len(load_take(path)) / load_take(path).fps for path in ()) + len(database) / 2 / database.fps
    )
    rows.append((f"build database of {recorded:.0f} s", seconds, f"{recorded / seconds:.0f} x real time"))
    rows += bench_search(database)

    recording = simulate_recording(load_take(user, 60.0).motion, "user")
    predictor = shipped_predictor()
    start = time.perf_counter()
    jobs.run(bake(recording, [database], lambda r: predict_yaw(predictor, r), None, BakeSettings()))
    seconds = time.perf_counter() - start
    rows.append(
        (
            f"greedy bake of {recording.times[-1]:.0f} s",
            seconds,
            f"{recording.times[-1] / seconds:.0f} x real time",
        )
    )

    bulk = in_blender(WRITE_KEYS, "bulk", "18000")
    few = in_blender(WRITE_KEYS, "insert", "600")
    rows.append(("write 5 min at 60 fps to 22 bones", bulk, "1"))
    rows.append(("keyframe_insert of 10 s alone", few, f"{few / bulk:.1f}"))
    return rows


if __name__ == "__main__":
    main()

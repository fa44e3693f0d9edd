"""What `bench.py` measures, one case a process: `bench_cases.py CASE ARGUMENTS` prints its figures as JSON.

Seconds are processor time, medians of the runs; peak memory is the whole process, Python and imports included.
"""

from __future__ import annotations

import importlib.util
import json
import os
import resource
import statistics
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

QUERIES = 200
Found = dict[str, Any]


def peak_mb() -> float:
    """The most memory that this process has held."""
    status = Path("/proc/self/status")
    if status.is_file():
        # not getrusage: there a child starts with what its parent held
        (line,) = [line for line in status.read_text().splitlines() if line.startswith("VmHWM")]
        return int(line.split()[1]) / 1024.0
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20


def median_s(work: Callable[[], Any], runs: int = 5) -> float:
    """Median processor seconds of `runs` calls."""
    times: list[float] = []
    for _ in range(runs):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return statistics.median(times)


def read(path: str) -> Found:
    """Our BVH reader."""
    from footwork.core.mocap.bvh import read_bvh

    return {"seconds": median_s(lambda: read_bvh(path))}


def load(path: str) -> Found:
    """Our reader with everything that is found out about a take."""
    from footwork.core.mocap.takes import load_take

    return {"seconds": median_s(lambda: load_take(path))}


def pymotion(path: str) -> Found:
    """upc-pymotion's reader."""
    if importlib.util.find_spec("pymotion") is None:
        return {"missing": "upc-pymotion is not installed"}
    from pymotion.io.bvh import BVH

    return {"seconds": median_s(lambda: BVH().load(path), 3)}


def blender_import(path: str) -> Found:
    """Blender's importer."""
    import bpy

    times: list[float] = []
    for _ in range(3):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        start = time.process_time()
        bpy.ops.import_anim.bvh(filepath=path)
        times.append(time.process_time() - start)
    return {"seconds": statistics.median(times)}


def build(*paths: str) -> Found:
    """Mirrored database from BVH text; real time is that of the takes, not of their mirror images."""
    from footwork.core import jobs
    from footwork.core.database.build import build_database
    from footwork.core.mocap.takes import load_take
    from footwork.core.settings import DatabaseSettings

    start = time.process_time()
    takes = [load_take(path, 60.0) for path in paths]
    jobs.run(build_database(takes, DatabaseSettings(mirror=True), name="bench"))
    seconds = time.process_time() - start
    return {"seconds": seconds, "recorded": sum(len(take.motion) for take in takes) / 60.0}


def grown(path: str, frames: int) -> Any:
    """The database with so many frames: repeated or cut; repeats differ by noise in their features."""
    from footwork.core.database.sidecar import load_database

    database = load_database(Path(path))
    if frames == 0 or frames == len(database):
        return database
    rows = np.arange(frames) % len(database)
    features, rng = database.features, np.random.default_rng(0)
    values = features.values[rows]
    noise = 0.05 * rng.normal(size=values.shape).astype(np.float32)
    values = np.where(np.arange(frames)[:, None] < len(database), values, values + noise)
    valid = features.trajectory_valid[rows].copy()
    valid[-60:] = False
    clips: list[Any] = []
    for start in range(0, frames, len(database)):
        for clip in database.clips:
            if clip.start + start < frames:
                stop = min(clip.stop + start, frames)
                clips.append(replace(clip, start=clip.start + start, stop=stop))
    columns = {name: getattr(database.poses, name)[rows] for name in database.poses.__dataclass_fields__}
    return replace(
        database,
        clips=tuple(clips),
        poses=replace(database.poses, **columns),
        features=replace(features, values=values, trajectory_valid=valid),
    )


def search(how: str, path: str, frames: str) -> Found:
    """One exact search of the nearest frame, the mean over queries near real frames."""
    from footwork.core.matching.search import feature_weights, make_search
    from footwork.core.settings import BakeSettings

    features = grown(path, int(frames)).features
    weights = feature_weights(BakeSettings())
    rows = np.flatnonzero(features.trajectory_valid)
    rng = np.random.default_rng(0)
    queries = features.values[rng.choice(rows, QUERIES)].astype(np.float64)
    queries += 0.3 * rng.normal(size=queries.shape)
    scale = np.sqrt(weights)
    scaled = features.values[rows] * scale.astype(np.float32)
    start = time.process_time()
    if how == "ours":
        find = make_search(features, weights).nearest
    elif how == "differences":
        narrow = scale.astype(np.float32)

        def find(query: Any) -> Any:
            return np.argmin(np.sum((scaled - (query * narrow).astype(np.float32)) ** 2, axis=-1))
    elif how == "scipy":
        if importlib.util.find_spec("scipy") is None:
            return {"missing": "scipy is not installed"}
        from scipy.spatial import cKDTree

        tree = cKDTree(scaled)

        def find(query: Any) -> Any:
            return tree.query(query * scale)
    else:
        if importlib.util.find_spec("sklearn") is None:
            return {"missing": "scikit-learn is not installed"}
        from sklearn.neighbors import BallTree, KDTree

        plant = KDTree(scaled) if how == "kdtree" else BallTree(scaled)

        def find(query: Any) -> Any:
            return plant.query((query * scale)[None])

    built = time.process_time() - start
    few = queries[: QUERIES if how != "differences" or len(rows) < 300_000 else 20]
    return {"seconds": median_s(lambda: [find(query) for query in few], 3) / len(few), "build": built}


def bake(how: str, path: str, user: str, minutes: str, frames: str, bones: str) -> Found:
    """A bake onto a rig of the database's body, with so many bones, without writing keys."""
    from footwork.core import jobs
    from footwork.core.mocap.takes import load_take
    from footwork.core.pipeline import bake as bake_job
    from footwork.core.recording.simulate import simulate_recording
    from footwork.core.rig.fit import rig_from_skeleton
    from footwork.core.settings import BakeSettings
    from footwork.nn.predictor import predict, shipped_predictor

    database = grown(path, int(frames))
    recording = simulate_recording(load_take(user, 60.0).motion, "user")
    count = int(float(minutes) * 60.0 * 60.0)
    # there and back again, so that nothing jumps
    order = np.concatenate([np.arange(len(recording)), np.arange(len(recording))[::-1]])
    order = order[np.arange(count) % len(order)]
    recording = replace(
        recording,
        times=np.arange(count) / 60.0,
        positions=recording.positions[order],
        rotations=recording.rotations[order],
        valid=recording.valid[order],
    )
    rig = with_bones(rig_from_skeleton(database.skeleton, "Bench"), int(bones))
    predictor = shipped_predictor()
    settings = BakeSettings(search=how)
    start = time.process_time()
    result = jobs.run(bake_job(recording, [database], lambda r: predict(predictor, r), rig, settings))
    seconds = time.process_time() - start
    laps = {key: value for key, value in result.report["timing_s"].items() if key != "recorded"}
    spent = sum(laps.values())
    note = ", ".join(f"{stage} {value / spent:.0%}" for stage, value in laps.items())
    return {"seconds": seconds, "recorded": count / 60.0, "note": f" ({note})"}


def with_bones(rig: Any, bones: int) -> Any:
    """The rig with bones that nobody maps, hung on its hands, up to so many."""
    more = max(0, bones - len(rig.bones))
    hands = [rig.roles.index(role) for role in ("hand.L", "hand.R")]
    parents = [hands[i % 2] for i in range(more)]
    return replace(
        rig,
        bones=(*rig.bones, *(f"extra.{i}" for i in range(more))),
        parents=np.concatenate([rig.parents, np.array(parents, dtype=np.intp)]),
        rest=np.concatenate([rig.rest, rig.rest[parents]]),
        tails=np.concatenate([rig.tails, rig.tails[parents]]),
        roles=(*rig.roles, *[""] * more),
    )


def write(how: str, frames: str, bones: str) -> Found:
    """Keys onto an armature: all at once as we do, or bone by bone and frame by frame."""
    import bpy
    from footwork.bridge.action import write_action
    from footwork.bridge.armature import create_armature
    from footwork.core.mocap.demo import demo_skeleton
    from footwork.core.rig.fit import rig_from_skeleton
    from footwork.core.rig.rig import BoneTracks

    count, number = int(frames), int(bones)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    rig = with_bones(rig_from_skeleton(demo_skeleton(), "Bench"), number)
    armature = create_armature(rig, "Bench", bpy.context.scene.collection)
    rng = np.random.default_rng(0)
    rotations = rng.normal(size=(count, number, 4)) * 0.1 + np.array([1.0, 0.0, 0.0, 0.0])
    rotations /= np.linalg.norm(rotations, axis=-1, keepdims=True)
    names = rig.bones[:number]
    tracks = BoneTracks(names, 60.0, rng.normal(size=(count, 3)), rotations)
    start = time.process_time()
    if how == "bulk":
        write_action(armature, tracks, "Bench", fps=60.0)
    else:
        for frame in range(count):
            armature.pose.bones[names[0]].location = tracks.locations[frame]
            armature.pose.bones[names[0]].keyframe_insert("location", frame=frame)
            for name, rotation in zip(names, rotations[frame], strict=True):
                armature.pose.bones[name].rotation_quaternion = rotation
                armature.pose.bones[name].keyframe_insert("rotation_quaternion", frame=frame)
    return {"seconds": time.process_time() - start}


CASES: dict[str, Callable[..., Found]] = {
    "read": read,
    "load": load,
    "pymotion": pymotion,
    "blender-import": blender_import,
    "build": build,
    "search": search,
    "bake": bake,
    "write": write,
}

if __name__ == "__main__":
    found = CASES[sys.argv[1]](*sys.argv[2:])
    found["peak_mb"] = peak_mb()
    print(json.dumps(found), flush=True)
    # some bpy modules crash or hang while Python tears them down
    os._exit(0)

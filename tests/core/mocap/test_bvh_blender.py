"""Joint positions against Blender's own BVH importer, in a process of its own."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from footwork.core.body import forward_kinematics as fk
from footwork.core.body.edit import cut
from footwork.core.mocap.bvh import BvhFile, local_transforms, read_bvh, write_bvh
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.export import to_bvh

pytestmark = pytest.mark.skipif(importlib.util.find_spec("bpy") is None, reason="no Blender module here")

# ends by os._exit: the module can hang or crash when it is taken down
SCRIPT = """
import os, sys
import bpy, numpy as np
out = {}
for path in sys.argv[2:]:
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.import_anim.bvh(filepath=path, global_scale=1.0, use_fps_scale=False, frame_start=1)
    obj = bpy.context.object
    first, last = (int(x) for x in obj.animation_data.action.frame_range)
    rows = []
    for frame in range(first, last + 1):
        bpy.context.scene.frame_set(frame)
        rows.append([list((obj.matrix_world @ bone.matrix).translation) for bone in obj.pose.bones])
    name = os.path.basename(path)
    out[name] = np.array(rows)
    out[name + ":names"] = np.array([bone.name for bone in obj.pose.bones])
np.savez(sys.argv[1], **out)
sys.stdout.flush()
os._exit(0)
"""


def in_blender(paths: list[Path], folder: Path) -> dict[str, np.ndarray]:
    result = folder / "blender.npz"
    process = subprocess.run(
        [sys.executable, "-c", SCRIPT, str(result), *map(str, paths)],
        env={**os.environ, "BLENDER_USER_RESOURCES": str(folder)},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert result.exists(), process.stderr[-2000:]
    return dict(np.load(result))


def z_up(points: np.ndarray) -> np.ndarray:
    """As Blender's importer turns Y up."""
    return np.stack([points[..., 0], -points[..., 2], points[..., 1]], axis=-1)


def shortened(bvh: BvhFile, frames: int) -> BvhFile:
    return replace(bvh, values=bvh.values[:: max(1, len(bvh) // frames)][:frames])


def test_positions_agree_with_blender(data: Path, tmp_path: Path):
    takes = [
        "xsens/JL_mm_run.bvh",
        "lafan1/walk1_subject1_walk2_filtered.bvh",
        "bandai_namco/dataset-2_walk_normal_001.bvh",
        "cmu/basketball/006_02.bvh",
        "cmu/dance_and_martial/salsa_01.bvh",
    ]
    files = {}
    for take in takes:
        path = tmp_path / Path(take).name
        files[path] = shortened(read_bvh(data / "takes" / take), 8)
        write_bvh(path, files[path])
    results = in_blender(list(files), tmp_path)
    for path, bvh in files.items():
        local, turns = local_transforms(bvh)
        ours = z_up(fk.forward(local[:, 0], turns, local, bvh.parents)[0])
        theirs, names = results[path.name], results[path.name + ":names"].tolist()
        order = [names.index(name) for name in bvh.names]
        # single precision, and bones shorter than Blender allows are stretched a little
        np.testing.assert_allclose(theirs[:, order], ours, atol=5e-5 * np.abs(ours).max())


def test_exported_motion_stands_in_blender_where_it_stands_here(tmp_path: Path):
    motion = demo_motion("turn", 3)
    motion = cut(motion, 100, 110)
    path = tmp_path / "turn.bvh"
    write_bvh(path, to_bvh(motion, "turn"))
    results = in_blender([path], tmp_path)
    positions, _ = motion.forward()
    order = [results["turn.bvh:names"].tolist().index(name) for name in motion.skeleton.names]
    np.testing.assert_allclose(results["turn.bvh"][:, order], 100.0 * positions, atol=0.02)

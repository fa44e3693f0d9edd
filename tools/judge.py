"""Judge baked .blend files without Footwork: what Blender shows of the legs, beside what the bake's report says.

    python tools/judge.py BAKED.blend REPORT.json ROLES.json [BAKED.blend REPORT.json ROLES.json ...]

Needs bpy. Bake at the databases' frame rate (`--fps`), at which reports measure. ROLES.json maps thigh, shin, foot and
toe of both sides ("thigh.L") to bones. Nothing of the project is imported: every figure is worked out here from the
evaluated armature. Ends with 1 where a figure is not the report's.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import bpy
import numpy as np

CLOSE = 0.02
"""Relative difference up to which two figures are the same; the least values count as 0.05."""
USUAL_LEG_M = 0.85


def evaluated(path: str, roles: dict[str, str]) -> tuple[np.ndarray, np.ndarray, float]:
    """Heads `(T, 8, 3)` of the leg bones in metres, the rest heights `(2,)` of the toes, and the frame rate."""
    bpy.ops.wm.open_mainfile(filepath=path, use_scripts=False)
    scene = bpy.context.scene
    rig = next(
        o
        for o in scene.objects
        if o.type == "ARMATURE" and roles["shin.L"] in o.pose.bones and o.animation_data
    )
    names = [roles[f"{part}.{side}"] for side in "LR" for part in ("thigh", "shin", "foot", "toe")]
    first, last = (round(frame) for frame in rig.animation_data.action.frame_range)
    unit = 1.0 if scene.unit_settings.system == "NONE" else scene.unit_settings.scale_length
    out = np.empty((last - first + 1, 8, 3))
    for frame in range(first, last + 1):
        scene.frame_set(frame)
        shown = rig.evaluated_get(bpy.context.evaluated_depsgraph_get())
        out[frame - first] = [shown.matrix_world @ shown.pose.bones[name].head for name in names]
    rest = [(rig.matrix_world @ rig.data.bones[names[i]].head_local).z for i in (3, 7)]
    return out * unit, np.array(rest) * unit, scene.render.fps / scene.render.fps_base


def gap(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> float:
    """Least distance between two segments, looked for on a grid that is made finer twice."""
    s, t, width = 0.5, 0.5, 0.5
    for _ in range(12):
        u = np.clip(s + width * np.linspace(-1, 1, 9), 0, 1)[:, None, None]
        v = np.clip(t + width * np.linspace(-1, 1, 9), 0, 1)[None, :, None]
        away = np.linalg.norm(a + u * (b - a) - c - v * (d - c), axis=-1)
        i, j = np.unravel_index(np.argmin(away), away.shape)
        s, t, width = float(u[i, 0, 0]), float(v[0, j, 0]), 0.5 * width
    return float(away.min())


def judged(points: np.ndarray, rest: np.ndarray, fps: float) -> dict[str, float]:
    """The figures by their names in reports."""
    left, right = points[:, :4], points[:, 4:]
    legs = [np.linalg.norm(side[0, i] - side[0, i + 1]) for side in (left, right) for i in (0, 1)]
    size = sum(legs) / 2 / USUAL_LEG_M
    toes = points[:, [3, 7]]
    speed = np.hypot(*np.moveaxis(np.diff(toes[..., :2], axis=0), -1, 0)) * fps
    height = np.clip((toes[1:, :, 2] - rest) / (0.025 * size), 0.0, 1.0)
    shins = points[:, [1, 2, 5, 6]]
    third = shins[3:] - 3 * shins[2:-1] + 3 * shins[1:-2] - shins[:-3]
    return {
        "nsm_skate_cm_s.mean": float((speed * (2 - 2**height)).mean() * 100),
        "shin_jerk_m_s3.mean": float(np.sqrt((third**2).sum(-1)).mean() * fps**3),
        "crossed_shins_frames": sum(
            gap(*frame) < 0.09 * size
            for frame in zip(left[:, 1], left[:, 2], right[:, 1], right[:, 2], strict=True)
        ),
    }


def main(arguments: list[str]) -> int:
    """Judge each triple of files; 1 where one of them is reported otherwise."""
    wrong = 0
    for blend, report, names in zip(arguments[::3], arguments[1::3], arguments[2::3], strict=True):
        metrics, roles = (json.loads(Path(path).read_text(encoding="utf-8")) for path in (report, names))
        metrics = metrics["metrics"]
        found = judged(*evaluated(str(Path(blend).resolve()), roles))
        for name, value in found.items():
            told = metrics
            for key in name.split("."):
                told = told[key]
            same = abs(value - told) <= CLOSE * max(abs(told), 0.05 if "frames" not in name else 50.0)
            wrong += not same
            print(
                f"{Path(blend).name}: {name} judged {value:.3f}, reported {told:.3f}{'' if same else ' DIFFERS'}"
            )
    sys.stdout.flush()
    return int(wrong > 0)


if __name__ == "__main__":
    os._exit(main(sys.argv[1:]))

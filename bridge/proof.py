"""Proof of a bake: frames as Blender shows them, compared with what was meant."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.body.edit import resample
from ..core.body.motion import Motion
from ..core.measure.catalogue import measure, summarise
from ..core.measure.measures import rotation_errors
from ..core.measure.series import series
from ..core.measure.subject import Body
from ..core.pipeline import BakeResult
from ..core.rig.fit import RigFit, fit_rig
from .action import scene_fps
from .causes import cause_of
from .compensate import compensate
from .lookup import in_view, metres_per_unit
from .shown import poses_at

Array = NDArray[np.floating[Any]]

FRAMES = 20
NEAR_M, NEAR_DEG = 1e-3, 0.5
"""How far off a joint may be, in metres on a body of 1.7 m and in degrees: Blender keeps single precision."""
USUAL_M = 1.7


@dataclass(frozen=True, slots=True, eq=False)
class _Apart:
    """How far joints are from where they were meant to be, in some frames."""

    metres: Array
    """`(N, J)`; 0 for joints without a role."""
    degrees: Array
    off: NDArray[np.bool_]
    """`(N, J)` whether that is too far."""


def prove(obj: bpy.types.Object, scene: bpy.types.Scene, result: BakeResult, frame_start: float) -> str:
    """Compare what Blender shows in some frames with the bake; the report gets an entry `proof`.

    Where what moves the armature, or bones above the hips, puts the hips elsewhere, their keys are changed so that it
    does not. If joints are still elsewhere, all frames are looked at, the report's figures are of what Blender shows,
    and a line among the warnings says which bone is how far off, and why.

    Returns:
        That line, "" where all is where it was meant to be.
    """
    fit, fps = fit_rig(result.rig), scene_fps(scene)
    meant = resample(result.motion, fps)
    frames = _chosen(result.tracks.rotations)
    with in_view(obj, scene), _activated(scene):
        apart = _compare(obj, scene, fit, meant, frames, frame_start)
        moved = bool(apart.off[:, _placed(fit)].any()) and compensate(obj, scene, result, frame_start)
        if moved:
            apart = _compare(obj, scene, fit, meant, frames, frame_start)
        entry: dict[str, Any] = {"frames": len(frames), "compensated": moved, "bone": "", "cause": ""}
        line = ""
        if apart.off.any():
            _measure_shown(obj, scene, fit, result, frame_start)
            apart = _compare(obj, scene, fit, meant, np.arange(len(meant)), frame_start)
            entry["frames"] = len(meant)
            line = _told(obj, fit, apart, entry)
            result.report["warnings"].append(line)
    entry["position_mm"] = float(1000.0 * apart.metres.max(initial=0.0))
    entry["rotation_deg"] = float(apart.degrees.max(initial=0.0))
    result.report["proof"] = entry
    return line


def _placed(fit: RigFit) -> list[int]:
    """The joints whose bones have keys of their location."""
    return [0, *(fit.skeleton.names.index(name) for name, _ in fit.rig.placed)]


@contextmanager
def _activated(scene: bpy.types.Scene) -> Iterator[None]:
    """A context in which the scene is the active one."""
    if bpy.context.scene == scene:
        yield
        return
    override: Any = bpy.context.temp_override(scene=scene, view_layer=scene.view_layers[0])
    with override:
        yield


def _chosen(rotations: Array) -> NDArray[np.intp]:
    """First, last, spread evenly, and the one of the quickest movement."""
    count = len(rotations)
    spread = np.linspace(0, count - 1, min(FRAMES, count)).round().astype(np.intp)
    quickest = np.argmax(np.abs(np.diff(rotations, axis=0)).sum(axis=(1, 2))) if count > 1 else 0
    return np.unique(np.append(spread, quickest))


def _compare(
    obj: bpy.types.Object,
    scene: bpy.types.Scene,
    fit: RigFit,
    meant: Motion,
    frames: NDArray[np.intp],
    frame_start: float,
) -> _Apart:
    positions, rotations = (part[frames] for part in meant.forward())
    shown = poses_at(obj, scene, fit, frame_start + frames, metres_per_unit(scene))
    roles = np.array([role != "" for role in fit.skeleton.roles])
    metres: Any = np.linalg.norm(shown[0] - positions, axis=-1) * roles
    # what stands in for a hand only ends an arm
    turning = roles & np.array([name not in fit.rig.absent for name in fit.skeleton.names])
    degrees: Any = np.degrees(rotation_errors(shown[1], rotations)) * turning
    size = float(fit.skeleton.tpose_positions()[:, 2].max()) / USUAL_M
    return _Apart(metres, degrees, (metres > NEAR_M * size) | (degrees > NEAR_DEG))


def _measure_shown(
    obj: bpy.types.Object, scene: bpy.types.Scene, fit: RigFit, result: BakeResult, frame_start: float
) -> None:
    """The report's figures are of what Blender shows at the motion's own times."""
    motion = result.motion
    frames = frame_start + np.arange(len(motion)) * (scene_fps(scene) / motion.fps)
    poses = poses_at(obj, scene, fit, frames, metres_per_unit(scene))
    if result.lost is not None:
        poses = poses[0] + result.lost[:, None], poses[1]
    if result.place is not None:
        poses = result.place.from_scene(*poses)
    values = measure(result.yardstick, Body(motion.skeleton, motion.fps, *poses))
    result.report.update(metrics=summarise(values), series=series(values))


def _told(obj: bpy.types.Object, fit: RigFit, apart: _Apart, entry: dict[str, Any]) -> str:
    """The line that names the first bone that is elsewhere."""
    joint = int(np.argmax(apart.off.any(axis=0)))
    name = fit.skeleton.names[joint]
    entry["bone"], entry["cause"] = name, cause_of(obj, name)
    away, turned = apart.metres[:, joint].max(), apart.degrees[:, joint].max()
    return (
        f"{obj.name}: Blender shows {name} up to {100.0 * away:.1f} cm and {turned:.0f} degrees from where it was "
        f"meant to be (any bone: {100.0 * apart.metres.max():.1f} cm): {entry['cause']}"
    )

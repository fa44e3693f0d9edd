"""What the tests in Blender share."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import gpu
import numpy as np
import pytest
from footwork.core.body.motion import Motion
from footwork.core.body.skeleton import Skeleton
from footwork.core.maths import quat
from mathutils import Matrix


def skeleton() -> Skeleton:
    """A person of 1.75 m with Xsens names."""
    centre = [
        ("Hips", -1, (0, 0, 0.98), "hips"),
        ("Chest", 0, (0, 0, 0.10), "spine1"),
        ("Chest4", 1, (0, 0, 0.30), "chest"),
        ("Neck", 2, (0, 0, 0.14), "neck"),
        ("Head", 3, (0, 0, 0.09), "head"),
    ]
    rows, index = list(centre), {name: number for number, (name, *_) in enumerate(centre)}
    for side, letter, x in (("Left", "L", -1.0), ("Right", "R", 1.0)):
        for name, parent, offset, role in (
            ("Collar", "Chest4", (0.03, 0, 0.09), "clavicle"),
            ("Shoulder", f"{side}Collar", (0.15, 0, 0), "upper_arm"),
            ("Elbow", f"{side}Shoulder", (0.29, 0, 0), "forearm"),
            ("Wrist", f"{side}Elbow", (0.26, 0, 0), "hand"),
            ("Hip", "Hips", (0.09, 0, -0.02), "thigh"),
            ("Knee", f"{side}Hip", (0, 0, -0.44), "shin"),
            ("Ankle", f"{side}Knee", (0, 0, -0.43), "foot"),
            ("Toe", f"{side}Ankle", (0, 0.14, -0.07), "toe"),
        ):
            index[side + name] = len(rows)
            place = (x * offset[0], offset[1], offset[2])
            rows.append((side + name, index[parent], place, f"{role}.{letter}"))
    names, parents, offsets, roles = zip(*rows, strict=True)
    tips = np.zeros((len(rows), 3))
    tips[index["Head"]] = (0, 0, 0.2)
    for side, x in (("Left", -1.0), ("Right", 1.0)):
        tips[index[f"{side}Wrist"]], tips[index[f"{side}Toe"]] = (x * 0.18, 0, 0), (0, 0.07, 0)
    return Skeleton(names, np.array(parents, np.intp), np.array(offsets, float), roles, tips)


def motion(body: Skeleton, frames: int = 60, fps: float = 60.0, seed: int = 1) -> Motion:
    """Smooth movement of every joint, with a body that walks a curve and turns more than once."""
    random = np.random.default_rng(seed)
    time = np.linspace(0.0, 1.0, frames)[:, None, None]
    speed, phase = random.uniform(1, 6, (2, 1, len(body), 3))
    turns = quat.from_rotation_vector(0.4 * np.sin(speed * time * 3.0 + phase))
    turns[:, 0] = quat.multiply(quat.from_yaw(8.0 * time[:, 0, 0]), turns[:, 0])
    way = np.stack([np.sin(3 * time), 2 * time, 0.98 + 0.05 * np.sin(9 * time)], axis=-1)[:, 0, 0]
    return Motion(body, fps, way, quat.continuous(turns))


def world_heads(obj: bpy.types.Object, bones: tuple[str, ...]) -> np.ndarray:
    """World positions `(B, 3)` of bone heads, as Blender evaluates the current frame."""
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return np.array([evaluated.matrix_world @ evaluated.pose.bones[bone].head for bone in bones])


def keys_of(action: bpy.types.Action) -> int:
    """Number of keys in an action of any Blender version."""
    if bpy.app.version < (4, 4, 0):
        return sum(len(curve.keyframe_points) for curve in action.fcurves)
    return sum(
        len(curve.keyframe_points)
        for layer in action.layers
        for strip in layer.strips
        for bag in strip.channelbags
        for curve in bag.fcurves
    )


def files(*names: str) -> list[dict[str, str]]:
    """File names as a file operator takes them."""
    return [{"name": name} for name in names]


def add_takes(folder: Path, *names: str) -> None:
    """Add takes to the current scene."""
    assert bpy.ops.footwork.add_takes(directory=str(folder), files=files(*names)) == {"FINISHED"}


def drawn(wide: int, high: int, draw: Callable[[], None]) -> np.ndarray:
    """Pixels `(high, wide, 4)` that `draw` leaves on black; skips the test where Blender draws only in windows."""
    if not hasattr(gpu, "init"):
        pytest.skip("this Blender has no graphics without a window")
    try:
        gpu.init()
    except SystemError as error:
        pytest.skip(str(error))
    screen = gpu.types.GPUOffScreen(wide, high)
    with screen.bind():
        frame = gpu.state.active_framebuffer_get()
        frame.clear(color=(0.0, 0.0, 0.0, 1.0))
        with gpu.matrix.push_pop(), gpu.matrix.push_pop_projection():
            gpu.matrix.load_identity()
            gpu.matrix.load_projection_matrix(
                Matrix(((2 / wide, 0, 0, -1), (0, 2 / high, 0, -1), (0, 0, -1, 0), (0, 0, 0, 1)))
            )
            draw()
        pixels = np.array(frame.read_color(0, 0, wide, high, 4, 0, "FLOAT").to_list())
    screen.free()
    return pixels

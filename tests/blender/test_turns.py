"""Rotation channels in every mode, as Blender evaluates them on keys and between them."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from footwork.bridge import rotations
from footwork.bridge.action import key_transform
from footwork.core.maths import quat

ORDERS = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")
MODES = ("QUATERNION", "AXIS_ANGLE", *ORDERS)
FRAMES = 400


def paths(order: str, middle: np.ndarray) -> np.ndarray:
    """Angles `(T, 3)` as x, y, z that turn smoothly, the middle one of the order as given."""
    time = np.linspace(0.0, 1.0, len(middle))
    angles = np.stack(
        [0.7 + 4.0 * time - np.sin(5.0 * time), middle, -0.4 + 1.9 * np.sin(6.0 * time)], axis=-1
    )
    return angles[:, ["XYZ".index(axis) for axis in "XYZ"]][:, [order.index(axis) for axis in "XYZ"]]


def turned(angles: np.ndarray, order: str) -> np.ndarray:
    """Quaternions of Blender's Euler angles: its first axis turns first, about fixed axes."""
    backwards = order[::-1]
    return quat.from_euler(angles[:, ["XYZ".index(axis) for axis in backwards]], backwards)


TIME = np.linspace(0.0, 1.0, FRAMES)
MIDDLES = {
    "through both poles": -0.9 + 7.0 * TIME,
    "back through one": 0.3 + 1.9 * np.sin(np.pi * TIME),
    "up to a pole": 1.5697 * np.sin(6.0 * TIME),
    "to and fro over a pole": 1.45 + 0.35 * np.sin(30.0 * TIME),
    "along a pole": 1.5697 + 0.0008 * np.sin(9.0 * TIME),
    "far from poles": 0.8 * np.sin(4.0 * TIME),
}


@pytest.mark.parametrize("middle", MIDDLES)
@pytest.mark.parametrize("order", ORDERS)
def test_smooth_angles_come_back_as_they_were(order: str, middle: str) -> None:
    wanted = paths(order, MIDDLES[middle])
    track = turned(wanted, order)
    signs = np.where(np.arange(FRAMES) % 3 == 0, -1.0, 1.0)
    found = rotations.channels(track * signs[:, None], order)
    apart = found - wanted
    whole = np.round(apart[0] / (2.0 * np.pi)) * 2.0 * np.pi
    np.testing.assert_allclose(apart, np.broadcast_to(whole, apart.shape), atol=1e-4)


@pytest.mark.parametrize("turns", [(-1.3, 5.1), (4.0, -9.0), (0.4, 7.0)])
def test_an_axis_that_drifts_comes_back_while_the_angle_goes_through_nought_and_whole_turns(
    turns: tuple[float, float],
) -> None:
    angle = np.linspace(*turns, FRAMES)
    axis = np.stack([np.cos(2.0 * TIME), 0.5 + np.sin(3.0 * TIME), 0.8 - TIME], axis=-1)
    axis /= np.linalg.norm(axis, axis=-1, keepdims=True)
    track = np.concatenate([np.cos(0.5 * angle)[:, None], np.sin(0.5 * angle)[:, None] * axis], axis=-1)
    found = rotations.channels(track, "AXIS_ANGLE")
    side = np.sign(found[0, 1:] @ axis[0])
    np.testing.assert_allclose(found[:, 1:], side * axis, atol=1e-6)
    apart = found[:, 0] - side * angle
    np.testing.assert_allclose(apart, np.round(apart[0] / (2.0 * np.pi)) * 2.0 * np.pi, atol=1e-6)


def evaluated(obj: bpy.types.Object, scene: bpy.types.Scene, times: np.ndarray) -> np.ndarray:
    """World rotations `(T, 4)` at frames and parts of frames."""
    out = np.empty((len(times), 4))
    for i, time in enumerate(times):
        scene.frame_set(int(time), subframe=float(time % 1.0))
        posed = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
        out[i] = posed.matrix_world.to_quaternion()
    return out


def degrees(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.degrees(2.0 * np.arccos(np.minimum(np.abs(np.sum(a * b, axis=-1)), 1.0)))


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("seed", [0, 1])
def test_blender_shows_the_rotation_on_and_between_keys(empty, tumble, mode: str, seed: int) -> None:
    track = tumble(240, 60.0, seed=seed)[:, 0]
    obj = bpy.data.objects.new("Turning", None)
    empty.collection.objects.link(obj)
    obj.rotation_mode = mode
    key_transform(obj, np.zeros((len(track), 3)), track, "Turning", 60.0, 1.0)
    keys = np.arange(len(track)) + 1.0
    assert degrees(evaluated(obj, empty, keys), track).max() < 0.1
    between = evaluated(obj, empty, keys[:-1] + 0.5)
    middle = quat.slerp(track[:-1], track[1:], np.full(len(track) - 1, 0.5))
    step = degrees(track[:-1], track[1:])
    away = degrees(between, middle)
    if mode in ORDERS:
        # within 10 degrees of a pole the outer angles turn fast and cut corners
        pole = quat.to_euler(track, mode[::-1])[:-1, 1]
        away = away[np.abs(pole) < np.radians(80.0)]
    assert step.max() < 12.0 and len(away) > 150
    assert away.max() < 0.5 * step.max()

"""Rotation channels against mathutils, and their continuity."""

from __future__ import annotations

import numpy as np
import pytest
from footwork.bridge import rotations
from footwork.core.maths import quat
from mathutils import Euler, Matrix, Quaternion

ORDERS = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")


def tumble(frames: int = 400) -> np.ndarray:
    """Rotations that turn several times about wandering axes."""
    time = np.linspace(0.0, 1.0, frames)
    turn = quat.from_rotation_vector(np.stack([9.0 * time, np.sin(7.0 * time), 2.0 * np.cos(5.0 * time)], -1))
    return quat.continuous(turn)


@pytest.mark.parametrize("order", ORDERS)
def test_euler_angles_are_blenders_and_do_not_jump(order: str) -> None:
    track = tumble()
    values = rotations.channels(track, order)
    for angles, q in zip(values, track, strict=True):
        made = np.array(Euler(angles.tolist(), order).to_matrix())
        assert np.abs(made - np.array(Quaternion(q.tolist()).to_matrix())).max() < 1e-5
    steps = np.abs(np.diff(values, axis=0))
    assert steps.max() < np.pi / 2 or np.median(steps) < 0.1
    assert np.percentile(steps, 99) < 0.6


@pytest.mark.parametrize("order", ORDERS)
def test_a_full_turn_about_each_axis_unwinds_in_euler(order: str) -> None:
    for axis, column in zip("XYZ", range(3), strict=True):
        if order[1] == axis:
            continue
        track = quat.continuous(quat.from_axis(axis, np.linspace(0.0, 4.0 * np.pi, 200)))
        values = rotations.channels(track, order)
        assert values[-1, column] == pytest.approx(4.0 * np.pi, abs=1e-6)
        assert np.abs(np.delete(values, column, axis=1)).max() < 1e-6


def test_axis_angle_is_blenders_and_does_not_jump() -> None:
    start = tumble()[:1]
    lead_in = quat.slerp(
        np.tile(quat.IDENTITY, (30, 1)), np.repeat(start, 30, axis=0), np.linspace(0.0, 1.0, 30)
    )
    track = quat.continuous(np.concatenate([np.tile(quat.IDENTITY, (3, 1)), lead_in, tumble()]))
    values = rotations.channels(track, "AXIS_ANGLE")
    for (angle, *axis), q in zip(values.tolist(), track, strict=True):
        made = np.array(Matrix.Rotation(angle, 3, axis))
        assert np.abs(made - np.array(Quaternion(q.tolist()).to_matrix())).max() < 1e-5
    assert np.abs(np.linalg.norm(values[:, 1:], axis=1) - 1.0).max() < 1e-9
    assert np.abs(np.diff(values[:, 0])).max() < 0.3


def test_axis_angle_of_no_rotation_has_an_axis() -> None:
    values = rotations.channels(np.tile(quat.IDENTITY, (5, 1)), "AXIS_ANGLE")
    assert np.allclose(values[:, 0], 0.0) and np.allclose(np.linalg.norm(values[:, 1:], axis=1), 1.0)

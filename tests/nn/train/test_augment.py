"""Altered windows: what is altered, and what stays true."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.maths import angles, quat
from footwork.core.recording.windows import (
    FACING,
    POSITIONS,
    TRACKED,
    WindowLayout,
    stream,
    take_windows,
    window_inputs,
)
from footwork.nn.train.augment import Augmentation, augment, mix_hands

LAYOUT = WindowLayout(np.round(np.arange(-5, 6) * 0.1, 3), 1)
NOTHING = Augmentation(*[0.0] * len(Augmentation.__slots__))


def _windows(yaw: np.ndarray) -> np.ndarray:
    """One window for each frame of a stiff body that turns by `yaw` `(T,)` about the point (1, 2)."""
    turn = quat.from_yaw(yaw)[:, None]
    body = np.array([[0.0, 0.1, 1.6], [-0.4, 0.3, 1.0], [0.3, 0.2, 1.2]])
    own = quat.from_rotation_vector(np.array([[0.3, 0.1, 0.2], [0.2, 1.0, 0.1], [0.1, -0.5, 0.4]]))
    positions = quat.rotate(turn, body) + np.array([1.0, 2.0, 0.0])
    rows = stream(positions, quat.multiply(turn, own), np.ones((len(yaw), 3), bool), 1.6)
    return take_windows(rows, np.arange(len(yaw)) / 10.0, 10.0, LAYOUT)


def _sampled(yaw: np.ndarray) -> np.ndarray:
    frames = np.clip(
        np.arange(len(yaw))[:, None] + np.round(LAYOUT.offsets * 10).astype(int), 0, len(yaw) - 1
    )
    return yaw[frames]


def test_without_strength_nothing_changes():
    windows = _windows(np.linspace(0, 3, 40))
    altered, size, moved = augment(windows, LAYOUT.offsets, NOTHING, np.random.default_rng(0))
    np.testing.assert_allclose(altered, windows, atol=1e-6)
    np.testing.assert_array_equal(size, np.ones(40))
    np.testing.assert_allclose(moved, np.zeros((40, 3)), atol=1e-7)


def test_what_is_altered_of_a_body_is_told():
    windows = _windows(np.linspace(0, 3, 40))
    how = replace(NOTHING, size=0.1, headset=0.05)
    altered, size, moved = augment(windows, LAYOUT.offsets, how, np.random.default_rng(5))
    place = slice(POSITIONS.start, POSITIONS.start + 3)
    heads = windows[:, LAYOUT.centre, place] * size[:, None] + moved
    np.testing.assert_allclose(altered[:, LAYOUT.centre, place], heads, atol=1e-6)
    assert np.std(size) > 0.05
    assert np.std(moved) > 0.02


def test_hands_of_the_same_stiff_body_mixed_are_the_same_hands():
    yaw = np.linspace(-2.0, 3.0, 40)
    windows = _windows(yaw)
    mixed, source = mix_hands(windows, _sampled(yaw), replace(NOTHING, mix=1.0), np.random.default_rng(1))
    np.testing.assert_allclose(mixed, windows, atol=1e-5)
    assert np.mean(source == np.arange(40)[:, None]) < 0.2


def test_a_mixed_hand_is_that_of_the_window_that_is_named():
    rng = np.random.default_rng(6)
    windows = _windows(np.full(40, 0.7))
    windows[..., 3:9] += rng.normal(0.0, 0.1, (40, 1, 6)).astype(np.float32)
    mixed, source = mix_hands(windows, np.full((40, 11), 0.7), replace(NOTHING, mix=0.5), rng)
    for hand, place in enumerate((slice(3, 6), slice(6, 9))):
        np.testing.assert_allclose(mixed[..., place], windows[source[:, hand]][..., place], atol=1e-5)
    assert 0.3 < np.mean(source != np.arange(40)[:, None]) < 0.7


def test_bending_a_stiff_bodys_path_is_turning_the_body():
    """A body that stands and one that turns differ by the bend alone: seen from the body, all stays as it
    was."""
    windows = _windows(np.full(30, 0.4))
    bent, _, _ = augment(windows, LAYOUT.offsets, replace(NOTHING, turn=1.0), np.random.default_rng(2))
    np.testing.assert_allclose(bent[:, LAYOUT.centre], windows[:, LAYOUT.centre], atol=1e-6)
    for sample in range(len(LAYOUT.offsets)):
        rows = [np.repeat(w[:, sample : sample + 1], len(LAYOUT.offsets), axis=1) for w in (bent, windows)]
        seen = [window_inputs(row, angles.yaw_of(row[:, 0, FACING]), LAYOUT) for row in rows]
        np.testing.assert_allclose(seen[0], seen[1], atol=1e-5)
    turned = angles.wrap(angles.yaw_of(bent[:, -1, FACING]) - angles.yaw_of(windows[:, -1, FACING]))
    assert np.std(turned) > 0.2


def test_looking_aside_moves_no_hand():
    windows = _windows(np.linspace(0, 3, 40))
    looked, _, _ = augment(windows, LAYOUT.offsets, replace(NOTHING, look=0.5), np.random.default_rng(3))
    np.testing.assert_allclose(looked[..., POSITIONS], windows[..., POSITIONS], atol=1e-6)
    np.testing.assert_allclose(looked[..., 15:27], windows[..., 15:27], atol=1e-6)
    assert np.std(angles.wrap(angles.yaw_of(looked[..., FACING]) - angles.yaw_of(windows[..., FACING]))) > 0.3


@pytest.mark.parametrize(
    "name", [name for name in Augmentation.__slots__ if name not in ("stretch", "mix", "frame")]
)
def test_each_strength_does_something_and_leaves_rotations_rotations(name):
    windows = _windows(np.linspace(0, 3, 200))
    altered, _, _ = augment(
        windows, LAYOUT.offsets, replace(NOTHING, **{name: 0.2}), np.random.default_rng(4)
    )
    assert not np.allclose(altered, windows, atol=1e-3)
    assert np.all(np.isin(altered[..., TRACKED], (0.0, 1.0)))
    if name != "noise_turn":
        columns = altered[..., 9:27].reshape(*altered.shape[:2], 3, 2, 3)
        np.testing.assert_allclose(np.linalg.norm(columns, axis=-1), 1.0, atol=1e-4)
        np.testing.assert_allclose(np.sum(columns[..., 0, :] * columns[..., 1, :], axis=-1), 0.0, atol=1e-4)

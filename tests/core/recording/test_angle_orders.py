"""Orders of Euler angles that no file states are told by the movement."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from footwork.core.recording.raw import RawRecording, Reading, Track
from footwork.core.recording.read import read_recording
from footwork.core.recording.reading.plausibility import measure, take_moments
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import Rotation

ORDERS = tuple("".join(order) for order in itertools.permutations("XYZ"))
UNITY = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
"""From Blender's axes to Unity's, right, up and forward."""


def smooth(rng: np.random.Generator, count: int, channels: int, seconds: float, size: float) -> np.ndarray:
    """Random curves `(count, channels)` at 60 Hz of a given deviation."""
    curves = gaussian_filter1d(rng.normal(size=(count, channels)), 60.0 * seconds, axis=0)
    return size * curves / curves.std(axis=0)


def written(turns: Rotation, order: str) -> np.ndarray:
    """Angles `(N, 3)` in degrees as x, y, z, by scipy."""
    found = turns.as_euler(order, degrees=True)
    return np.stack([found[:, order.index(axis)] for axis in "XYZ"], axis=-1)


def player(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Someone who looks around and waves both arms: positions `(N, 3, 3)`, matrices `(N, 3, 3, 3)`, Blender's axes."""
    rng, count = np.random.default_rng(seed), 1200
    body = Rotation.from_euler("Z", smooth(rng, count, 1, 1.5, 40.0), degrees=True)
    turns = [body * Rotation.from_euler("ZXY", smooth(rng, count, 3, 0.3, 12.0), degrees=True)]
    places = [np.array([0.3, -0.2, 1.62]) + smooth(rng, count, 3, 0.8, 0.05) + turns[0].apply([0, 0.08, 0])]
    for side in (-1.0, 1.0):
        swing = smooth(rng, count, 3, 0.25, 30.0)
        swing[:, 1] += 15.0
        arm = Rotation.from_euler("ZXY", swing, degrees=True)
        turns.append(body * arm)
        elbow = places[0] + body.apply([0.24 * side, 0.1, -0.5])
        places.append(elbow + turns[-1].apply([0.0, 0.3, 0.0]))
    return np.stack(places, axis=1), np.stack([turn.as_matrix() for turn in turns], axis=1)


@pytest.mark.parametrize("order", ORDERS)
def test_angles_put_together_in_their_own_order_turn_least(order) -> None:
    rng = np.random.default_rng(7)
    count = 2000
    turns = [Rotation.from_euler("ZYX", smooth(rng, count, 3, 0.4, 35.0), degrees=True) for _ in range(3)]
    times = np.arange(count) / 60.0
    tracks = [
        Track(times, smooth(rng, count, 3, 0.5, 0.1) + 1.0, written(turn, order), np.ones(count, np.bool_))
        for turn in turns
    ]
    raw = RawRecording(
        tracks=(tracks[0], tracks[1], tracks[2]), found={}, reading=Reading(rotation="XYZ-degrees")
    )
    moments = take_moments(raw)
    assert moments is not None
    turned = {name: measure(moments, f"{name}-degrees", "world").turned for name in ORDERS}
    assert min(turned, key=turned.__getitem__) == order
    # 0.05 s are three samples
    steps = [(turn[:-3].inv() * turn[3:]).magnitude().mean() for turn in turns]
    assert turned[order] == pytest.approx(np.mean(steps), rel=0.1)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("order", ORDERS)
def test_every_order_is_told_by_the_movement(tmp_path: Path, order: str, seed: int) -> None:
    places, matrices = player(seed)
    inside = UNITY @ matrices @ UNITY.T
    angles = written(Rotation.from_matrix(inside.reshape(-1, 3, 3)), order).reshape(-1, 3, 3)
    rows = np.concatenate([places @ UNITY.T, angles], axis=-1).reshape(len(places), -1)
    names = [f"{t}_{kind}_{a}" for t in ("head", "left", "right") for kind in ("pos", "rot") for a in "xyz"]
    lines = [",".join(["time", *names])]
    lines += [f"{i / 60.0:.5f}," + ",".join(f"{value:.6f}" for value in row) for i, row in enumerate(rows)]
    path = tmp_path / "player.csv"
    path.write_text("\n".join(lines))
    found = read_recording(path)
    seen = Rotation.from_quat(np.roll(found.rotations.reshape(-1, 4), -1, axis=-1)).as_matrix()
    seen = seen.reshape(-1, 3, 3, 3)
    # of the hands from the head, which does not depend on where the recording faces
    mine, true = (np.swapaxes(turns[:, :1], -1, -2) @ turns[:, 1:] for turns in (seen, matrices))
    assert np.einsum("tnij,tnij->tn", mine[: len(true)], true[: len(mine)]).min() > 2.99
    # under Unity's axes YZX and the usual YXZ differ in the roll of who looks up alone
    assert order == "YZX" or not any("--rotation" in doubt for doubt in found.doubts)

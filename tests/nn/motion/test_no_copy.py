"""The starter takes are no copies: they lie about as far from the training takes as those lie from each other."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from footwork.core.body.edit import resample
from footwork.core.body.motion import Motion
from footwork.core.jobs import run
from footwork.core.maths import quat
from footwork.nn.motion.decoder import read_model
from footwork.nn.motion.takes import WEIGHTS, starter_takes

SPAN = (0, 4, 8, 12)
"""Frames of a window of 0.4 s."""


def windows(motion: Motion, every: int) -> np.ndarray:
    """Joints `(N, 4 J 3)` of every so many windows, seen from the hips and their heading in its middle."""
    places, _ = motion.forward()
    yaws = quat.heading(motion.rotations[:, 0])
    start = np.arange(0, len(places) - 13, every)
    origin = np.pad(places[start + 6, 0, :2], ((0, 0), (0, 1)))[:, None]
    back = quat.from_yaw(-yaws[start + 6])[:, None]
    seen = [quat.rotate(back, places[start + frame] - origin) for frame in SPAN]
    return np.stack(seen, axis=1).reshape(len(start), -1)


def nearest(queries: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Mean metres of joints `(N,)` from each query to the window that is nearest to it."""
    squares = np.sum(known**2, axis=1)
    best = [int(np.argmin(squares - 2.0 * (known @ query))) for query in queries]
    off = (queries - known[best]).reshape(len(queries), -1, 3)
    return np.linalg.norm(off, axis=-1).mean(axis=1)


def test_no_window_is_one_of_the_training_takes(data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(Path(__file__).parents[3] / "tools"))
    monkeypatch.delitem(sys.modules, "motion_data", raising=False)
    motion_data = pytest.importorskip("motion_data")
    stretches, _ = motion_data.load(data / "takes")
    known = {item.take: [] for item in stretches}
    for item in stretches:
        known[item.take].append(windows(item.motion, 4))
    everything = np.concatenate([part for parts in known.values() for part in parts])
    made = np.concatenate(
        [windows(resample(motion, 30.0), 61) for _, motion in run(starter_takes(read_model(WEIGHTS)))]
    )
    real = "O3DE_MixedLocomotion1"
    others = np.concatenate([part for take, parts in known.items() if take != real for part in parts])
    apart = nearest(known[real][0][::15], others)
    found = nearest(made, everything)
    assert found.min() > 0.005
    assert np.median(found) > 0.6 * np.median(apart)

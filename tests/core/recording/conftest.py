"""Three trackers that move and turn in general ways, at times that binary numbers hold exactly."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from footwork.core.recording.raw import RawRecording, Track
from footwork.core.recording.timeline import Samples

FPS = 64.0


@pytest.fixture(scope="session")
def wander(tumble) -> Callable[..., Samples]:
    """All tracked: `wander(frames, fps)`, 64 frames per second by default; no tracker faster than 1 m/s."""

    def make(frames: int, fps: float = FPS) -> Samples:
        times = np.arange(frames) / fps
        rate, phase = np.random.default_rng(11).uniform(1.0, 3.0, (2, 3, 3))
        centre = np.array([[0.3, -0.2, 1.6], [-0.1, 0.2, 1.1], [0.5, 0.3, 0.9]])
        positions = centre + 0.12 * np.sin(rate * times[:, None, None] + 2.0 * phase)
        return Samples(times, positions, tumble(frames, fps, count=3, seed=4), np.ones((frames, 3), np.bool_))

    return make


@pytest.fixture(scope="session")
def as_raw() -> Callable[..., RawRecording]:
    """A file that holds samples: `as_raw(samples, **more)`; each tracker in arrays of its own."""

    def make(samples: Samples, **more) -> RawRecording:
        head, left, right = (
            Track(
                samples.times.copy(),
                samples.positions[:, i].copy(),
                samples.rotations[:, i].copy(),
                samples.valid[:, i].copy(),
            )
            for i in range(3)
        )
        return RawRecording((head, left, right), {"format": "made up"}, **more)

    return make

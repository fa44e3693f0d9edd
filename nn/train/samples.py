"""Takes as training and evaluation material: what the trackers see, and where the body truly is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.body.edit import cut, resample
from ...core.evaluation.true_estimate import true_estimate
from ...core.mocap.take import Take
from ...core.recording.simulate import simulate_recording
from ...core.recording.targets import joint_targets
from ..inputs import RATE
from ..parts import true_rows
from ..predictor import head_height
from .curation import curate

Array = NDArray[np.floating[Any]]


@dataclass(frozen=True, slots=True, eq=False)
class Sample:
    """One stretch of a take at `RATE`."""

    take: str
    positions: Array
    """`(T, 3, 3)` world positions of head, left and right hand, metres."""
    rotations: Array
    """`(T, 3, 4)` their world rotations since T-pose."""
    yaws: Array
    """`(T,)` the body's true yaw, radians."""
    head_height: float
    truth: Array
    """`(T, D)` the whole body in its own axes, as a perfect network would answer (`parts.true_rows`)."""

    def __len__(self) -> int:
        return len(self.yaws)


def samples_of(takes: Sequence[Take]) -> tuple[list[Sample], list[str]]:
    """The fit stretches of takes, and a line for each thing left out."""
    samples: list[Sample] = []
    notes: list[str] = []
    for take in takes:
        curated = curate(take)
        notes += curated.notes
        for start, stop in curated.stretches:
            motion = resample(cut(take.motion, start, stop), RATE)
            recording = simulate_recording(motion, take.name)
            positions, rotations = joint_targets(recording)
            height = head_height(recording)
            body = true_estimate(motion, height)
            truth = true_rows(body).astype(np.float32)
            samples.append(Sample(take.name, positions, rotations, body.yaws, height, truth))
    return samples, notes

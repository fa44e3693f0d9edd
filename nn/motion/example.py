"""The example recording: what a headset and two controllers would give of a person whom the motion model makes.

The body's way is a script for the motion model, as of the starter takes but in none of them; where head and hands do
something of their own, their movement is written down here.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.body.motion import Motion
from ...core.jobs import Job
from ...core.maths import quat
from ...core.maths.easing import smootherstep
from ...core.presets import user_folder
from ...core.recording.csv_format import write_csv
from ...core.recording.mounts import SIMULATED_MOUNTS
from ...core.recording.recording import Recording
from ...core.recording.simulate import simulate_recording
from .conditions import root_of
from .decoder import MotionModel, read_model
from .starter import keeping
from .takes import WEIGHTS, starter_take
from .ways import Leg

Array = NDArray[np.floating[Any]]

NAME = "example"
_SEED = 9000
_PERSON = "o3de"
_WAY = (
    Leg(1.6),
    Leg(2.8, 1.15),
    Leg(2.0, 1.1, 0.0, 0.75),
    Leg(3.0),
    Leg(1.5, 0.0, 0.6),
    Leg(0.7),
    Leg(1.5, 0.0, -0.6),
    Leg(0.6),
    Leg(3.0, height=0.74),
    Leg(0.9),
    Leg(1.3, 0.1, 0.0, 1.5),
    Leg(2.0, 0.95, 0.0, 0.2),
    Leg(1.5, 0.1, 0.0, 1.6),
    Leg(4.2),
)
"""Stands, walks, bends left, looks around, side-steps both ways, crouches, turns, walks away, turns back, waves."""
_LOOKS = (
    *((1.4, 2.2, 25.0, 0.0), (7.0, 8.0, 50.0, 5.0), (8.2, 9.3, -45.0, 0.0), (10.2, 11.2, -20.0, 0.0)),
    *(
        (12.3, 13.2, 20.0, 0.0),
        (14.4, 16.8, 0.0, -10.0),
        (17.7, 19.0, 20.0, 0.0),
        (20.8, 22.2, 25.0, 0.0),
        (22.9, 25.8, 6.0, 4.0),
    ),
)
"""Start and stop in seconds, and how far the head then turns left and up, degrees."""
_ALONG = quat.from_yaw(np.pi / 2.0)
"""A right hand that points ahead, palm down."""
_UP = quat.from_matrix(np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]]))
"""A right hand that points up, palm ahead."""
_WAVE_HZ, _WAVE = 1.3, np.radians(24.0)
_GESTURES = (
    (8.6, 10.0, (0.06, 0.40, 0.27), _ALONG),
    (14.9, 16.6, (0.08, 0.38, -0.33), quat.multiply(_ALONG, quat.from_axis("Y", 0.5))),
    (23.0, 25.5, (0.17, 0.22, 0.24), _UP),
)
"""Start and stop in seconds, where the right wrist is from its shoulder (right, ahead, up; metres), how it is held:
reaches for a shelf, reaches down, waves."""
_EASE_S = 0.7


def example_recording(model: MotionModel) -> Recording:
    """About 26 s of a person who walks, looks around, side-steps, crouches, reaches and waves."""
    rng = np.random.RandomState(_SEED)
    motion = _looking(starter_take(model, _PERSON, list(_WAY), rng))
    return _gesturing(simulate_recording(motion, NAME), motion)


def example_file(folder: Path | None = None) -> Job[Path]:
    """The example recording as a file, written anew: it takes less than a second.

    Args:
        folder: where it goes; that of the starter motion by default.

    Raises:
        InputError: the model is damaged, or the folder cannot be written; one line.
    """
    path = (folder or user_folder("starter")) / f"{NAME}.csv"
    yield 0.0, "making the example recording"
    recording = example_recording(read_model(WEIGHTS))
    with keeping(path.parent) as outputs:
        write_csv(path, recording, outputs)
    return path


def _looking(motion: Motion) -> Motion:
    """The motion with a head that looks where `_LOOKS` says."""
    seconds = np.arange(len(motion)) / motion.fps
    turns = np.zeros((len(motion), 3))
    for start, stop, left, up in _LOOKS:
        weight = _window(seconds, start, stop)
        turns += weight[:, None] * np.radians([up, 0.0, left])
    rotations = np.array(motion.rotations)
    head, neck = motion.skeleton.joint("head"), motion.skeleton.joint("neck")
    for joint, share in ((neck, 0.35), (head, 0.65)):
        rotations[:, joint] = quat.multiply(quat.from_euler(share * turns, "XYZ"), rotations[:, joint])
    return replace(motion, rotations=rotations)


def _gesturing(recording: Recording, motion: Motion) -> Recording:
    """The recording with a right controller that does what `_GESTURES` says."""
    places, _ = motion.forward()
    shoulder = places[:, motion.skeleton.joint("upper_arm.R")]
    facing = quat.from_yaw(root_of(motion).yaws)
    positions, rotations = np.array(recording.positions), np.array(recording.rotations)
    mount, turn = SIMULATED_MOUNTS.offsets[2], SIMULATED_MOUNTS.turns[2]
    for start, stop, place, hold in _GESTURES:
        weight = _window(recording.times, start, stop)
        held = np.broadcast_to(hold, (len(recording), 4))
        wrist = np.broadcast_to(np.array(place), (len(recording), 3))
        if hold is _UP:
            swing = _WAVE * np.sin(2.0 * np.pi * _WAVE_HZ * (recording.times - start))
            held = quat.multiply(quat.from_axis("Y", swing), held)
            wrist = wrist + 0.14 * np.stack([np.sin(swing), 0.0 * swing, np.cos(swing) - 1.0], axis=-1)
        held = quat.multiply(facing, held)
        goal = shoulder + quat.rotate(facing, wrist) + quat.rotate(held, mount)
        positions[:, 2] += weight[:, None] * (goal - positions[:, 2])
        rotations[:, 2] = _turned(rotations[:, 2], quat.multiply(held, turn), weight)
    return replace(recording, positions=positions, rotations=quat.continuous(rotations))


def _turned(start: Array, end: Array, weight: Array) -> Array:
    """Rotations `(T, 4)` between two, by weights `(T,)`, along an arc that never changes its side on the way."""
    arc = quat.continuous(quat.multiply(end, quat.conjugate(start)))
    arc = arc * np.copysign(1.0, (arc[:, 0] * weight).sum())
    length = np.linalg.norm(arc[:, 1:], axis=-1)
    angle = 2.0 * np.arctan2(length, arc[:, 0]) * weight
    axis = arc[:, 1:] / np.maximum(length, 1e-9)[:, None]
    return quat.multiply(quat.from_rotation_vector(axis * angle[:, None]), start)


def _window(seconds: Array, start: float, stop: float) -> Array:
    """1 between two times, eased from and to 0 before and after."""
    return smootherstep(np.clip((seconds - start) / _EASE_S + 1.0, 0.0, 1.0)) * smootherstep(
        np.clip((stop - seconds) / _EASE_S + 1.0, 0.0, 1.0)
    )

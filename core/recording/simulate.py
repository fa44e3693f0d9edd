"""Virtual trackers on full-body motion: recordings whose true body is known (paper, section 4)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from ..body.motion import Motion
from ..body.standing import standing_head_height
from ..errors import InputError
from ..maths import quat
from .mounts import SIMULATED_MOUNTS
from .recording import TRACKER_ROLES, TRACKERS, Mounts, Recording


def simulate_recording(
    motion: Motion, name: str, mounts: Mounts = SIMULATED_MOUNTS, eye_height: float | None = None
) -> Recording:
    """The recording that a headset and two controllers, fixed to a moving body, would give.

    Args:
        motion: at least two frames of a body in the world.
        name: the recording's name.
        mounts: how the devices sit on head and hands.
        eye_height: calibrated height of the headset, metres; by default as the body stands at ease.

    Raises:
        InputError: the motion has fewer than two frames.
    """
    if len(motion) < 2:
        raise InputError(f"{name}: {len(motion)} frames are too few for a recording; give a longer take")
    joints = [motion.skeleton.joint(role) for role in TRACKER_ROLES]
    positions, rotations = motion.forward()
    positions, rotations = positions[:, joints], rotations[:, joints]
    if eye_height is None:
        eye_height = standing_head_height(motion) + float(mounts.offsets[0, 2])
    return Recording(
        name=name,
        times=np.arange(len(motion)) / motion.fps,
        positions=positions + quat.rotate(rotations, mounts.offsets),
        rotations=quat.continuous(quat.multiply(rotations, mounts.turns)),
        valid=np.ones((len(motion), 3), dtype=np.bool_),
        mounts=mounts,
        eye_height=eye_height,
        file="",
        sha256="",
        found={
            "format": "simulated trackers",
            "rate": f"{motion.fps:g} frames per second",
            "length": f"{(len(motion) - 1) / motion.fps:.1f} s",
            "eye height": f"{eye_height:.2f} m, headset of the body at ease",
        },
        doubts=(),
    )


def lose_trackers(recording: Recording, names: Iterable[str]) -> Recording:
    """The recording with some of its trackers asleep all the time: not tracked, and lying where they were first.

    Args:
        recording: any.
        names: of `TRACKERS`: "head", "left", "right".
    """
    lost = [TRACKERS.index(name) for name in names]
    positions, rotations = recording.positions.copy(), recording.rotations.copy()
    valid = recording.valid.copy()
    positions[:, lost], rotations[:, lost] = positions[:1, lost], rotations[:1, lost]
    valid[:, lost] = False
    return replace(recording, positions=positions, rotations=rotations, valid=valid)

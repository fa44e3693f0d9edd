"""Motions resampled, mirrored and cut."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..maths import quat
from .motion import Motion
from .skeleton import Skeleton

Array = NDArray[np.floating[Any]]

_MIRROR_VECTOR = np.array([-1.0, 1.0, 1.0])
_MIRROR_ROTATION = np.array([1.0, 1.0, -1.0, -1.0])


def resample(motion: Motion, fps: float) -> Motion:
    """The motion at another rate: rotations by slerp, positions linearly; the first frame stays.

    The result ends at its last frame that the motion still covers.

    Raises:
        InputError: `fps` is not a positive number.
    """
    if not (fps > 0.0 and np.isfinite(fps)):
        raise InputError(f"{fps} frames per second: give a positive number")
    count = len(motion)
    if fps == motion.fps or count < 2:
        return Motion(motion.skeleton, fps, motion.positions, motion.rotations)
    # the small allowance keeps a last frame that only rounding puts past the end
    frames = np.arange(int((count - 1) / motion.fps * fps + 1e-6) + 1) * (motion.fps / fps)
    before = np.minimum(frames.astype(np.intp), count - 2)
    t = np.clip(frames - before, 0.0, 1.0)
    a, b = motion.positions[before], motion.positions[before + 1]
    rotations = quat.slerp(motion.rotations[before], motion.rotations[before + 1], t[:, None])
    return Motion(motion.skeleton, fps, a + (b - a) * t[:, None], quat.continuous(rotations))


def mirror(motion: Motion) -> Motion:
    """The mirror image in the plane X = 0: what the left side did, the right side does.

    Joint names, order and roles stay; offsets are mirrored too, so a skeleton that is not symmetric becomes
    its own mirror image. Mirroring twice gives the motion back, bit for bit.

    Raises:
        InputError: left and right differ in their joints.
    """
    skeleton = motion.skeleton
    swap = mirror_joints(skeleton)
    mirrored = Skeleton(
        names=skeleton.names,
        parents=skeleton.parents,
        offsets=skeleton.offsets[swap] * _MIRROR_VECTOR,
        roles=skeleton.roles,
        tips=skeleton.tips[swap] * _MIRROR_VECTOR,
    )
    return Motion(
        mirrored,
        motion.fps,
        motion.positions * _MIRROR_VECTOR,
        motion.rotations[:, swap] * _MIRROR_ROTATION,
    )


def mirror_joints(skeleton: Skeleton) -> NDArray[np.intp]:
    """`(J,)` each joint's partner on the other side; joints of the middle are their own.

    Raises:
        InputError: left and right differ in their joints.
    """
    roles, parents = skeleton.roles, skeleton.parents.tolist()
    swap = np.full(len(roles), -1, dtype=np.intp)
    for j, role in enumerate(roles):
        if role:
            other = {"L": "R", "R": "L"}.get(role[-1]) if role[-2:-1] == "." else None
            swap[j] = skeleton.find(role[:-1] + other) if other else j
    # joints in between have no role: they pair as the joints below them do
    for j in reversed(range(1, len(roles))):
        p = parents[j]
        if swap[j] >= 0 and not roles[p] and swap[p] < 0:
            swap[p] = parents[swap[j]]
    fits = [swap[j] >= 0 and swap[swap[j]] == j for j in range(len(roles))]
    if not all(fits) or any(swap[parents[j]] != parents[swap[j]] for j in range(1, len(roles))):
        odd = next(
            (name for name, fit in zip(skeleton.names, fits, strict=True) if not fit), skeleton.names[0]
        )
        raise InputError(f"joint {odd} has no partner on the other side; such a skeleton cannot be mirrored")
    return swap


def cut(motion: Motion, start: int, stop: int) -> Motion:
    """Frames `start` up to, not including, `stop`.

    Raises:
        InputError: nothing would be left.
    """
    start, stop = max(start, 0), min(stop, len(motion))
    if start >= stop:
        raise InputError(f"frames {start} to {stop} of {len(motion)}: nothing is left; choose another range")
    return Motion(motion.skeleton, motion.fps, motion.positions[start:stop], motion.rotations[start:stop])

"""What is doubtful about a motion: drift, jumps, facing. Heuristics on degrees of everyday movement."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body.motion import Motion
from ..body.pose import role_poses
from ..body.skeleton import ARM, LEG, SIDES
from ..maths import angles, kinematics, quat

Array = NDArray[np.floating[Any]]

DRIFT = np.radians(35.0)
"""Head and hips of a person do not part by more than this on average over many seconds."""
_DRIFT_PART_S = 8.0
_DRIFT_PARTS = 6
ARM_JUMP = np.radians(40.0)
"""An arm joint does not turn by this from one frame to the next."""
_THROWN = 18.0
"""Metres a second, from the hips, that no hand or foot of a person of usual size reaches: a hard kick is 15."""
_BESIDE_S = 0.1
"""What lies this near to a glitch has been smoothed into it."""
_UPRIGHT = np.cos(np.radians(45.0))
"""Height of the hips' unit up vector from which a body counts as upright."""
_STILL_M, _STEP_M = 0.002, 0.03
"""Metres within which hips stay that an export put in place, and beyond which a foot has moved."""
_NEAR_FLOOR = 0.15
"""Metres for a person of 1.7 m: who touches the floor has a joint below that."""
_HIPS_JUMP = 0.06
"""Metres that hips may be thrown between two frames, beyond what they did before and after."""


def heading_parts(motion: Motion) -> Array | None:
    """Median yaw in radians of the head against the hips, for each sixth (fewer if short) of the motion.

    None for motions shorter than 32 s, in which looking aside is no drift.
    """
    count = min(_DRIFT_PARTS, int(len(motion) / motion.fps / _DRIFT_PART_S))
    if count < 4:
        return None
    _, rotations = role_poses(motion, ("head",))
    aside = angles.wrap(quat.heading(rotations[:, 0]) - quat.heading(motion.rotations[:, 0]))
    return np.array([_circular_median(part) for part in np.array_split(aside, count)])


def drifted(parts: Array) -> NDArray[np.bool_]:
    """Which of the `parts` `(P,)` of `heading_parts` tell of drift; none where the take as a whole does not.

    A person who looks aside for a while looks ahead before and after, so that two parts together count: they are far
    off, or farther from two others than a person turns the head.
    """
    pairs = 0.5 * (parts[1:] + parts[:-1])
    whole = max(np.abs(pairs).max(), np.ptp(pairs)) > DRIFT
    return (np.abs(parts) > DRIFT) & whole


def glitches(motion: Motion) -> NDArray[np.bool_]:
    """Frames `(T,)` in or beside which a limb is thrown as no limb is.

    Limbs are seen from the hips, so that a run counts no more than a walk. Joints that only turn over do not count:
    solvers lose the twist of a straight limb in good takes too.
    """
    skeleton = motion.skeleton
    roles = [
        f"{part}.{side}" for side in SIDES for part in (*ARM, *LEG) if f"{part}.{side}" in skeleton.roles
    ]
    positions, _ = role_poses(motion, tuple(roles))
    away = positions - motion.positions[:, None]
    size = skeleton.leg_length() / 0.85
    far = np.linalg.norm(np.diff(away, axis=0), axis=-1) * motion.fps > _THROWN * size
    wild = far.any(axis=1)
    bad = np.zeros(len(motion), dtype=np.bool_)
    bad[1:] |= wild
    bad[:-1] |= wild
    half = round(_BESIDE_S * motion.fps)
    counts = np.convolve(bad, np.ones(2 * half + 1), mode="same")
    return counts > 0.5


def arm_jumps(motion: Motion) -> NDArray[np.intp]:
    """Frames at which an arm joint has turned by more than 40 degrees since the frame before."""
    skeleton = motion.skeleton
    roles = [f"{part}.{side}" for side in SIDES for part in ARM if f"{part}.{side}" in skeleton.roles]
    arms = motion.rotations[:, [skeleton.joint(role) for role in roles]]
    cosine = np.abs(np.sum(arms[1:] * arms[:-1], axis=-1))
    return np.flatnonzero((cosine < np.cos(0.5 * ARM_JUMP)).any(axis=1)) + 1


def hips_jumps(motion: Motion) -> NDArray[np.intp]:
    """Frames to which the hips jump: dropped frames, splices, solver flips."""
    step = np.linalg.norm(np.diff(motion.positions, axis=0), axis=-1)
    if len(step) < 3:
        return np.zeros(0, dtype=np.intp)
    around = np.maximum(np.append(step[1:], 0.0), np.insert(step[:-1], 0, 0.0))
    return np.flatnonzero(step > 2.0 * around + _HIPS_JUMP) + 1


def toes_aside(motion: Motion) -> float | None:
    """Mean yaw in radians of the toes against the hips while the body is upright and the feet rest, both feet.

    None without toes, and for a body that is never upright: the hips of who lies have no heading.
    """
    skeleton = motion.skeleton
    if any(skeleton.find(f"toe.{side}") < 0 for side in SIDES):
        return None
    feet, _ = role_poses(motion, ("foot.L", "foot.R"))
    toes, _ = role_poses(motion, ("toe.L", "toe.R"))
    speed = np.linalg.norm(kinematics.velocity(toes, motion.fps), axis=-1)
    upright = quat.rotate(motion.rotations[:, 0], np.array([0.0, 0.0, 1.0]))[:, 2] > _UPRIGHT
    if not upright.any():
        return None
    rests = (speed <= np.quantile(speed[upright], 0.3, axis=0)) & upright[:, None]
    aside = angles.yaw_of(toes - feet) - quat.heading(motion.rotations[:, 0])[:, None]
    return float(np.angle(np.sum(np.exp(1j * aside) * rests)))


def in_place(motion: Motion) -> bool:
    """Whether the hips stay at one point, as no living body's do, while the feet move."""
    if len(motion) < motion.fps or np.ptp(motion.positions[:, :2], axis=0).max() > _STILL_M:
        return False
    feet = [motion.skeleton.joint(f"foot.{side}") for side in SIDES]
    ways: Array = np.ptp(motion.forward()[0][:, feet], axis=0)
    return float(ways.max()) > _STEP_M


def in_the_air(motion: Motion) -> float:
    """The longest time in seconds for which no joint is near the floor: who jumps is back within one."""
    least = _NEAR_FLOOR * motion.skeleton.leg_length() / 0.85
    low = np.flatnonzero(motion.forward()[0][..., 2].min(axis=1) <= least)
    gaps = np.diff(np.concatenate([[-1], low, [len(motion)]])) - 1
    return float(gaps.max() / motion.fps)


def walking_aside(motion: Motion) -> tuple[float, float]:
    """Mean yaw in radians of the way walked against the hips, and seconds of walking (above 0.5 m/s)."""
    half = max(int(0.25 * motion.fps), 1)
    if len(motion) <= 2 * half:
        return 0.0, 0.0
    velocity = (motion.positions[2 * half :] - motion.positions[: -2 * half]) * (motion.fps / (2 * half))
    walks = np.linalg.norm(velocity[:, :2], axis=-1) > 0.5
    aside = angles.yaw_of(velocity) - quat.heading(motion.rotations[half:-half, 0])
    mean = np.exp(1j * aside[walks]).sum()
    return float(np.angle(mean)), float(walks.sum() / motion.fps)


def _circular_median(values: Array) -> float:
    centre = np.angle(np.exp(1j * values).mean())
    return float(angles.wrap(centre + np.median(angles.wrap(values - centre))))

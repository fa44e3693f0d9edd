"""Features z: what the search compares (paper, section 5.2; layout in `motion_database`)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body.motion import Motion
from ..body.skeleton import SIDES
from ..maths import angles
from .motion_database import FEATURE_COUNT, FEATURE_GROUPS, HORIZONS_S, FeatureDatabase
from .poses import steps
from .virtual_root import to_root_space

Array = NDArray[np.floating[Any]]

_LEAST_DEVIATION = 1e-5
"""Metres, m/s or parts of a unit vector: what varies less than this does not vary."""


def horizon_frames(fps: float) -> NDArray[np.intp]:
    """The trajectory's horizons in frames `(3,)`."""
    return np.round(np.array(HORIZONS_S) * fps).astype(np.intp)


def clip_features(motion: Motion, root_positions: Array, root_yaws: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Features of every frame of a clip, not yet normalised.

    Positions and velocities are along the root's axes at their frame. Velocities are those in the world,
    steps to the next frame, so they hold the root's motion too. A horizon past the clip's end reads its end.

    Args:
        motion: the clip, `T` frames.
        root_positions: `(T, 2)` metres.
        root_yaws: `(T,)` radians.

    Returns:
        Features `(T, 27)` and `(T,)` whether all horizons lie within the clip.
    """
    frames = np.arange(len(motion))
    ahead = frames[:, None] + horizon_frames(motion.fps)
    future = np.minimum(ahead, len(motion) - 1)
    feet = motion.forward()[0][:, [motion.skeleton.joint(f"foot.{side}") for side in SIDES]]
    from_root = feet.copy()
    from_root[..., :2] -= root_positions[:, None]
    parts = {
        "trajectory_positions": to_root_space(root_positions[future] - root_positions[:, None], root_yaws),
        "trajectory_directions": angles.direction(root_yaws[future] - root_yaws[:, None]),
        "hips_velocity": to_root_space(steps(motion.positions, motion.fps), root_yaws),
    }
    positions = to_root_space(from_root, root_yaws)
    velocities = to_root_space(steps(feet, motion.fps), root_yaws)
    for i, side in enumerate(("left", "right")):
        parts[f"{side}_foot_position"], parts[f"{side}_foot_velocity"] = positions[:, i], velocities[:, i]
    values = np.empty((len(motion), FEATURE_COUNT))
    for group, columns in FEATURE_GROUPS.items():
        values[:, columns] = parts[group].reshape(len(motion), -1)
    return values, ahead[:, -1] < len(motion)


def normalize_features(values: Array, trajectory_valid: NDArray[np.bool_]) -> FeatureDatabase:
    """Features brought to zero mean, and to a mean deviation of one in each group.

    Each column has its own mean; a group's columns share one deviation, the mean of theirs, so that the
    proportions within a group (metres ahead against metres aside) stay as they are. Only frames whose
    trajectory is valid count. A group that does not vary keeps its unit.

    Args:
        values: `(N, 27)` features as `clip_features` gives them.
        trajectory_valid: `(N,)`, at least one True.
    """
    counted = values[trajectory_valid]
    mean = counted.mean(axis=0)
    spread = counted.std(axis=0)
    deviation = np.ones(FEATURE_COUNT)
    for columns in FEATURE_GROUPS.values():
        group = spread[columns].mean()
        deviation[columns] = group if group > _LEAST_DEVIATION else 1.0
    normalized = ((values - mean) / deviation).astype(np.float32)
    return FeatureDatabase(normalized, mean, deviation, trajectory_valid)

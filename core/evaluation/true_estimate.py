"""The body estimate that a perfect predictor would give: what the true motion says of each part."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body.motion import Motion
from ..body.skeleton import SIDES
from ..body.toes import place_toes
from ..body.trunk import spine
from ..database.contacts import find_contacts
from ..database.virtual_root import virtual_root
from ..maths import quat
from ..recording.body_estimate import BodyEstimate, Part

Array = NDArray[np.floating[Any]]


def true_estimate(motion: Motion, head_height: float) -> BodyEstimate:
    """Every part of a known body, without spread.

    Args:
        motion: `T` frames in the world, metres.
        head_height: of the head joint when the body stands upright, metres.
    """
    skeleton = motion.skeleton
    positions, rotations = motion.forward()
    yaws = virtual_root(motion, 0.0)[1]
    seen = quat.from_yaw(-yaws)
    toes = place_toes(skeleton, positions, rotations)
    hips = positions[:, 0]
    floor = positions[:, skeleton.joint("head")] * np.array([1.0, 1.0, 0.0])
    ankles = positions[:, [skeleton.joint(f"foot.{side}") for side in SIDES]]
    feet = (np.stack([ankles, toes], axis=2) - hips[:, None, None]) / head_height
    elbows = positions[:, [skeleton.joint(f"forearm.{side}") for side in SIDES]]
    forearms = elbows - positions[:, [skeleton.joint(f"hand.{side}") for side in SIDES]]
    forearms /= np.maximum(np.linalg.norm(forearms, axis=-1, keepdims=True), 1e-9)
    chest = quat.multiply(seen, rotations[:, spine(skeleton)[-1]])
    return BodyEstimate(
        yaws,
        np.zeros(len(yaws)),
        hips=_part(quat.rotate(seen, (hips - floor) / head_height)),
        feet=_part(quat.rotate(seen[:, None, None], feet)),
        standing=find_contacts(toes, motion.fps).astype(np.float64),
        chest=_part(quat.to_rotation_vector(chest)),
        elbows=_part(quat.rotate(seen[:, None], forearms)),
    )


def _part(mean: Array) -> Part:
    return Part(mean, np.zeros(mean.shape[:-1]))

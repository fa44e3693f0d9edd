"""What the trackers tell of the feet, as evidence for the searches.

Feet are compared from the hips and in the world's axes: how people hold their heads over their hips differs from person
to person, where their feet are from the hips does so much less. A squared distance counts by 1 / (sigma^2 + spread^2),
so an estimate that is unsure of a foot weighs less.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..database.motion_database import FEATURE_GROUPS, TRAJECTORY, MotionDatabase
from ..maths import angles
from ..recording.body_estimate import BodyEstimate
from .root_motion import last_frames
from .schedule import Frames
from .trajectory import FeetEvidence, Trajectory

Array = NDArray[np.floating[Any]]

FEET_M = 0.15
"""Distance of a foot over the ground that costs 1 where the estimate is sure."""
STANDING_WEIGHT = 1.0
"""What it costs where a foot surely stands and the frame's does not, or the other way round."""
SURELY_DOWN, SURELY_UP = 0.6, 0.1
"""How likely a foot stands from which on it does, and up to which it does not, whatever is played."""
LOOKS_S = (0.0, 1.0 / 6.0, 1.0 / 3.0)
"""Seconds ahead at which the feet of likely frames are compared."""
LIKELY = 16
"""Likely frames at a time, no two of them of the same block."""
_BLOCK = 16
_TIMES = 64
"""Times worked on at once: bounds memory."""


def feet_evidence(estimate: BodyEstimate, head_height: float, weight: float) -> FeetEvidence | None:
    """The evidence in an estimate; None where it does not know the feet, or for a `weight` of 0.

    Args:
        estimate: of `T` frames.
        head_height: of the head joint of the databases' body when it stands upright, metres.
        weight: of all of it.
    """
    if estimate.feet is None or weight == 0.0:
        return None
    ankles = estimate.feet.mean[:, :, 0] * head_height
    over_ground = angles.turn(ankles[..., :2], estimate.yaws[:, None])
    spread = estimate.feet.spread[:, :, 0] * head_height
    return FeetEvidence(
        np.concatenate([over_ground, ankles[..., 2:]], axis=-1),
        weight / (FEET_M**2 + spread**2),
        estimate.standing,
    )


def surer_contacts(contacts: NDArray[np.bool_], estimate: BodyEstimate, weight: float) -> NDArray[np.bool_]:
    """Contacts `(T, 2)` of what is played, but those of the user where the estimate is sure of them.

    Args:
        contacts: `(T, 2)` of what is played.
        estimate: of the same frames.
        weight: of the evidence; 0 leaves all as it is.
    """
    if estimate.standing is None or weight == 0.0:
        return contacts
    return (contacts | (estimate.standing > SURELY_DOWN)) & (estimate.standing > SURELY_UP)


class FeetTable:
    """The feet of a database's frames, ready to be held against evidence."""

    def __init__(self, database: MotionDatabase) -> None:
        features = database.features
        columns = [FEATURE_GROUPS[f"{side}_foot_position"] for side in ("left", "right")]
        raw = [features.values[:, c] * features.deviation[c] + features.mean[c] for c in columns]
        self._feet = np.stack(raw, axis=1) - database.poses.hips_positions[:, None]
        """`(N, 2, 3)` ankles from the hips in root space, metres."""
        self._stands = database.poses.contacts.astype(np.float64)
        self._last = last_frames(database)
        self._fps = database.fps

    def costs(self, evidence: FeetEvidence, t: int, frames: Frames, yaws: Array) -> Array:
        """What `frames` `(N,)`, played at `t` with roots at `yaws` `(N,)`, cost by the evidence.

        Over the ground each foot counts, upwards only how much higher one is than the other: suits and people differ
        in where the hips are above the ankles.
        """
        wanted, weights = evidence.ankles[t], evidence.weights[t]
        feet = self._feet[frames]
        away = angles.turn(feet[..., :2], yaws[:, None]) - wanted[:, :2]
        costs = np.einsum("ijk,ijk->ij", away, away) @ weights
        higher = feet[:, 0, 2] - feet[:, 1, 2] - (wanted[0, 2] - wanted[1, 2])
        costs += 0.5 * weights.sum() * higher**2
        if evidence.standing is not None:
            # as sure of what stands as of where the foot is
            share = STANDING_WEIGHT * FEET_M**2 * weights
            costs += (self._stands[frames] - evidence.standing[t]) ** 2 @ share
        return costs

    def columns(self, frames: Frames) -> Array:
        """For each look of `frames` `(N,)` x and y of both ankles and their squared lengths `(N, 6 L)`: their products
        with `questions` are squared distances, up to a constant."""
        parts: list[Array] = []
        for ahead in _looks(self._fps).tolist():
            feet = self._feet[np.minimum(frames + ahead, self._last[frames]), :, :2]
            parts += [feet.reshape(-1, 4), np.einsum("ijk,ijk->ij", feet, feet)]
        return np.concatenate(parts, axis=-1)


def questions(evidence: FeetEvidence, times: Frames, yaws: Array, fps: float) -> Array:
    """What `FeetTable.columns` are multiplied with, `(K, 6 L)`.

    Args:
        evidence: of `T` frames.
        times: `(K,)` of them.
        yaws: `(K, L)` radians: where the roots face at each look.
        fps: frames per second.
    """
    parts: list[Array] = []
    for k, ahead in enumerate(_looks(fps).tolist()):
        then = np.minimum(times + ahead, len(evidence.ankles) - 1)
        weights = evidence.weights[then]
        feet = angles.turn(evidence.ankles[then, :, :2], -yaws[:, k : k + 1])
        parts += [(-2.0 * weights[..., None] * feet).reshape(-1, 4), weights]
    return np.concatenate(parts, axis=-1)


def likely_frames(
    database: MotionDatabase,
    table: FeetTable,
    found: Frames,
    evidence: FeetEvidence,
    trajectory: Trajectory,
    times: Frames,
) -> Frames:
    """The frames `(K, M)` that fit feet and trajectory best at each of `times` `(K,)`, whatever played before.

    They are seen from the target: a body in the right place that faces the right way.

    Args:
        database: its features are compared.
        table: its feet.
        found: `(F,)` frames that may be found.
        evidence: of the feet.
        trajectory: targets and futures.
        times: frames of the recording.
    """
    rows = np.pad(found, (0, -len(found) % _BLOCK), mode="edge")
    features = database.features
    values = features.values[rows, TRAJECTORY]
    squares = np.einsum("ij,ij->i", values, values)[:, None]
    known = np.concatenate([values, squares, table.columns(rows)], axis=-1).astype(np.float32)
    # one frame of every block at a time
    blocks = np.ascontiguousarray(known.reshape(-1, _BLOCK, known.shape[1]).swapaxes(0, 1))
    frames = rows.reshape(-1, _BLOCK)
    count = min(LIKELY, len(frames))
    out = np.empty((len(times), count), dtype=np.intp)
    for start in range(0, len(times), _TIMES):
        part = times[start : start + _TIMES]
        asked = _asked(database, evidence, trajectory, part)
        least = np.full((len(part), len(frames)), np.inf, dtype=np.float32)
        which = np.zeros(least.shape, dtype=np.int8)
        for j, block in enumerate(blocks):
            scores = asked @ block.T
            which[scores < least] = j
            np.minimum(least, scores, out=least)
        best = np.argpartition(least, count - 1, axis=-1)[:, :count]
        out[start : start + _TIMES] = frames[best, np.take_along_axis(which, best, axis=-1)]
    return out


def _asked(
    database: MotionDatabase, evidence: FeetEvidence, trajectory: Trajectory, times: Frames
) -> NDArray[np.float32]:
    """Rows `(K, 13 + 6 L)` whose products with trajectory features, their squares and feet are distances."""
    mean, deviation = (a[TRAJECTORY] for a in (database.features.mean, database.features.deviation))
    here, yaws = trajectory.targets[times][:, None], trajectory.yaws[times][:, None]
    ahead = angles.turn(trajectory.future_positions[times] - here, -yaws).reshape(len(times), -1)
    facing = angles.direction(trajectory.future_yaws[times] - yaws).reshape(len(times), -1)
    wanted = (np.concatenate([ahead, facing], axis=-1) - mean) / deviation
    then = np.minimum(times[:, None] + _looks(database.fps), len(trajectory) - 1)
    feet = questions(evidence, times, trajectory.yaws[then], database.fps)
    parts = -2.0 * wanted, np.ones((len(times), 1)), feet
    return np.concatenate(parts, axis=-1).astype(np.float32)


def _looks(fps: float) -> Frames:
    """`LOOKS_S` in frames `(L,)`."""
    return np.round(np.array(LOOKS_S) * fps).astype(np.intp)

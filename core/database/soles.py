"""How the feet of a database's clips stand: the pitch that a foot has while it stands flat.

Where a file has no T-pose, how a foot lies in it is estimated, and a suit holds the feet of two people differently. The
clips of a database have one skeleton, so that some of them stand with the heel in the floor and some on their toes.
"""

from __future__ import annotations

from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ..body import forward_kinematics as fk
from ..body import heel, hierarchy
from ..body.legs import Leg, legs_of
from ..maths import kinematics, quat
from ..maths.vectors import norm
from .motion_database import Clip, MotionDatabase

Array = NDArray[np.floating[Any]]

_STILL = 0.08
"""m/s: a foot whose toe and ankle are slower stands flat."""
_LOW = 0.05
"""Metres over the toe's height in T-pose: higher it stands on something or not at all."""
_LEAST_S = 0.3
"""Seconds of standing in a clip that tell its pitch."""
_MOST = np.radians(15.0)
"""Greatest pitch that is a suit's; feet that stand so all the time are on their toes on purpose."""

_known: WeakKeyDictionary[MotionDatabase, Array] = WeakKeyDictionary()


def sole_pitches(database: MotionDatabase) -> Array:
    """Pitch `(C, 2)` in radians since T-pose of the left and the right foot that stand, for each clip.

    Above 0 the heel is up. A clip that does not stand has the others' median.
    """
    found = _known.get(database)
    if found is None:
        legs = legs_of(database.skeleton)
        rows = [[_pitch(database, clip, leg) for leg in legs] for clip in database.clips]
        found = np.array(rows).reshape(len(database.clips), len(legs))
        if np.isnan(found).any():
            usual = [np.median(side[~np.isnan(side)]) if (~np.isnan(side)).any() else 0.0 for side in found.T]
            found = np.where(np.isnan(found), usual, found)
        _known[database] = found
    return found


def sole_pitches_at(database: MotionDatabase, frames: NDArray[np.intp]) -> Array:
    """The same `(N, 2)` at frames `(N,)` of the database."""
    starts = np.array([clip.start for clip in database.clips])
    return sole_pitches(database)[np.searchsorted(starts, frames, side="right") - 1]


def _pitch(database: MotionDatabase, clip: Clip, leg: Leg) -> float:
    """Median pitch of one foot while it stands still in a clip; NaN where it does not."""
    skeleton, poses, rows = database.skeleton, database.poses, slice(clip.start, clip.stop)
    chain = hierarchy.path(skeleton.parents, 0, leg.foot)
    places, turns = fk.forward(
        poses.hips_positions[rows],
        poses.rotations[rows][:, chain],
        skeleton.offsets[chain],
        hierarchy.part(skeleton.parents, chain),
    )
    if len(places) < 2:
        return float("nan")
    yaw = quat.from_yaw(poses.root_yaws[rows])
    ankle = quat.rotate(yaw, places[:, -1]) + np.pad(poses.root_positions[rows], ((0, 0), (0, 1)))
    turn = quat.multiply(yaw, turns[:, -1])
    toe = ankle + quat.rotate(turn, leg.to_toe)
    speeds = [norm(kinematics.velocity(points, database.fps)) for points in (ankle, toe)]
    still = (np.maximum(*speeds) < _STILL) & (toe[:, 2] < leg.height + _LOW)
    if still.sum() < _LEAST_S * database.fps:
        return float("nan")
    pitch = float(np.median(heel.pitch_of(turn[still], leg.to_toe).angle)) - leg.flat
    return float(np.clip(pitch, -_MOST, _MOST))

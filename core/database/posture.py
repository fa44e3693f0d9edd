"""How people crouch: how far knees, hips and trunk bend to bring the head down over feet that stay flat."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body import forward_kinematics as fk
from ..body.skeleton import SIDES, Skeleton
from ..body.toes import toe_places
from ..body.trunk import neck, pelvis, spine, thighs_middle
from ..maths import quat

Array = NDArray[np.floating[Any]]

_UPPER_BODY, _THIGHS, _SHINS = 0.678, 0.200, 0.093
"""Shares of the body's mass: head, arms and trunk; both thighs; both shins (Winter 2009, table 4.1)."""
_UP_TRUNK, _DOWN_BONE = 0.626, 0.433
"""Where their centres are: from hip to shoulder; from upper to lower end of thigh and shin (same table)."""
_ONTO_TOES = 0.25
"""Share of the way from ankle to ball of the foot by which the weight is farther forward on level thighs. Of four
people in mocap who crouch, 3 cm in the median."""
_ROUND = (0.5, 1.5)
"""Tilt of pelvis and chest as shares of the trunk's: backs round. Three of these people's: 0.4 to 0.7 and 1.2 to
1.6."""
_ARMS = 0.6
"""The same of the upper arms; theirs mostly 0.3 to 0.9."""
_FOLDED: float = np.radians(120.0)
"""Greatest angle of the thighs from the vertical: past level, hips lower than knees."""
_BOWED: float = np.radians(60.0)
"""Farther than any trunk leans over folded thighs."""
_STEPS = 240


@dataclass(frozen=True, slots=True, eq=False)
class Crouch:
    """Postures from standing to fully crouched, by how far the head comes down."""

    drop: Array
    """`(K,)` metres that the head is lower, rising from 0."""
    lean: Array
    """`(K,)` radians by which the trunk, from hips to shoulders, leans forward."""
    back: Array
    """`(K,)` metres that the hips are farther back."""
    sink: Array
    """`(K,)` metres that the hips are lower."""


def crouching(skeleton: Skeleton) -> Crouch:
    """The postures of a body from its T-pose down.

    Two rules leave one posture for each height of the head: the centre of mass stays over the feet, but goes a
    little towards their balls, and the trunk leans forward as far as the shins do, the squat's rule of parallel
    lines (Myer et al. 2014, "The back squat").
    """
    lean: Array = np.linspace(0.0, _BOWED, _STEPS)
    shoulders, head = _leaned(skeleton, lean)
    thigh, shin = (_length(skeleton, bone) for bone in ("shin", "foot"))
    ahead = _UPPER_BODY * _UP_TRUNK * (shoulders[:, 1] - shoulders[0, 1])
    ahead += (_THIGHS * _DOWN_BONE + _SHINS * (1.0 - _DOWN_BONE)) * shin * np.sin(lean)
    carried = _UPPER_BODY + _THIGHS * (1.0 - _DOWN_BONE)
    forward = _ONTO_TOES * _ankle_to_ball(skeleton) / carried
    # each lean needs the hips so far behind the knees; below level thighs it grows less again
    folded: Array = np.linspace(0.0, _FOLDED, _STEPS)
    needed = (shin * np.sin(lean) + ahead / carried) / (thigh + forward)
    balanced: Array = np.interp(np.sin(folded), needed, lean)
    back = thigh * np.sin(folded) - shin * np.sin(balanced)
    sink = thigh * (1.0 - np.cos(folded)) + shin * (1.0 - np.cos(balanced))
    lowered: Array = head[:1, 2] - head[:, 2]
    bowed: Array = np.interp(balanced, lean, lowered)
    return Crouch(sink + bowed, balanced, back, sink)


def lean_shares(skeleton: Skeleton) -> Array:
    """`(J,)` how far each joint tilts forward as a share of the trunk's lean.

    The back rounds from pelvis to chest, the neck takes half the chest's tilt and the head none: people go on
    looking where they looked. Upper arms follow the trunk in part, forearms and hands keep their directions.
    """
    shares = np.full(len(skeleton), np.nan)
    trunk = spine(skeleton)
    places = np.concatenate([[0.0], np.cumsum(np.linalg.norm(skeleton.offsets[trunk[1:]], axis=-1))])
    shares[trunk] = np.interp(places / places[-1], (0.0, 1.0), _ROUND) if len(trunk) > 1 else 1.0
    shares[pelvis(skeleton)] = shares[trunk[0]]
    shares[neck(skeleton)] = 0.5 * shares[trunk[-1]]
    shares[skeleton.joint("head")] = 0.0
    for side in SIDES:
        shares[skeleton.joint(f"upper_arm.{side}")] = _ARMS
        shares[skeleton.joint(f"forearm.{side}")] = 0.0
    for joint, parent in enumerate(skeleton.parents.tolist()):
        if np.isnan(shares[joint]):
            shares[joint] = shares[parent]
    return shares


def _leaned(skeleton: Skeleton, lean: Array) -> tuple[Array, Array]:
    """Middle of the shoulders and head joint `(K, 3)` from the thigh joints' middle, in T-pose but for the lean."""
    turns = quat.from_axis("X", -lean[:, None] * lean_shares(skeleton))
    hips = -quat.rotate(turns[:, 0], thighs_middle(skeleton))
    places = fk.joint_positions(hips, turns, skeleton.offsets, skeleton.parents)
    arms = [skeleton.joint(f"upper_arm.{side}") for side in SIDES]
    return places[:, arms].mean(axis=1), places[:, skeleton.joint("head")]


def _ankle_to_ball(skeleton: Skeleton) -> float:
    """Metres ahead from ankle to toe joint in T-pose, mean of both sides."""
    joints, shifts = toe_places(skeleton)
    standing = skeleton.tpose_positions()
    ankles = standing[[skeleton.joint(f"foot.{side}") for side in SIDES]]
    return float((standing[joints] + shifts - ankles)[:, 1].mean())


def _length(skeleton: Skeleton, end: str) -> float:
    """Metres of the bone that ends at a joint, mean of both sides."""
    joints = [skeleton.joint(f"{end}.{side}") for side in SIDES]
    return float(np.linalg.norm(skeleton.offsets[joints], axis=-1).mean())

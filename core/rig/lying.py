"""Bodies that lie: what no database of people on their feet knows, and what is safe to show of it.

A head that is near the floor and tipped over belongs to a body that lies. Trunk and legs then lie straight from the
head on, flat on the floor, on the side on which the head is; only head and hands move as the trackers say.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body.legs import legs_of
from ..body.motion import Motion
from ..body.pose import world_poses
from ..maths import angles, filters, quat
from ..maths.easing import smoothstep
from ..maths.vectors import dot, level, norm, unit
from .feet import FootPlan

Array = NDArray[np.floating[Any]]

_LOW, _LOWEST = 0.45, 0.3
"""Heights of the head joint over its height in T-pose between which a tipped head comes to lie."""
_TIPPED, _OVER = 0.7, 0.35
"""Upward part of the head's up axis between which it does."""
_SETTLE_S = 0.25
"""Standard deviation in seconds of the smoothing of lying down and getting up."""
_TRUNK_FIRST = 0.6
"""How much a body lies before its legs do: below a trunk that is not flat yet they would be in the floor."""
_TELLS = 12.0
"""How fast a head tells less of that the higher it is: by a factor of e for each twelfth of the body's height."""
_CRAWLING = 0.5
"""Say of where an upright head looks beside where a tipped one points."""
_SQUAT, _SEATED = 0.45, 0.25
"""Heights of the hips as a share of the leg's length between which feet come out from under them."""
_FOLDED = 0.5
"""Of a leg's length, how far the ankles of who sits on the floor are ahead of the thighs."""
_STRETCHED = 0.96
"""Of a leg's length, how far the ankles of who lies are from the thighs."""
_UP, _FORWARD = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])


def lying(positions: Array, rotations: Array, standing: float, fps: float) -> Array:
    """How much `(T,)` the body lies, from 0 to 1.

    Args:
        positions: `(T, 3)` of the head joint, metres.
        rotations: `(T, 4)` its world rotation since T-pose.
        standing: height of the head joint in T-pose, metres.
        fps: frames per second.
    """
    low = smoothstep(np.clip((_LOW - positions[:, 2] / standing) / (_LOW - _LOWEST), 0.0, 1.0))
    up = quat.rotate(rotations, _UP)[:, 2]
    tipped = smoothstep(np.clip((_TIPPED - up) / (_TIPPED - _OVER), 0.0, 1.0))
    return filters.gaussian(low * tipped, _SETTLE_S * fps)


def flat(positions: Array, rotations: Array, standing: float, fps: float) -> Array:
    """World rotations `(T, 4)` of a trunk that lies flat behind a head: on the back, the belly or the side as the head
    lies, and on the belly behind one that is upright, as who crawls. Arguments as for `lying`.

    Where it is going to lie, or has lain, tells best which way a body goes down.
    """
    up = quat.rotate(rotations, _UP)
    ahead = level(up) + _CRAWLING * np.maximum(up[:, 2:], 0.0) * level(quat.rotate(rotations, _FORWARD))
    tells = np.exp(-_TELLS * positions[:, 2] / standing)[:, None]
    ahead = filters.gaussian(tells * ahead, 2.0 * _SETTLE_S * fps)
    return quat.multiply(quat.between(up, ahead + 1e-9 * _FORWARD), rotations)


def towards(given: Array, goal: Array, weight: Array) -> Array:
    """`given` rotations `(T, 4)` turned to `goal` by weights `(T,)`, the same way round over time: the shortest
    way would change sides at half a turn."""
    away = quat.continuous(quat.multiply(goal, quat.conjugate(given)))
    sine = norm(away[:, 1:])
    angle = 2.0 * np.arctan2(sine, away[:, 0]) * weight
    vector = away[:, 1:] * (angle / np.maximum(sine, 1e-12))[:, None]
    return quat.multiply(quat.from_rotation_vector(vector), given)


def lay_feet(plan: FootPlan, body: Motion, trunk: Array, weight: Array) -> FootPlan:
    """The plan with its feet out from under a body that sits low, and stretched out behind one that lies.

    Args:
        plan: where the feet of a body on its feet would go.
        body: with the trunk where it is to be.
        trunk: `(T, 4)` from `flat`.
        weight: `(T,)` from `lying`.
    """
    legs = legs_of(body.skeleton)
    hips, _ = world_poses(body, [leg.thigh for leg in legs])
    height = body.positions[:, 2] / body.skeleton.leg_length()
    sits = smoothstep(np.clip((_SQUAT - height) / (_SQUAT - _SEATED), 0.0, 1.0))
    if not sits.any():
        return plan
    share = smoothstep(np.clip((weight - _TRUNK_FIRST) / (1.0 - _TRUNK_FIRST), 0.0, 1.0))
    behind = -level(quat.rotate(trunk, _UP))
    ahead = level(quat.rotate(body.rotations[:, 0], _FORWARD)) + 2.0 * weight[:, None] * behind
    ahead = unit(filters.gaussian(ahead, _SETTLE_S * body.fps))
    yaw = quat.from_yaw(angles.yaw_of(behind))
    toes, turns = plan.toes.copy(), plan.rotations.copy()
    for side, leg in enumerate(legs):
        under = dot(toes[:, side] - quat.rotate(turns[:, side], leg.to_toe) - hips[leg.thigh], ahead)
        away = sits * np.maximum(_FOLDED * leg.length - under, 0.0)
        toes[:, side] += filters.gaussian(away, 0.5 * _SETTLE_S * body.fps)[:, None] * ahead
        goal = level(hips[leg.thigh]) + _STRETCHED * leg.length * behind + quat.rotate(yaw, level(leg.to_toe))
        goal[:, 2] = leg.height
        toes[:, side] += share[:, None] * (goal - toes[:, side])
        turns[:, side] = towards(turns[:, side], yaw, share)
    return replace(plan, toes=toes, rotations=turns, contacts=plan.contacts & (sits < 0.5)[:, None])

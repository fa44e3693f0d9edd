"""Weights by which the joints of a skeleton carry the skin around them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...body.skeleton import SIDES, Skeleton
from . import anatomy
from .anatomy import Landmarks

Array = NDArray[np.floating[Any]]

_SOFT = 0.011
"""Metres by which a vertex must be farther from one limb than from another to be carried e times less by it."""
_LEAST = 0.01
"""Weights below this are left out."""


def weights(points: Array, skeleton: Skeleton, body: Landmarks) -> Array:
    """Share of each joint `(V, J)` in carrying points `(V, 3)` of the body's skin; rows add up to 1.

    A point belongs to the limbs whose surfaces it is near, and never to a limb of the other side. Along the trunk
    vertebrae share it by height.
    """
    soft = _SOFT * body.size
    trunk = np.min([loft(points) for loft in anatomy.trunk(body)], axis=0)
    names, fields = ["trunk"], [trunk]
    for side in SIDES:
        other = -np.sign(body[f"side.{side}"][0]) * (points[:, 0] - body["hips"][0])
        for role, loft in {**anatomy.arm(body, side), **anatomy.leg(body, side)}.items():
            names.append(role)
            # limbs of the other side are as far away as they are beyond the middle
            fields.append(loft(points) + 4.0 * np.maximum(other, 0.0))
    far = np.stack(fields, axis=1)
    share = np.exp(-(far - far.min(axis=1, keepdims=True)) / soft)
    share /= share.sum(axis=1, keepdims=True)
    out = np.zeros((len(points), len(skeleton)))
    for column, role in enumerate(names):
        if role == "trunk":
            out += share[:, column : column + 1] * _along_trunk(points, skeleton, body)
        elif role.startswith("foot"):
            toe = _beyond(points[:, 1], body[role.replace("foot", "toe")][1], 0.025 * body.size)
            side = role[-1]
            _give(out, skeleton, (f"toe.{side}", role), share[:, column] * toe)
            _give(out, skeleton, (role,), share[:, column] * (1.0 - toe))
        elif role.startswith("clavicle"):
            _give(out, skeleton, (role, "chest", "spine3", "spine2", "spine1", "hips"), share[:, column])
        else:
            _give(out, skeleton, (role,), share[:, column])
    out[out < _LEAST] = 0.0
    return out / out.sum(axis=1, keepdims=True)


def _give(out: Array, skeleton: Skeleton, roles: tuple[str, ...], share: Array) -> None:
    """Add weights to the first of the roles that the skeleton has."""
    joint = next(found for role in roles if (found := skeleton.find(role)) >= 0)
    out[:, joint] += share


def _along_trunk(points: Array, skeleton: Skeleton, body: Landmarks) -> Array:
    """Share of each joint of the trunk `(V, J)`: each carries what is between the middles of its bone and the next."""
    roles = anatomy.spine_roles(skeleton)
    starts = np.array([body[role][2] for role in roles])
    # the hips carry the pelvis up to the first vertebra, the head all that is above the chin
    middles = np.append(0.5 * (starts[:-1] + starts[1:]), starts[-1] + 0.02 * body.size)
    middles[0] = starts[0]
    heights = np.clip(points[:, 2], middles[0], middles[-1])
    # the jaw is lower than the joint that it turns with
    s = body.size
    jaw = _beyond(points[:, 1], body["head"][1] + 0.050 * s, 0.02 * s)
    jaw *= _beyond(points[:, 2], body["head"][2] - 0.075 * s, 0.015 * s)
    heights = heights + jaw * (middles[-1] - heights)
    out = np.zeros((len(points), len(skeleton)))
    for n, role in enumerate(roles):
        out[:, skeleton.joint(role)] = np.interp(heights, middles, np.eye(len(roles))[n])
    return out


def _beyond(values: Array, border: float, width: float) -> Array:
    """0 before a border and 1 after it, eased over `width` on each side."""
    t = np.clip(0.5 + 0.5 * (values - border) / width, 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)

"""The body under the head: by how much the head is ahead of the hips, learned from the motion databases.

A head that comes down or tips over tells of a lean, much the same one for different people. A linear model of the
databases' own poses takes most of the distance between head and hips out of the target of the virtual root. Where the
body estimate knows the hips too, both answers are weighed by how far off they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body import forward_kinematics as fk
from ..body import hierarchy
from ..database.motion_database import MotionDatabase
from ..maths import angles, quat
from ..recording.body_estimate import BodyEstimate

Array = NDArray[np.floating[Any]]

_SAMPLES = 20_000
"""Poses that the model is learned from, at most."""
_TREMOR = np.array([0.05, 0.01, 0.05])
"""Spread of side tilt, height in metres and forward tilt that means nothing: shrinks what little movement shows."""
_TAIL = 1.0
"""Percent at either end that is not trusted: beyond, inputs and leans count as there."""

_OWN_M = 0.04
"""Metres in each direction that the databases' lean is off."""
_SUIT_M = 0.04
"""Metres in each direction that an estimate is off beside its spread, for suits and people that it has not seen."""


def body_targets(
    head_positions: Array, head_rotations: Array, yaws: Array, databases: Sequence[MotionDatabase]
) -> Array:
    """Where on the ground the hips are, `(T, 2)` in metres.

    Args:
        head_positions: `(T, 3)` head joint in the world, metres, scaled to the databases' body.
        head_rotations: `(T, 4)` of the head joint since T-pose.
        yaws: `(T,)` radians, body orientation.
        databases: whose poses show how this body leans; all of one skeleton.
    """
    stride = -(-sum(len(database) for database in databases) // _SAMPLES)
    known = [_head_in_root_space(database, slice(None, None, stride)) for database in databases]
    places = np.concatenate([place for place, _ in known])
    ups = np.concatenate([up for _, up in known])
    up = quat.rotate(quat.multiply(quat.from_yaw(-yaws), head_rotations), np.array([0.0, 0.0, 1.0]))

    seen = np.column_stack([ups[:, 0], places[:, 2], ups[:, 1]])
    here = np.column_stack([up[:, 0], head_positions[:, 2], up[:, 1]])
    low, high = np.percentile(seen, [_TAIL, 100.0 - _TAIL], axis=0)
    seen, here = np.clip(seen, low, high), np.clip(here, low, high)
    # a body has no side: left and right leans mirror each other, so side inputs and offsets have no mean
    centre = np.array([0.0, *seen[:, 1:].mean(axis=0)])
    ahead = float(places[:, 1].mean())
    side = _fit(seen[:, :1] - centre[:1], places[:, 0], _TREMOR[:1])
    front = _fit(seen[:, 1:] - centre[1:], places[:, 1] - ahead, _TREMOR[1:])
    away = np.column_stack([(here - centre)[:, :1] @ side, ahead + (here - centre)[:, 1:] @ front])
    away = np.clip(away, *np.percentile(places[:, :2], [_TAIL, 100.0 - _TAIL], axis=0))
    return head_positions[:, :2] - angles.turn(away, yaws)


def with_estimate(targets: Array, heads: Array, estimate: BodyEstimate, head_height: float) -> Array:
    """Targets `(T, 2)` drawn to where an estimate has the hips; the same where it knows none.

    Args:
        targets: `(T, 2)` from `body_targets`, metres.
        heads: `(T, 2)` head joint over the ground, metres.
        estimate: of the same frames.
        head_height: of the head joint of the databases' body when it stands upright, metres.
    """
    if estimate.hips is None:
        return targets
    hips = heads + angles.turn(estimate.hips.mean[:, :2] * head_height, estimate.yaws)
    off = _SUIT_M**2 + (estimate.hips.spread * head_height) ** 2
    share = _OWN_M**2 / (_OWN_M**2 + off)
    return targets + share[:, None] * (hips - targets)


def _fit(inputs: Array, outputs: Array, tremor: Array) -> Array:
    """Coefficients of a ridge regression through the origin."""
    count = len(inputs)
    # no BLAS product, which rounds by the number of threads where it is large
    squares: Array = np.einsum("ti,tj->ij", inputs, inputs)
    products: Array = np.einsum("ti,t->i", inputs, outputs)
    return np.linalg.solve(squares / count + np.diag(tremor**2), products / count)


def _head_in_root_space(database: MotionDatabase, rows: slice) -> tuple[Array, Array]:
    """Positions of the head `(N, 3)` and its up axis `(N, 3)` in root space, for some rows of the poses."""
    skeleton, poses = database.skeleton, database.poses
    chain = hierarchy.path(skeleton.parents, 0, skeleton.joint("head"))
    places, turns = fk.forward(
        poses.hips_positions[rows],
        poses.rotations[rows][:, chain],
        skeleton.offsets[chain],
        hierarchy.part(skeleton.parents, chain),
    )
    return places[:, -1], quat.rotate(turns[:, -1], np.array([0.0, 0.0, 1.0]))

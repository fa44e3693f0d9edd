"""Hips and chest under the head: a linear model of the motion databases' own bodies.

A head that comes down, tips over or sways tells of a lean, much the same one for different people. The model is a ridge
regression from a short window of the trackers, as the databases' bodies would carry them, to the place of the hips and
the turn of the chest. It is made of sums over frames, so databases are learned from one by one and any choice of them
costs next to nothing. A hand that was not tracked is left out of the sums, which is what the most likely posture given
the rest is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ..body import forward_kinematics as fk
from ..body import hierarchy
from ..body.trunk import spine
from ..database.motion_database import MotionDatabase
from ..maths import angles, linear, quat
from ..recording.recording import TRACKER_ROLES
from ..recording.windows import (
    FACING,
    TRACKED,
    WindowLayout,
    mirror_inputs,
    stream,
    take_windows,
    window_inputs,
)

Array = NDArray[np.floating[Any]]

LAYOUT = WindowLayout(np.array([-1.0, -0.5, -0.25, 0.0, 0.25, 0.5, 1.0]), 3)
"""Denser windows, and random features on top of them, find the hips of people in no database no better."""
_RATE = 20.0
"""Frames a second that are looked at."""
_WINDOWS = 8000
"""Windows of a database that are learned from, at most."""
_NOISE = (0.02, 0.05, 0.1, 0.2, 0.15)
"""What means nothing in each group of the inputs, in their units: shrinks what little movement shows."""
_TAIL = 1.0
"""Percent at either end that is not trusted: beyond, hips count as there."""
_CHUNK = 4096
_SIDES = np.array([-1.0, 1.0, 1.0, -1.0, -1.0])
"""Signs of the answers in the mirror: hips to the right and ahead, then the chest's rotation vector."""
_HIPS = slice(0, 2)
_CHEST = slice(2, 5)


@dataclass(frozen=True, slots=True, eq=False)
class Posture:
    """How a body holds itself under its head, in the world."""

    hips: Array
    """`(T, 2)` from the head joint to the hips over the ground, metres."""
    chest: Array
    """`(T, 4)` the chest's rotation since T-pose."""


@dataclass(frozen=True, slots=True, eq=False)
class Sums:
    """What a ridge regression needs of the windows of some bodies and of their mirror images."""

    mean: Array
    """`(D,)` of the inputs."""
    squares: Array
    """`(D, D)` covariance of the inputs."""
    products: Array
    """`(D, 5)` covariance of inputs and answers."""
    usual: Array
    """`(5,)` mean of the answers in the headset's axes: hips from the head in head heights, right and ahead, and the
    chest's rotation vector in radians."""
    reach: Array
    """`(2, 5)` lowest and highest trusted answers."""
    count: int


_known: WeakKeyDictionary[MotionDatabase, Sums] = WeakKeyDictionary()


def sums_of(database: MotionDatabase) -> Sums:
    """The sums of one database, which are kept as long as the database is."""
    found = _known.get(database)
    if found is None:
        found = _known[database] = _sums(*_windows(database))
    return found


def pooled(parts: Sequence[Sums]) -> Sums:
    """The sums of several databases together."""
    share = np.array([part.count for part in parts], dtype=np.float64)
    share /= share.sum()
    mean = sum(w * part.mean for w, part in zip(share, parts, strict=True))
    usual = np.asarray(sum(w * part.usual for w, part in zip(share, parts, strict=True)))
    squares, products = np.zeros_like(parts[0].squares), np.zeros_like(parts[0].products)
    for weight, part in zip(share, parts, strict=True):
        off = part.mean - mean
        squares += weight * (part.squares + off[:, None] * off)
        products += weight * (part.products + off[:, None] * (part.usual - usual))
    reach = np.stack(
        [np.min([part.reach[0] for part in parts], axis=0), np.max([part.reach[1] for part in parts], axis=0)]
    )
    return Sums(np.asarray(mean), squares, products, usual, reach, int(sum(part.count for part in parts)))


def posture_of(
    sums: Sums,
    positions: Array,
    rotations: Array,
    valid: NDArray[np.bool_],
    head_height: float,
    fps: float,
) -> Posture:
    """The posture at each frame.

    Args:
        sums: of the databases whose bodies lean alike.
        positions: `(T, 3, 3)` world positions of head, left and right hand joint, metres.
        rotations: `(T, 3, 4)` their world rotations since T-pose.
        valid: `(T, 3)` whether each was tracked.
        head_height: of the head joint when the wearer stands upright, metres.
        fps: frames per second.
    """
    rows, frames = stream(positions, rotations, valid, head_height), np.arange(len(positions))
    models: dict[tuple[bool, bool], Array] = {}
    hips, chest = np.empty((len(rows), 2)), np.empty((len(rows), 4))
    for low in range(0, len(rows), _CHUNK):
        times = frames[low : low + _CHUNK] / fps
        windows = take_windows(rows, times, fps, LAYOUT)
        yaws = angles.yaw_of(windows[:, LAYOUT.centre, FACING].astype(np.float64))
        inputs = window_inputs(windows, yaws, LAYOUT).astype(np.float64) - sums.mean
        seen = (windows[..., TRACKED] == 1.0).all(axis=1)
        found = np.empty((len(times), len(_SIDES)))
        for hands in {(bool(a), bool(b)) for a, b in seen}:
            if hands not in models:
                models[hands] = _model(sums, hands)
            chosen = (seen == hands).all(axis=1)
            found[chosen] = np.einsum("ti,ij->tj", inputs[chosen], models[hands])
        found = np.clip(found + sums.usual, *sums.reach)
        hips[low : low + _CHUNK] = angles.turn(found[:, _HIPS], yaws)
        turned = quat.from_rotation_vector(found[:, _CHEST])
        chest[low : low + _CHUNK] = quat.multiply(quat.from_yaw(yaws), turned)
    return Posture(hips * head_height, chest)


def _model(sums: Sums, hands: tuple[bool, bool]) -> Array:
    """Coefficients `(D, 5)` where these hands are tracked; 0 for what is not seen."""
    noise = np.empty(LAYOUT.inputs)
    for group, deviation in zip(LAYOUT.groups, _NOISE, strict=True):
        noise[group] = deviation
    kept = np.flatnonzero(_seen(hands))
    out = np.zeros((LAYOUT.inputs, len(_SIDES)))
    squares = sums.squares[np.ix_(kept, kept)] + np.diag(noise[kept] ** 2)
    out[kept] = linear.solve(squares, sums.products[kept])
    return out


def _seen(hands: tuple[bool, bool]) -> NDArray[np.bool_]:
    """`(D,)` which inputs do not depend on a hand that is not tracked."""
    samples, turning = len(LAYOUT.offsets), len(LAYOUT.turning)
    both = np.array(hands)
    parts = (
        np.ones(3 * samples, dtype=np.bool_),
        np.tile(np.repeat(both, 3), samples),
        np.ones(2 * samples, dtype=np.bool_),
        np.tile(both, samples),
        np.tile(np.repeat(np.array([True, *hands]), 6), turning),
    )
    return np.concatenate(parts)


def _sums(inputs: Array, answers: Array) -> Sums:
    """Of inputs `(N, D)` and answers `(N, 5)`. A body has no side, so that means and covariances are those of both."""
    count = len(inputs)
    mean: Array = inputs.mean(axis=0)
    mean = 0.5 * (mean + mirror_inputs(mean[None], LAYOUT)[0])
    usual = answers.mean(axis=0) * (_SIDES > 0.0)
    inputs = inputs - mean
    answers = answers - usual
    # no BLAS product, which rounds by the number of threads where it is large
    squares: Array = np.einsum("ti,tj->ij", inputs, inputs) / count
    products: Array = np.einsum("ti,tj->ij", inputs, answers) / count
    other = mirror_inputs(mirror_inputs(squares, LAYOUT).T, LAYOUT)
    images = mirror_inputs(products.T, LAYOUT).T * _SIDES
    both = np.concatenate([answers, answers * _SIDES])
    reach = np.percentile(both, [_TAIL, 100.0 - _TAIL], axis=0) + usual
    return Sums(mean, 0.5 * (squares + other), 0.5 * (products + images), usual, reach, count)


def _windows(database: MotionDatabase) -> tuple[Array, Array]:
    """Inputs `(N, D)` and answers `(N, 5)` in the headset's axes."""
    step = max(1, round(database.fps / _RATE))
    asked_every = max(1, -(-len(database) // (step * _WINDOWS)))
    fps = database.fps / step
    inputs: list[Array] = []
    answers: list[Array] = []
    for clip in database.clips:
        span = slice(clip.start, clip.stop, step)
        positions, rotations, centres = _trackers(database, span)
        rows = stream(
            positions, rotations, np.ones((len(positions), 3), dtype=np.bool_), database.head_height
        )
        asked = np.arange(0, len(rows), asked_every)
        yaws = angles.yaw_of(rows[asked, FACING].astype(np.float64))
        inputs.append(window_inputs(take_windows(rows, asked / fps, fps, LAYOUT), yaws, LAYOUT))
        away = (centres[asked] - positions[asked, 0])[:, :2] / database.head_height
        turned = quat.multiply(quat.from_yaw(-yaws), _chests(database, span)[asked])
        answers.append(np.c_[angles.turn(away, -yaws), quat.to_rotation_vector(turned)])
    return np.concatenate(inputs).astype(np.float64), np.concatenate(answers)


def _trackers(database: MotionDatabase, rows: slice) -> tuple[Array, Array, Array]:
    """Joints of head and hands, and hips, of some frames of one clip, as in a world whose origin is the clip's:
    `(N, 3, 3)`, `(N, 3, 4)` and `(N, 3)`."""
    skeleton, poses = database.skeleton, database.poses
    positions: list[Array] = []
    rotations: list[Array] = []
    for role in TRACKER_ROLES:
        chain = hierarchy.path(skeleton.parents, 0, skeleton.joint(role))
        places, turns = fk.forward(
            poses.hips_positions[rows],
            poses.rotations[rows][:, chain],
            skeleton.offsets[chain],
            hierarchy.part(skeleton.parents, chain),
        )
        positions.append(places[:, -1])
        rotations.append(turns[:, -1])
    turn = quat.from_yaw(poses.root_yaws[rows])
    root = np.pad(poses.root_positions[rows], ((0, 0), (0, 1)))
    joints = quat.rotate(turn[:, None], np.stack(positions, axis=1)) + root[:, None]
    hips = quat.rotate(turn, poses.hips_positions[rows]) + root
    return joints, quat.multiply(turn[:, None], np.stack(rotations, axis=1)), hips


def _chests(database: MotionDatabase, rows: slice) -> Array:
    """World rotations `(N, 4)` of the chest since T-pose in some frames of one clip."""
    skeleton, poses = database.skeleton, database.poses
    chain = hierarchy.path(skeleton.parents, 0, spine(skeleton)[-1])
    turns = fk.global_rotations(poses.rotations[rows][:, chain], hierarchy.part(skeleton.parents, chain))
    return quat.multiply(quat.from_yaw(poses.root_yaws[rows]), turns[:, -1])

"""The head at the headset: neck and spine share its turn, hips and spine close the way to it.

The head joint ends exactly at its target. Its turn is shared with neck and chest. Where it is known how the chest is
turned, the trunk is brought there. Elsewhere a head that is higher than the motion's draws spine and neck straight, and
one that is much lower bends the trunk forward. Of the way that is left, the slow part over the ground moves the body,
the quick part bends the spine, and the hips take the rest, which is mostly height. Where it is known whereabouts the
hips should be, they go most of that way and the spine bends back to the head. Legs are to be solved afterwards.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body import forward_kinematics as fk
from ..body import heel, hierarchy
from ..body.motion import Motion
from ..body.pose import with_world_rotations
from ..body.trunk import neck, pelvis, spine
from ..maths import filters, quat
from ..maths.easing import smoothstep
from ..maths.vectors import dot, norm
from . import validity
from .known import Known
from .lying import towards

Array = NDArray[np.floating[Any]]

_CHEST_SHARE = 0.18
"""Share of the head's turn that reaches the chest; the neck lies half way between chest and head."""
_SLOW_S = 0.35
"""Standard deviation in seconds of the smoothing that tells the body's own drift from a lean."""
_UPRIGHT = 0.8
"""Greatest share of the way to a straight spine and neck that a higher head draws them up."""
_POSTURE_S = 0.15
"""Standard deviation in seconds of the smoothing of what draws them up."""
_CARRY_S = 0.1
"""Standard deviation in seconds of the smoothing of the way from hips to head, so that hips under a steady head
are steady, whatever the matched spine does; 0.05 leaves them half as jerky again as people's, 0.2 bends the spine
twice as much for nothing."""
_HIPS_SHARE = 0.7
"""Share of the slow way from the hips to where they should be that the hips go, the spine bending under the head.
Users of the same suit as the database then have their hips at 5.7 cm from the true ones instead of 7.1, of another suit
at 6.0 instead of 5.6; either way as much nearer to the target."""
_CHEST_S = 0.1
"""Standard deviation in seconds of the smoothing of what turns the chest to where it should be."""
_PELVIS_SHARE = 0.3
"""Share of that turn which the pelvis takes, but for its yaw."""
_OWN = 0.002
"""Metres by which a head shakes beside the motion's own before that takes hold."""
_BEND = np.radians(20.0)
"""Greatest bend of the spine towards the head."""
_STOOP_FROM, _STOOP = 0.05, 0.9
"""Metres the head may sink below the motion's before the trunk bends, and radians for each metre further."""
_LOWEST_HIPS = 0.25
"""Least height of the hips as a share of the leg's length."""
_SEATED = 0.1
"""The same where it is known how the trunk is turned: who sits or lies on the floor."""
_DEEPEST_STOOP = np.radians(100.0)
_UP = np.array([0.0, 0.0, 1.0])


def place_head(
    motion: Motion,
    positions: Array,
    rotations: Array,
    valid: NDArray[np.bool_],
    known: Known | None = None,
    lying: tuple[Array, Array] | None = None,
) -> tuple[Motion, Array]:
    """`motion` with its head joint at a target.

    Args:
        motion: metres.
        positions: `(T, 3)` where the head joint shall be, metres.
        rotations: `(T, 4)` its world rotation since T-pose.
        valid: `(T,)` whether the headset was tracked; elsewhere the head is left to the motion.
        known: `roots` and `chest` are used; without them the motion has its way.
        lying: world rotations `(T, 4)` of a trunk that lies flat, and how much `(T,)` the body lies (`core.rig.lying`).

    Returns:
        The motion, its legs carried along by the hips, and how far `(T, 2)` the body was moved over the
        ground: feet should be moved as much before they are locked.
    """
    if not valid.any():
        return motion, np.zeros((len(motion), 2))
    chain = _Chain(motion)
    weight = validity.weights(valid, motion.fps)[:, None]
    turn = quat.multiply(rotations, quat.conjugate(chain.rotations[:, -1]))
    turn = quat.to_rotation_vector(validity.carry_rotations(turn, valid)) * weight
    away = validity.carry(positions - chain.head(), valid) * weight
    target = chain.head() + away

    chain.turn_head(turn)
    known = known or Known()
    if known.chest is not None:
        chain.hold_chest(known.chest, weight[:, 0], motion.fps)
    else:
        chain.straighten(filters.gaussian(target[:, 2] - chain.head()[:, 2], _POSTURE_S * motion.fps))
    lowest = _SEATED if known.chest is not None else _LOWEST_HIPS
    lowest *= motion.skeleton.leg_length()
    upright = np.ones(len(motion))
    if lying is not None:
        trunk, lies = lying
        if known.chest is not None:
            lies = np.maximum(lies, chain.forced(trunk, target[:, 2] - lowest, motion.fps))
        upright = 1.0 - lies * weight[:, 0]
        chain.lie(trunk, 1.0 - upright)
    error = target - chain.head()
    moved = filters.gaussian(error[:, :2], _SLOW_S * motion.fps)
    chain.stoop(upright * _stoop(motion, chain, error, lowest, known.chest is None))
    chain.bend(upright[:, None] * (error[:, :2] - moved))
    if known.roots is not None:
        hips = motion.positions + target - chain.head()
        under = (
            _HIPS_SHARE
            * upright[:, None]
            * weight
            * filters.gaussian(known.roots - hips[:, :2], _SLOW_S * motion.fps)
        )
        moved = moved + chain.bend(-under)
    chain.steady(_shaking(error[:, :2], motion.fps), _CARRY_S * motion.fps)
    hips = motion.positions + target - chain.head()
    hips[:, 2] = np.maximum(hips[:, 2], np.minimum(lowest, motion.positions[:, 2]))
    joints = {joint: chain.rotations[:, k] for k, joint in enumerate(chain.joints)}
    return with_world_rotations(motion, joints, hips), moved


class _Chain:
    """World rotations of the joints from hips to head, while they are being changed."""

    def __init__(self, motion: Motion) -> None:
        skeleton = motion.skeleton
        self.joints = hierarchy.path(skeleton.parents, 0, skeleton.joint("head"))
        self._offsets = skeleton.offsets[self.joints]
        self._parents = np.arange(len(self.joints)) - 1
        self.pelvis = len(pelvis(skeleton))
        self.chest = self.joints.index(spine(skeleton)[-1])
        self.necks = len(neck(skeleton))
        self.hips = motion.positions
        self.held = False
        """Whether the chest keeps its turn in bends."""
        self.rotations = fk.global_rotations(motion.rotations[:, self.joints], self._parents)
        """`(T, K, 4)`."""

    def places(self) -> Array:
        """World positions `(T, K, 3)` of the joints, the hips where the motion has them."""
        return fk.joint_positions(self.hips, self.rotations, self._offsets, self._parents)

    def head(self) -> Array:
        """World position `(T, 3)` of the head joint."""
        return self.places()[:, -1]

    def turn_head(self, vector: Array) -> None:
        """Turn the head by rotation vectors `(T, 3)` in the world, and what carries it by shares of them."""
        # a half turn has no side: the share fades out towards it, lest the chest flips from left to right
        angle = norm(vector)[:, None]
        shared = vector * _fade(angle)
        last = len(self.joints) - 1
        for i in range(self.pelvis, last):
            if i <= self.chest:
                share = _CHEST_SHARE * (i - self.pelvis + 1) / (self.chest - self.pelvis + 1)
            else:
                share = _CHEST_SHARE + (1.0 - _CHEST_SHARE) * (i - self.chest) / (self.necks + 1)
            self._rotate(i, share * shared)
        self._rotate(last, vector)

    def hold_chest(self, chest: Array, weight: Array, fps: float) -> None:
        """Turn the chest to world rotations `(T, 4)` by a `weight` `(T,)`, but for the quick part of its own turning;
        pelvis, spine and neck take shares of that turn. Bends that follow leave the chest as it is."""
        self.held = True
        away = quat.to_rotation_vector(quat.multiply(chest, quat.conjugate(self.rotations[:, self.chest])))
        turn = filters.gaussian(away * (weight * _fade(norm(away)))[:, None], _CHEST_S * fps)
        for i in range(len(self.joints) - 1):
            along = max(i - self.pelvis + 1, 0) / (self.chest - self.pelvis + 1)
            share = _PELVIS_SHARE + (1.0 - _PELVIS_SHARE) * along
            if i > self.chest:
                share = 1.0 - (i - self.chest) / (self.necks + 1)
            # where the pelvis faces is known better
            self._rotate(i, share * (turn if i >= self.pelvis else turn * (1.0, 1.0, 0.0)))

    def lie(self, trunk: Array, weight: Array) -> None:
        """Turn all joints below the head towards world rotations `(T, 4)` by weights `(T,)`."""
        for i in range(len(self.joints) - 1):
            self.rotations[:, i] = towards(self.rotations[:, i], trunk, weight)

    def forced(self, trunk: Array, room: Array, fps: float) -> Array:
        """Weights `(T,)` for `lie` at which the head is no higher than `room` `(T,)` over the hips."""
        given, weight = self.rotations.copy(order="F"), np.zeros(len(room))
        tight = (self.head() - self.hips)[:, 2] > room
        if tight.any():
            for bit in range(1, 7):
                tried = weight + 0.5**bit
                self.lie(trunk, tried)
                weight = np.where(tight & ((self.head() - self.hips)[:, 2] > room), tried, weight)
                self.rotations[:] = given
            weight = np.where(tight, weight + 0.5**6, 0.0)
        return np.minimum(heel.smooth_peaks(weight, _POSTURE_S * fps), 1.0)

    def straighten(self, height: Array) -> None:
        """Draw spine and neck up to raise the head by `height` `(T,)`, as far as they are not straight
        already."""
        before, given = self.head()[:, 2], self.rotations.copy(order="F")
        inner = range(self.pelvis, len(self.joints) - 1)
        for i in inner:
            upright = quat.between(quat.rotate(given[:, i], _UP), _UP)
            self.rotations[:, i] = quat.multiply(upright, given[:, i])
        gain = np.maximum(self.head()[:, 2] - before, 0.0)
        share = np.clip(height / np.maximum(gain, 1e-3), 0.0, _UPRIGHT)
        for i in inner:
            self.rotations[:, i] = quat.slerp(given[:, i], self.rotations[:, i], share)

    def stoop(self, angle: Array) -> None:
        """Bend the trunk forward by angles `(T,)`, half in the hips, the rest along the spine; neck and
        head stay."""
        right = quat.rotate(self.rotations[:, 0], np.array([1.0, 0.0, 0.0])) * np.array([1.0, 1.0, 0.0])
        right /= np.maximum(norm(right)[:, None], 1e-9)
        for i in range(self.chest + 1):
            share = 0.5 + 0.5 * max(i - self.pelvis + 1, 0) / max(self.chest - self.pelvis + 1, 1)
            self._rotate(i, -right * (share * angle)[:, None])

    def bend(self, way: Array) -> Array:
        """Bend the spine so that the head moves by `way` `(T, 2)` over the ground, as far as a spine
        bends; returns how far `(T, 2)` the hips go to leave it where it was."""
        shares = self._bends()
        if not shares:
            return np.zeros_like(way)
        places = self.places()
        lever = sum(share * (places[:, i + 1, 2] - places[:, i, 2]) for i, share in shares.items())
        total = norm(way) / np.maximum(lever, 0.1)
        axis = np.stack([-way[:, 1], way[:, 0], np.zeros(len(way))], axis=-1)
        axis /= np.maximum(norm(axis)[:, None], 1e-9)
        vector = axis * (_BEND * np.tanh(total / _BEND))[:, None]
        for i, share in shares.items():
            self._rotate(i, share * vector)
        return (places[:, -1] - self.head())[:, :2]

    def _bends(self) -> dict[int, float]:
        """Shares of a bend by joint, growing up the spine; a chest that is held takes none."""
        last = self.chest - 1 if self.held and self.chest > self.pelvis else self.chest
        count = last - self.pelvis + 1
        return {i: (i - self.pelvis + 1) / count for i in range(self.pelvis, last + 1)}

    def steady(self, share: Array, frames: float) -> None:
        """Bend the spine so that a `share` `(T,)` of the way over the ground from hips to head is as under a
        Gaussian of `frames`."""
        given = (self.head() - self.hips)[:, :2]
        wanted = given + share[:, None] * (filters.gaussian(given, frames) - given)
        # a bend is right to first order: after a second what is left is below a millimetre
        for _ in range(2):
            self.bend(wanted - (self.head() - self.hips)[:, :2])

    def _rotate(self, index: int, vector: Array) -> None:
        turn = quat.from_rotation_vector(vector)
        self.rotations[:, index] = quat.multiply(turn, self.rotations[:, index])


def _fade(angle: Array) -> Array:
    """1 up to 110 degrees, 0 at 180."""
    t = np.clip((np.pi - angle) / np.radians(70.0), 0.0, 1.0)
    return smoothstep(t)


def _shaking(error: Array, fps: float) -> Array:
    """1 where the head moves quickly beside the motion's own, 0 where it goes along: `(T,)` of errors `(T, 2)`."""
    quick = error - filters.gaussian(error, _CARRY_S * fps)
    square = filters.gaussian(dot(quick, quick), 3.0 * _CARRY_S * fps)
    return square / (square + _OWN**2)


def _stoop(motion: Motion, chain: _Chain, error: Array, lowest: float, guessed: bool = True) -> Array:
    """How far `(T,)` the trunk bends forward for a head that is `error` `(T, 3)` away: as people do where that is to be
    `guessed`, and else only where the hips would come too low."""
    drop = np.maximum(-error[:, 2] - _STOOP_FROM, 0.0)
    upright = np.maximum(chain.head()[:, 2] - motion.positions[:, 2], 0.1)
    room = np.clip((chain.head()[:, 2] + error[:, 2] - lowest) / upright, -1.0, 1.0)
    wanted = np.minimum(np.maximum(_STOOP * drop * guessed, np.arccos(room) * (room < 1.0)), _DEEPEST_STOOP)
    return filters.gaussian(wanted, 0.1 * motion.fps)

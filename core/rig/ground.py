"""Feet on the ground of a scene: a plan for a flat floor, brought onto slopes, hills and steps.

A recording is made on the flat floor of a room. Where the avatar's feet stand they go up and down with the ground
under them and turn with its slope; between two places a foot rises early enough and comes down late enough to clear
the ground on its way. The body is lifted with the lower foot, so that legs reach.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body import heel
from ..body.legs import Leg, legs_of
from ..body.motion import Motion
from ..body.pose import world_poses
from ..maths import filters, quat
from ..maths.easing import smootherstep
from ..maths.vectors import dot, level, norm, unit
from .feet import FootPlan

Array = NDArray[np.floating[Any]]
Flags = NDArray[np.bool_]
Ground = Callable[[Array], tuple[Array, Array]]
"""Heights `(N,)` in metres, NaN where nothing is below, and unit normals `(N, 3)` that point up, of the ground at
points `(N, 2)` of the world."""

_STEEPEST = np.radians(35.0)
"""Ground that is steeper counts as level: nobody stands on it like that."""
_EDGE = 0.025
"""Metres by which ground under tip or heel may be above the sole's plane before the foot is moved off it."""
_HEEL = 0.85
"""Share of the way back to the heel's end up to which a foot in the air has to clear the ground: heels are round."""
_BEFORE = np.array([0.0, 0.03, 0.08])
"""Metres that its tip stays away from an edge, the more the better: it goes forward while it rises."""
_ASIDE = 0.045
"""Half the width of a foot, metres."""
_SHIFTS = 0.01 * np.array(
    [
        *((step, 0) for step in range(-15, 16)),
        *((0, step) for step in (-6, -5, -4, -3, -2, -1, 1, 2, 3, 4, 5, 6)),
    ]
)
"""Metres along and across the foot by which one that would stand in a step is moved; the least that helps most."""
_LONGEST_S = 1.2
"""A foot that is in the air for longer, or slides, follows the ground under it at least so often."""
_SHARES = np.linspace(1.0, 0.3, 8)
"""Shares of the time in the air in which a foot may go up, at its beginning, or down, at its end."""
_SOON = 0.06
"""Metres over a step's own arc that are as bad as going up or down in no time at all."""
_HARDEST = 30.0
"""m/s^2 by which a foot goes up or down before that counts as well; twice as much takes it over something."""
_LIMIT = 3.0
"""As many times that it is not quicker for anything."""
_ARCS = (3, 3), (3, 6), (6, 3)
"""Powers of the time since a foot left and until it lands: arcs that are highest in the middle, early and late."""
_MARGIN = 0.015
"""Metres by which a foot in the air stays clear, where it does so on a flat floor."""
_LIFT_S = 0.2
"""Standard deviation in seconds of the smoothing of the body's lift."""
_LOWER_S = 0.08
"""The same of what the body is lowered for a leg to reach."""
_LOWERED = 0.4
"""Metres by which the body is lowered at most for a leg to reach."""


@dataclass(frozen=True, slots=True, eq=False)
class Footing:
    """What the ground does to the body."""

    lift: Array
    """`(T,)` metres by which hips, head and hands are raised over the recording's floor."""
    bare: Flags
    """`(T,)` whether there is no surface under a toe: that counts as the floor at height 0."""


def surface(ground: Ground, points: Array) -> tuple[Array, Array]:
    """Heights `(...)` and normals `(..., 3)` of the ground at points `(..., 2)`; a level floor at 0 where none is."""
    heights, normals = ground(points.reshape(-1, 2))
    known = np.isfinite(heights)
    heights = np.where(known, heights, 0.0)
    normals = np.where(known[:, None], normals, np.array([0.0, 0.0, 1.0]))
    return heights.reshape(points.shape[:-1]), normals.reshape(*points.shape[:-1], 3)


def stand(body: Motion, plan: FootPlan, contacts: Flags, ground: Ground) -> tuple[FootPlan, Footing]:
    """A plan for a flat floor brought onto the ground, and how far the body is lifted with it.

    Args:
        body: the body over the flat floor, its head and hips where they should be, metres.
        plan: where its feet go on the flat floor.
        contacts: `(T, 2)` when they stand.
        ground: the scene's.
    """
    toes = plan.toes.copy()
    heights, tilts = np.empty(contacts.shape), np.empty((*contacts.shape, 4))
    for side, leg in enumerate(legs_of(body.skeleton)):
        foot = _Foot(plan.toes[:, side], plan.rotations[:, side], leg)
        knots = _stands(foot, contacts[:, side], ground, body.fps)
        moved, tilts[:, side] = knots.shift(), knots.tilt()
        toes[:, side, :2] += moved
        heights[:, side] = knots.heights(_needed(foot, moved, tilts[:, side], knots, ground), body.fps)
    plan = replace(plan, toes=toes, heights=heights, tilts=tilts)
    bare = np.isnan(ground(toes[..., :2].reshape(-1, 2))[0]).reshape(contacts.shape)
    return plan, Footing(_lift(body, plan), bare[:, 0] | bare[:, 1])


@dataclass(frozen=True, slots=True, eq=False)
class _Foot:
    """One foot on the flat floor."""

    toes: Array
    """`(T, 3)` metres."""
    rotations: Array
    """`(T, 4)` of the foot joint in the world."""
    leg: Leg

    def sole(self) -> Array:
        """From the floor under the toe to toe, tip and heel, without the sole under each: `(T, 3, 3)` metres."""
        leg, up = self.leg, self.toes[:, 2] - self.leg.height
        out = np.zeros((len(self.toes), 3, 3))
        out[:, 0, 2] = up
        tip = quat.rotate(self.rotations, leg.to_tip)
        out[:, 1, :2] = tip[:, :2]
        out[:, 1, 2] = up + tip[:, 2] - max(float(leg.to_tip[2]), -leg.height)
        out[:, 2] = quat.rotate(self.rotations, leg.heel * [1.0, _HEEL, 1.0])
        out[:, 2, 2] += self.toes[:, 2]
        out[..., 2] = np.maximum(out[..., 2], 0.0)
        return out


@dataclass(frozen=True, slots=True, eq=False)
class _Knots:
    """Where one foot stands: values that hold from a first to a last frame, `(K,)` each."""

    first: NDArray[np.intp]
    last: NDArray[np.intp]
    level: Array
    """Metres by which the flat floor is raised under the toe."""
    slope: Array
    """`(K, 3)` rotation vectors from upright to the ground's normal."""
    moved: Array
    """`(K, 2)` metres over the ground."""
    before: NDArray[np.intp]
    """`(T,)` the knot that each frame is in, or comes from."""
    passed: Array
    """`(T,)` share of the time to the next knot, 0 while one holds."""

    def shift(self) -> Array:
        """`(T, 2)` metres."""
        return self._between(self.moved)

    def tilt(self) -> Array:
        """`(T, 4)` rotations."""
        return quat.from_rotation_vector(self._between(self.slope))

    def _between(self, values: Array) -> Array:
        before, after = values[self.before], values[self._after]
        return before + smootherstep(self.passed)[:, None] * (after - before)

    @property
    def _after(self) -> NDArray[np.intp]:
        return np.minimum(self.before + 1, len(self.first) - 1)

    def heights(self, needed: Array, fps: float) -> Array:
        """Metres `(T,)` by which the flat floor is raised under the toe, above what is `needed` `(T,)` in the air.

        From knot to knot it goes one way, up at the beginning of the time in the air or down at its end, within
        the share of that time that needs the least arc on top.
        """
        count, change = len(self.first), np.append(np.diff(self.level), 0.0)
        frames = np.append(np.maximum(self.first[1:] - self.last[:-1], 1), 1) / fps
        u = self.passed
        free = u * (1.0 - u) > 0.06
        least, out = np.full(count, np.inf), np.empty_like(u)
        for share in _SHARES:
            way = self._way(share)
            hardness = 5.8 * np.abs(change) / (share * frames) ** 2 / _HARDEST
            cost = _SOON * (1.0 - share + np.maximum(hardness - 1.0, 0.0))
            if share < 1.0:
                # rather a heel in an edge for a moment than a foot that falls like a stone
                cost[hardness > _LIMIT] = np.inf
            for rise, fall in _ARCS:
                peak = rise / (rise + fall)
                arc = u**rise * (1.0 - u) ** fall / (peak**rise * (1.0 - peak) ** fall)
                over = np.zeros(count)
                np.maximum.at(over, self.before[free], ((needed - way) / np.maximum(arc, 0.1))[free])
                better = cost + over < least
                least = np.minimum(cost + over, least)
                over = np.minimum(over, 2.0 * _HARDEST / 24.0 * frames**2)
                chosen = better[self.before]
                out[chosen] = (way + over[self.before] * arc)[chosen]
        return out

    def _way(self, share: float) -> Array:
        """Heights `(T,)` without arcs, changing within a share of the time in the air."""
        start, change = self.level[self.before], (self.level[self._after] - self.level[self.before])
        early, late = self.passed / share, (self.passed - 1.0 + share) / share
        return start + change * smootherstep(np.clip(np.where(change > 0.0, early, late), 0.0, 1.0))


def _stands(foot: _Foot, contacts: Flags, ground: Ground, fps: float) -> _Knots:
    """Where a foot stands, and what the ground is like there."""
    first, last = _knot_frames(contacts, fps)
    middle = (first + last) // 2
    places = foot.toes[middle, :2]
    forward = unit(level(quat.rotate(foot.rotations[middle], np.array([0.0, 1.0, 0.0]))))[:, :2]
    axes = np.stack([forward, np.stack([forward[:, 1], -forward[:, 0]], axis=-1)], axis=1)
    along = [0.0, foot.leg.heel[1], *(foot.leg.to_tip[1] + _BEFORE), 0.0, 0.0]
    sole = np.stack([along, [0.0] * (len(along) - 2) + [-_ASIDE, _ASIDE]], axis=-1)
    moved = np.zeros_like(places)
    heights, normals, blocked = _under_sole(places, axes, sole, ground)
    tight = np.flatnonzero(blocked)
    if len(tight):
        ways = _SHIFTS @ axes[tight]
        h, n, blocked = _under_sole(places[tight, None] + ways, axes[tight, None], sole, ground)
        rows, choice = np.arange(len(tight)), (blocked + np.abs(_SHIFTS).sum(axis=-1)).argmin(axis=1)
        heights[tight], normals[tight] = h[rows, choice], n[rows, choice]
        moved[tight] = ways[rows, choice]
    upright = np.array([0.0, 0.0, 1.0])
    slope = quat.to_rotation_vector(quat.between(np.broadcast_to(upright, normals.shape), normals))
    # the sole's distance from the ground is across the slope
    raised = heights + foot.leg.height * (1.0 / normals[:, 2] - 1.0)
    frames = np.arange(len(contacts))
    before = np.maximum(np.searchsorted(first, frames, side="right") - 1, 0)
    after = np.minimum(before + 1, len(first) - 1)
    passed = (frames - last[before]) / np.maximum(first[after] - last[before], 1)
    return _Knots(first, last, raised, slope, moved, before, np.clip(passed, 0.0, 1.0))


def _knot_frames(contacts: Flags, fps: float) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """First and last frames of the contacts, and of single frames at the ends and in long gaps."""
    edges = np.flatnonzero(np.diff(contacts, prepend=False, append=False)).reshape(-1, 2)
    spans = edges - [0, 1]
    ends = [[frame, frame] for frame in (0, len(contacts) - 1) if not contacts[frame]]
    spans = np.unique(np.concatenate([spans, np.reshape(ends, (-1, 2)).astype(np.intp)]), axis=0)
    gaps = spans[1:, 0] - spans[:-1, 1]
    more: list[list[int]] = []
    for gap, start in zip(gaps.tolist(), spans[:-1, 1].tolist(), strict=True):
        parts = int(np.ceil(gap / (_LONGEST_S * fps)))
        more += [[start + gap * i // parts] * 2 for i in range(1, parts)]
    spans = np.concatenate([spans, np.reshape(more, (-1, 2)).astype(np.intp)])
    spans = spans[np.argsort(spans[:, 0])]
    return spans[:, 0], spans[:, 1]


def _under_sole(places: Array, axes: Array, sole: Array, ground: Ground) -> tuple[Array, Array, Array]:
    """Height `(...)` under a toe, normal `(..., 3)` of the plane that the sole lies in, and how many points of the
    sole `(...)` are in the ground.

    Across the foot the plane has the slope of the ground; along it that from heel to toe, unless there is an edge.

    Args:
        places: `(..., 2)` of the toe.
        axes: `(..., 2, 2)` level directions to the front and to the right.
        sole: `(S, 2)` metres along these to toe, heel, tip and what else there is.
        ground: the scene's.
    """
    points, forward = sole @ axes, axes[..., 0, :]
    heights, normals = surface(ground, places[..., None, :] + points)
    under = normals[..., :3, :]
    easy = under[..., 2:] >= np.cos(_STEEPEST)
    normal: Array = np.mean(np.where(easy, under, np.array([0.0, 0.0, 1.0])), axis=-2)
    fall: Array = -normal[..., :2] / normal[..., 2:]
    own = dot(fall, forward)
    rest = (heights[..., 0] - heights[..., 1]) / -sole[1, 0]
    smooth = np.abs(np.arctan(rest) - np.arctan(own)) < 0.5 * _STEEPEST
    fall = fall + (np.where(smooth, rest, own) - own)[..., None] * forward
    fall *= np.minimum(1.0, np.tan(_STEEPEST) / np.maximum(norm(fall), 1e-12))[..., None]
    above = heights - heights[..., :1] - dot(fall[..., None, :], points)
    normal = unit(np.concatenate([-fall, np.ones_like(fall[..., :1])], axis=-1))
    return heights[..., 0], normal, np.sum(above > _EDGE, axis=-1)


def _needed(foot: _Foot, moved: Array, tilts: Array, knots: _Knots, ground: Ground) -> Array:
    """Metres `(T,)` by which the flat floor must be raised for toe, tip and heel to clear the ground."""
    sole = foot.sole()
    free = 4.0 * knots.passed * (1.0 - knots.passed)
    margin = np.minimum(_MARGIN * free[:, None], sole[..., 2])
    sole = quat.rotate(tilts[:, None], sole)
    heights, _ = surface(ground, (foot.toes[:, :2] + moved)[:, None] + sole[..., :2])
    return np.max(heights + margin - sole[..., 2], axis=-1)


def _lift(body: Motion, plan: FootPlan) -> Array:
    """The smoothed lower one of both feet's heights `(T,)`, less where a leg would not reach."""
    assert plan.heights is not None and plan.tilts is not None
    lift = filters.gaussian(plan.heights.min(axis=-1), _LIFT_S * body.fps)
    legs = legs_of(body.skeleton)
    hips, _ = world_poses(body, [leg.thigh for leg in legs])
    excess = np.zeros(len(body))
    for side, leg in enumerate(legs):
        toes = plan.toes[:, side]
        ankle = quat.rotate(plan.rotations[:, side], leg.to_toe)
        flat = hips[leg.thigh] - toes + ankle
        way = hips[leg.thigh] - toes + quat.rotate(plan.tilts[:, side], ankle)
        way[:, 2] -= plan.heights[:, side]
        longest = np.maximum(norm(flat), heel.relaxed(leg.length))
        over = dot(way[:, :2], way[:, :2])
        most = np.sqrt(np.maximum(longest**2 - over, 0.0)) - way[:, 2]
        excess = np.maximum(excess, lift - most)
    # what rounding leaves on a flat floor is no excess
    excess = np.where(excess > 1e-9, np.minimum(excess, _LOWERED), 0.0)
    return lift - heel.smooth_peaks(excess, _LOWER_S * body.fps)

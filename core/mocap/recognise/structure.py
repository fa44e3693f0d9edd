"""Roles by shape and names: two pairs of limbs, the trunk between them, a head; how long bones are, how they bend."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...body.skeleton import SIDES
from .shape import Shape, mirrored_pairs
from .words import NameSays

Array = NDArray[np.floating[Any]]

_CHAIN = 24
"""Joints of a limb that are looked at."""
_LIMITS = {"arm": ((0.05, 0.25), (0.28, 0.2), (0.3, 0.3)), "leg": ((0.05, 0.25), (0.12, 0.15), (0.25, 0.2))}
"""Mean and deviation in people: log of upper to lower bone; way from the trunk, and what follows, over both bones."""
_WORST = 14.0
"""A limb less likely than this (sum of squared deviations) is none of a person."""
_WORD = 10.0
"""What a name that says a part for sure is worth, in squared deviations."""
_NAMED_SIDES = 6
"""So many more limb joints named for one side than for the other tell the sides."""
_LIMBS = 4
"""More long branches from one joint are of no person."""
_LEAST_HEAD = 0.05
"""A head's and neck's length over a leg's, at least."""


def find_roles(shape: Shape, says: Sequence[NameSays]) -> tuple[dict[str, int], float]:
    """Role -> joint, and how unlikely the body is; empty where the shape is no person's.

    Sides follow from names where these tell them, else from the feet, knees and elbows.

    Args:
        shape: of the tree.
        says: `(J,)` what the names say; they decide where the shape leaves it open.
    """
    best: tuple[float, dict[str, int]] = (2.0 * _WORST, {})
    pairs = mirrored_pairs(shape)
    for at, first in enumerate(pairs):
        for second in pairs[at + 1 :]:
            if _nested(shape, first, second):
                continue
            for legs, arms in ((first, second), (second, first)):
                cost, roles = _body(shape, legs, arms, says)
                if roles and cost < best[0]:
                    best = cost, roles
    return best[1], best[0]


def _nested(shape: Shape, first: tuple[int, int], second: tuple[int, int]) -> bool:
    return bool(set(first) & set(second)) or any(
        shape.is_above(a, b) or shape.is_above(b, a) for a in first for b in second
    )


def _body(
    shape: Shape, legs: tuple[int, int], arms: tuple[int, int], says: Sequence[NameSays]
) -> tuple[float, dict[str, int]]:
    """How unlikely a body with these limbs is, and its roles; none where it is impossible."""
    pelvis, breast = shape.parents[legs[0]], shape.parents[arms[0]]
    trunk = _way(shape, pelvis, breast)
    crowded = pelvis == breast and len(_long(shape, pelvis)) > _LIMBS
    if not trunk or crowded:
        return np.inf, {}
    top = _head_chain(shape, breast, trunk, (*legs, *arms))
    if not top:
        return np.inf, {}
    named = {joint: says[joint].parts.get("head", 0.0) for joint in top}
    head = max(named, key=named.__getitem__) if max(named.values()) > 0.5 else _head(shape, top)
    arms = _aligned(shape, legs, arms, says)
    cost, roles = 0.0, {"hips": pelvis, "head": head}
    if head != top[0]:
        roles["neck"] = top[0]
    limbs = [
        (_limb(shape, a, "leg", says), _limb(shape, b, "arm", says)) for a, b in zip(legs, arms, strict=True)
    ]
    for letter, ((leg_cost, leg), (arm_cost, arm)) in zip("ab", limbs, strict=True):
        cost += 0.5 * (leg_cost + arm_cost)
        roles |= {f"{part}.{letter}": joint for part, joint in (leg | arm).items()}
    if cost > 2.0 * _WORST:
        return cost, {}
    cost += _odd(shape, roles)
    if len(trunk) > 1 and shape.distance(pelvis, roles["thigh.a"]) > 0.7 * shape.distance(
        roles["thigh.a"], roles["foot.a"]
    ):
        roles["hips"] = trunk[1]  # the legs hang on a root on the floor
    return cost, _sided(shape, roles, says)


def _long(shape: Shape, joint: int) -> list[int]:
    """The branches from a joint that are as long as limbs."""
    kids = shape.children[joint]
    longest = max((shape.branch(kid) for kid in kids), default=0.0)
    return [kid for kid in kids if shape.branch(kid) > 0.6 * longest]


def _aligned(
    shape: Shape, legs: tuple[int, int], arms: tuple[int, int], says: Sequence[NameSays]
) -> tuple[int, int]:
    """The arms in the order of the legs of their sides, as names or else places tell."""
    sides = [_side(shape, limb, says) for limb in (*legs, *arms)]
    if all(sides) and sides[0] != sides[1] and sides[2] != sides[3]:
        return arms if sides[0] == sides[2] else (arms[1], arms[0])
    across = [shape.poses[:, pair[0]] - shape.poses[:, pair[1]] for pair in (legs, arms)]
    same = float(np.median(np.sum(across[0] * across[1], axis=-1)))
    return arms if same >= 0.0 else (arms[1], arms[0])


def _side(shape: Shape, limb: int, says: Sequence[NameSays]) -> str:
    """The side that the names along a limb tell, "" where they do not."""
    sides = [says[joint].side for joint in shape.chain(limb)[:4]]
    return max(sides, key=sides.count) if any(sides) else ""


def _way(shape: Shape, a: int, b: int) -> list[int]:
    """The joints from one to another through the tree, both included; empty where there is no way."""
    up, down = [a, *shape.above(a)], [b, *shape.above(b)]
    meet = next((joint for joint in up if joint in down), -1)
    return [] if meet < 0 else up[: up.index(meet) + 1] + down[: down.index(meet)][::-1]


def _head_chain(shape: Shape, breast: int, trunk: list[int], limbs: tuple[int, ...]) -> list[int]:
    """From the joint after the arms' to the top of the head: the longest branch that is none else's."""
    taken = {*limbs, *trunk}
    free = [kid for kid in shape.children[breast] if kid not in taken]
    chain = shape.chain(max(free, key=shape.branch)) if free else []
    parent = shape.parents[breast]
    if parent >= 0 and parent not in taken:
        upward = [joint for joint in shape.above(breast) if joint not in taken]
        length = shape.distance(breast, upward[-1])
        if not chain or length > shape.branch(chain[0]):
            return upward
    return chain


def _head(shape: Shape, chain: list[int]) -> int:
    """The head's joint of a chain: where eyes and jaw branch off, else the last that a bone starts at."""
    for joint in chain[1:-1]:
        if len(shape.children[joint]) > 1:
            return joint
    if len(shape.children[chain[0]]) > 1 or len(chain) == 1:
        return chain[0]
    return chain[1] if len(chain) < 4 else chain[-2]


def _limb(shape: Shape, start: int, kind: str, says: Sequence[NameSays]) -> tuple[float, dict[str, int]]:
    """How unlikely a branch is a person's limb, and the roles along it."""
    names = ("upper_arm", "forearm", "hand") if kind == "arm" else ("thigh", "shin", "foot")
    chain = shape.chain(start)[:_CHAIN]
    ways = np.cumsum(shape.lengths[chain])
    end = float(ways[-1])
    (ratio, slack), (before, loose), (after, wide) = _LIMITS[kind]
    bends = _bends(shape, chain)
    best: tuple[float, tuple[int, int, int]] = (np.inf, (0, 0, 0))
    for i in range(len(chain) - 2):
        for j in range(i + 1, len(chain) - 1):
            for k in range(j + 1, len(chain)):
                upper, lower = ways[j] - ways[i], ways[k] - ways[j]
                if min(upper, lower) < 0.1 * end:
                    continue
                both = upper + lower
                cost = ((np.log(upper / lower) - ratio) / slack) ** 2 + (
                    (ways[i] / both - before) / loose
                ) ** 2
                cost += ((end - ways[k]) / both - after) ** 2 / wide**2 if k + 1 < len(chain) else 1.0
                cost += 2.0 * (1.0 - bends[j]) - (1.0 if len(shape.children[chain[k]]) > 2 else 0.0)
                for name, at in zip(names, (i, j, k), strict=True):
                    cost -= _WORD * _agrees(says[chain[at]], name)
                if cost < best[0] - 1e-9:
                    best = float(cost), (i, j, k)
    cost, (i, j, k) = best
    if not np.isfinite(cost):
        return _WORST * 4.0, {}
    roles = {name: chain[at] for name, at in zip(names, (i, j, k), strict=True)}
    if kind == "arm" and i > 0:
        roles["clavicle"] = max(chain[:i], key=lambda joint: says[joint].parts.get("clavicle", 0.0))
    if kind == "leg" and k + 1 < len(chain) and not says[chain[k + 1]].dim:
        roles["toe"] = chain[k + 1]
    return cost, roles


def _agrees(says: NameSays, part: str) -> float:
    """1 for a name that says the part, less than 0 for one that says something else."""
    if says.dim:
        return -0.7
    if not says.parts:
        return 0.0
    score = says.parts.get(part, 0.0)
    # a word for two parts tells less of the one that it rather means
    return score - 0.5 * (max(says.parts.values()) - score) if score else -0.5


def _bends(shape: Shape, chain: list[int]) -> Array:
    """`(N,)` how much a chain bends at each joint over the poses, 0 to 1; all 1 where it is seen in one pose only."""
    if len(shape.poses) < 2 or len(chain) < 3:
        return np.ones(len(chain))
    bones = np.diff(shape.poses[:, chain], axis=1)
    bones /= np.maximum(np.linalg.norm(bones, axis=-1, keepdims=True), 1e-12)
    angles = np.arccos(np.clip(np.sum(bones[:, 1:] * bones[:, :-1], axis=-1), -1.0, 1.0))
    spread = np.zeros(len(chain))
    spread[1:-1] = np.ptp(angles, axis=0)
    most = float(spread.max())
    return np.ones(len(chain)) if most < 0.1 else np.minimum(2.0 * spread / most, 1.0)


def _odd(shape: Shape, roles: dict[str, int]) -> float:
    """What the whole says against a body: arms longer than legs by much, legs on the head's side."""
    leg = shape.distance(roles["thigh.a"], roles["shin.a"]) + shape.distance(roles["shin.a"], roles["foot.a"])
    arm = shape.distance(roles["upper_arm.a"], roles["forearm.a"])
    arm += shape.distance(roles["forearm.a"], roles["hand.a"])
    cost = (np.log(arm / leg / 0.65) / 0.35) ** 2
    head = shape.poses[:, roles["head"]] - shape.poses[:, roles["hips"]]
    feet = shape.poses[:, [roles["foot.a"], roles["foot.b"]]].mean(axis=1) - shape.poses[:, roles["hips"]]
    away = np.sum(head * feet, axis=-1) / np.maximum(
        np.linalg.norm(head, axis=-1) * np.linalg.norm(feet, axis=-1), 1e-12
    )
    if float(np.linalg.norm(head, axis=-1).mean()) < _LEAST_HEAD * leg:
        return np.inf
    return float(cost + 6.0 * max(float(np.median(away)) + 0.3, 0.0))


def front_by_shape(shape: Shape, roles: dict[str, int], letters: tuple[str, str]) -> float:
    """How surely the limbs named first are the left ones: positive for left, negative for right, about -1 to 1.

    Toes point ahead, knees bend ahead, elbows back.
    """

    def at(role: str) -> Array:
        return shape.poses[:, roles[role]]

    hips, head = at("hips"), at("head")
    up = _unit(head - hips)
    ahead: Array = np.zeros_like(hips)
    for letter in letters:
        foot, thigh = at(f"foot.{letter}"), at(f"thigh.{letter}")
        end = roles.get(f"toe.{letter}", shape.chain(roles[f"foot.{letter}"])[-1])
        leg: Array = np.linalg.norm(at(f"shin.{letter}") - thigh, axis=-1, keepdims=True) + 1e-12
        ahead += (shape.poses[:, end] - foot) / leg
        ahead += (at(f"shin.{letter}") - 0.5 * (thigh + foot)) / leg
        if f"hand.{letter}" in roles:
            shoulder, elbow, hand = (at(f"{part}.{letter}") for part in ("upper_arm", "forearm", "hand"))
            ahead -= (elbow - 0.5 * (shoulder + hand)) / leg
    level: Array = ahead - up * np.sum(ahead * up, axis=-1, keepdims=True)
    clear: Array = np.linalg.norm(level, axis=-1, keepdims=True)
    aside: Array = np.cross(up, level)
    left: Array = _unit(aside) * np.minimum(clear, 1.0)
    across: Array = at(f"thigh.{letters[0]}") - at(f"thigh.{letters[1]}")
    across = across + at(f"upper_arm.{letters[0]}") - at(f"upper_arm.{letters[1]}")
    both: Array = np.sum(left * _unit(across), axis=-1)
    return float(np.mean(both))


def _sided(shape: Shape, roles: dict[str, int], says: Sequence[NameSays]) -> dict[str, int]:
    """The roles with L and R for the two sides."""
    votes = 0
    for role, joint in roles.items():
        side = says[joint].side
        if side and role[-2:] in (".a", ".b"):
            votes += 1 if (side == "L") == role.endswith(".a") else -1
    told = abs(votes) >= _NAMED_SIDES
    left = "a" if (votes > 0 if told else front_by_shape(shape, roles, ("a", "b")) >= 0.0) else "b"
    letter = {left: SIDES[0], "b" if left == "a" else "a": SIDES[1]}
    return {
        f"{part}.{letter[side]}" if side else part: joint
        for (part, _, side), joint in ((role.partition("."), joint) for role, joint in roles.items())
    }


def _unit(vectors: Array) -> Array:
    lengths: Array = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.maximum(lengths, 1e-12)

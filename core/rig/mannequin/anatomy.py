"""The parts of a body of average adult build as lofts round a skeleton in T-pose."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...body.skeleton import SIDES, SPINE, Skeleton
from .lofts import Loft

Array = NDArray[np.floating[Any]]

_HEAD_JOINT = 1.555
"""Height in metres of the head joint for which the lengths below hold."""
_X, _Y, _Z = np.eye(3)


@dataclass(frozen=True, slots=True, eq=False)
class Landmarks:
    """Where the joints of a body stand in T-pose, those that the skeleton lacks put where they usually are."""

    size: float
    """How many times as large as the usual body."""
    at: dict[str, Array]
    """`(3,)` of every role, and of "toe_end.L" and "hand_end.L" and their like; metres."""

    def __getitem__(self, name: str) -> Array:
        return self.at[name]


def landmarks(skeleton: Skeleton) -> Landmarks:
    """Joints and ends of a skeleton's limbs in T-pose."""
    positions = skeleton.tpose_positions()
    at = {role: positions[j] for j, role in enumerate(skeleton.roles) if role}
    size = float(at["head"][2]) / _HEAD_JOINT
    shoulders = 0.5 * (at["upper_arm.L"] + at["upper_arm.R"])
    at.setdefault("neck", shoulders + 0.35 * (at["head"] - shoulders))
    for side, sign in zip(SIDES, (-1.0, 1.0), strict=True):
        shoulder, wrist = at[f"upper_arm.{side}"], at[f"hand.{side}"]
        inner = np.array([shoulders[0] + 0.2 * (shoulder - shoulders)[0], shoulder[1], shoulder[2]])
        at.setdefault(f"clavicle.{side}", inner)
        along = wrist - at[f"forearm.{side}"]
        at[f"hand_end.{side}"] = wrist + 0.17 * size * along / np.linalg.norm(along)
        ankle = at[f"foot.{side}"]
        ball = np.array([ankle[0], ankle[1] + 0.135 * size, 0.02 * size])
        at.setdefault(f"toe.{side}", ball)
        at[f"toe_end.{side}"] = at[f"toe.{side}"] + np.array([0.0, 0.065 * size, 0.0])
        at[f"side.{side}"] = sign * _X
    return Landmarks(size, at)


def _sized(knots: tuple[tuple[float, ...], ...], size: float) -> tuple[tuple[float, ...], ...]:
    return tuple((knot[0], *(size * value for value in knot[1:])) for knot in knots)


def trunk(body: Landmarks) -> tuple[Loft, ...]:
    """Torso, neck, skull and jaw."""
    s = body.size
    low = 0.5 * (body["thigh.L"] + body["thigh.R"])
    high = 0.5 * (body["upper_arm.L"] + body["upper_arm.R"])
    high = np.array([low[0], 0.5 * (low[1] + high[1]), high[2]])
    low = np.array([low[0], high[1], low[2]])
    hips = 0.5 * float(body["thigh.R"][0] - body["thigh.L"][0]) - 0.088 * s
    arms = 0.5 * float(body["upper_arm.R"][0] - body["upper_arm.L"][0]) - 0.17 * s
    torso = Loft(
        low,
        high,
        _X,
        (
            (-0.14, hips + 0.050 * s, 0.050 * s, -0.010 * s),
            (0.05, hips + 0.138 * s, 0.104 * s, -0.012 * s),
            (0.20, hips + 0.137 * s, 0.099 * s, -0.004 * s),
            (0.40, 0.128 * s, 0.090 * s, 0.004 * s),
            (0.62, 0.5 * arms + 0.145 * s, 0.101 * s, 0.006 * s),
            (0.80, arms + 0.155 * s, 0.109 * s, 0.004 * s),
            (0.97, arms + 0.120 * s, 0.084 * s, -0.006 * s),
            (1.10, 0.055 * s, 0.052 * s, -0.012 * s),
        ),
    )
    head, base = body["head"], body["neck"]
    root = np.array([base[0], base[1] - 0.010 * s, base[2] - 0.04 * s])
    neck = Loft(
        root,
        head + 0.02 * s * _Z + 0.006 * s * _Y,
        _X,
        _sized(((0.0, 0.066, 0.060, 0.0), (0.5, 0.053, 0.055, 0.0), (1.0, 0.052, 0.055, 0.0)), s),
    )
    return torso, neck, *skull(body)


def skull(body: Landmarks) -> tuple[Loft, Loft]:
    """Cranium, and face with jaw."""
    s, head = body.size, body["head"]
    cranium = Loft(
        head + s * np.array([0.0, 0.010, 0.045]),
        head + s * np.array([0.0, 0.004, 0.100]),
        _X,
        _sized(((0.0, 0.070, 0.088, 0.0), (0.6, 0.076, 0.096, 0.0), (1.0, 0.072, 0.090, 0.0)), s),
    )
    face = Loft(
        head + s * np.array([0.0, 0.052, -0.018]),
        head + s * np.array([0.0, 0.042, 0.075]),
        _X,
        _sized(((0.0, 0.042, 0.036, 0.0), (0.4, 0.057, 0.048, 0.0), (1.0, 0.064, 0.058, 0.0)), s),
    )
    return cranium, face


def arm(body: Landmarks, side: str) -> dict[str, Loft]:
    """Lofts of an arm by role, without the fingers."""
    s = body.size
    inner, shoulder, elbow, wrist = (
        body[f"{part}.{side}"] for part in ("clavicle", "upper_arm", "forearm", "hand")
    )
    end = body[f"hand_end.{side}"]
    return {
        f"clavicle.{side}": _limb(
            inner + 0.02 * s * _Z,
            shoulder + 0.002 * s * _Z,
            _Y,
            ((0.0, 0.054, 0.040, 0.0), (1.0, 0.050, 0.046, 0.0)),
            s,
        ),
        f"upper_arm.{side}": _limb(
            shoulder,
            elbow,
            _Y,
            (
                (0.0, 0.050, 0.047, 0.0),
                (0.2, 0.050, 0.051, 0.0),
                (0.55, 0.046, 0.048, 0.0),
                (1.0, 0.038, 0.039, 0.0),
            ),
            s,
        ),
        f"forearm.{side}": _limb(
            elbow,
            wrist,
            _Y,
            (
                (0.0, 0.038, 0.039, 0.0),
                (0.25, 0.043, 0.041, 0.0),
                (0.75, 0.032, 0.028, 0.0),
                (1.0, 0.028, 0.022, 0.0),
            ),
            s,
        ),
        f"hand.{side}": _limb(wrist, end, _Y, ((0.0, 0.028, 0.022, 0.0), (0.5, 0.042, 0.017, 0.0)), s),
    }


def leg(body: Landmarks, side: str) -> dict[str, Loft]:
    """Lofts of a leg by role; foot and toe share one."""
    s = body.size
    hip, knee, ankle, end = (body[f"{part}.{side}"] for part in ("thigh", "shin", "foot", "toe_end"))
    heel = np.array([ankle[0], ankle[1] - 0.040 * s, 0.036 * s])
    tip = np.array([end[0], end[1] - 0.028 * s, 0.024 * s])
    return {
        f"thigh.{side}": _limb(
            hip,
            knee,
            _X,
            (
                (0.0, 0.086, 0.096, 0.0),
                (0.25, 0.086, 0.090, 0.0),
                (0.75, 0.060, 0.064, 0.0),
                (1.0, 0.053, 0.056, 0.0),
            ),
            s,
        ),
        f"shin.{side}": _limb(
            knee,
            ankle,
            _X,
            (
                (0.0, 0.052, 0.055, 0.0),
                (0.3, 0.054, 0.058, 0.013),
                (0.75, 0.038, 0.041, 0.006),
                (1.0, 0.035, 0.038, 0.0),
            ),
            s,
        ),
        f"foot.{side}": _limb(
            heel,
            tip,
            _X,
            (
                (0.0, 0.036, 0.036, 0.0),
                (0.25, 0.037, 0.046, -0.008),
                (0.7, 0.047, 0.032, 0.0),
                (1.0, 0.037, 0.024, 0.0),
            ),
            s,
        ),
    }


def fingers(body: Landmarks, side: str) -> tuple[Loft, ...]:
    """Palm and fingers of a hand that is open and at ease, palm down."""
    s, wrist = body.size, body[f"hand.{side}"]
    ahead = body[f"hand_end.{side}"] - wrist
    ahead = ahead / np.linalg.norm(ahead)
    palm = Loft(
        wrist - 0.02 * s * ahead,
        wrist + 0.085 * s * ahead,
        _Y,
        _sized(
            (
                (0.0, 0.027, 0.021, 0.0),
                (0.35, 0.031, 0.019, 0.0),
                (0.8, 0.039, 0.0155, 0.0),
                (1.0, 0.037, 0.0125, 0.0),
            ),
            s,
        ),
    )
    made = [palm]
    for sideways, length, radius in (
        (0.029, 0.070, 1.0),
        (0.0097, 0.080, 1.03),
        (-0.0097, 0.074, 1.0),
        (-0.0285, 0.058, 0.9),
    ):
        start = wrist + s * (0.080 * ahead + sideways * _Y)
        made += _bent(start, ahead + 4.0 * sideways * _Y * 0.6, length * s, (12.0, 34.0), 0.0092 * radius * s)
    start = wrist + s * (0.020 * ahead + 0.024 * _Y)
    made += _bent(start, 0.62 * ahead + 0.7 * _Y, 0.085 * s, (20.0, 32.0), 0.0115 * s)
    return tuple(made)


def _bent(start: Array, ahead: Array, length: float, bends: tuple[float, float], radius: float) -> list[Loft]:
    """A finger of two parts, each bent down from level by degrees."""
    ahead = ahead / np.linalg.norm(ahead)
    made: list[Loft] = []
    for share, degrees, thin in zip((0.5, 0.5), bends, (1.0, 0.9), strict=True):
        angle = np.radians(degrees)
        direction = np.cos(angle) * ahead - np.sin(angle) * _Z
        across = np.cross(ahead, _Z)
        end = start + share * length * direction
        made.append(
            Loft(
                start,
                end,
                across / np.linalg.norm(across),
                (
                    (0.0, thin * radius, thin * radius, 0.0),
                    (1.0, 0.9 * thin * radius, 0.9 * thin * radius, 0.0),
                ),
            )
        )
        start = end
    return made


def _limb(start: Array, end: Array, across: Array, knots: tuple[tuple[float, ...], ...], size: float) -> Loft:
    """A loft whose first half axis is as near as can be to `across`."""
    axis = (end - start) / np.linalg.norm(end - start)
    level = across - (across @ axis) * axis
    return Loft(start, end, level / np.linalg.norm(level), _sized(knots, size))


def spine_roles(skeleton: Skeleton) -> tuple[str, ...]:
    """Roles of the trunk that the skeleton has, hips first."""
    return tuple(role for role in ("hips", *SPINE, "neck", "head") if skeleton.find(role) >= 0)

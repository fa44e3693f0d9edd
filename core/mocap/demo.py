"""Procedural demo takes: a person who walks, turns, side-steps and crouches, made from foot steps.

They stand in for mocap where none is at hand: the demo, the tests and the first try in Blender need nothing else. Feet
are planted exactly, so their contacts and skating are known by construction.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body.motion import Motion
from ..body.skeleton import LEG, SIDES, Skeleton
from ..maths import angles, quat

Array = NDArray[np.floating[Any]]

_STANCE = 0.62
"""Share of the gait cycle that a foot stays on the ground."""
_STEPS_PER_S = 1.8
_HALF_STANCE_M = 0.09
_HALF_HIPS_M = 0.09

# name, parent, offset in metres (T-pose, facing +Y, Z up), role; left joints, mirrored below
_CENTRE = [
    ("Hips", "", (0.0, 0.0, 0.95), "hips"),
    ("Chest", "Hips", (0.0, 0.0, 0.10), "spine1"),
    ("Chest2", "Chest", (0.0, 0.0, 0.11), "spine2"),
    ("Chest3", "Chest2", (0.0, 0.0, 0.10), "spine3"),
    ("Chest4", "Chest3", (0.0, 0.0, 0.10), "chest"),
    ("Neck", "Chest4", (0.0, 0.0, 0.14), "neck"),
    ("Head", "Neck", (0.0, 0.02, 0.10), "head"),
]
_LEFT = [
    ("LeftCollar", "Chest4", (-0.02, 0.0, 0.09), "clavicle.L"),
    ("LeftShoulder", "LeftCollar", (-0.15, 0.0, 0.0), "upper_arm.L"),
    ("LeftElbow", "LeftShoulder", (-0.29, 0.0, 0.0), "forearm.L"),
    ("LeftWrist", "LeftElbow", (-0.25, 0.0, 0.0), "hand.L"),
    ("LeftHip", "Hips", (-_HALF_HIPS_M, 0.0, -0.02), "thigh.L"),
    ("LeftKnee", "LeftHip", (0.0, 0.0, -0.43), "shin.L"),
    ("LeftAnkle", "LeftKnee", (0.0, 0.0, -0.41), "foot.L"),
    ("LeftToe", "LeftAnkle", (0.0, 0.14, -0.07), "toe.L"),
]
_TIPS = {"Head": (0.0, 0.0, 0.18), "Wrist": (-0.17, 0.0, 0.0), "Toe": (0.0, 0.07, 0.0)}


def demo_skeleton(height: float = 1.75) -> Skeleton:
    """A 23-joint skeleton with Xsens names, `height` metres tall."""
    mirror = np.array([-1.0, 1.0, 1.0])
    rows = [*_CENTRE, *_LEFT]
    rows += [
        (n.replace("Left", "Right"), p.replace("Left", "Right"), tuple(mirror * np.array(o)), r[:-1] + "R")
        for n, p, o, r in _LEFT
    ]
    names = [row[0] for row in rows]
    tips = np.zeros((len(rows), 3))
    for i, name in enumerate(names):
        for part, tip in _TIPS.items():
            if name.endswith(part):
                tips[i] = np.array(tip) * (mirror if name.startswith("Right") else 1.0)
    size = height / 1.75
    return Skeleton(
        names=tuple(names),
        parents=np.array([names.index(row[1]) if row[1] else -1 for row in rows], dtype=np.intp),
        offsets=np.array([row[2] for row in rows]) * size,
        roles=tuple(row[3] for row in rows),
        tips=tips * size,
    )


@dataclass(frozen=True, slots=True)
class Stretch:
    """What the person does for a while."""

    seconds: float
    forward: float = 0.0
    """m/s."""
    sideways: float = 0.0
    """m/s to the right."""
    turn: float = 0.0
    """rad/s to the left."""
    crouch: float = 0.0
    """Share of the hips' height given up."""


SCRIPTS: dict[str, tuple[Stretch, ...]] = {
    "walk": (
        Stretch(1.5),
        Stretch(4.0, forward=1.1),
        Stretch(3.0, forward=1.2, turn=0.6),
        Stretch(3.0, forward=1.3, turn=-0.7),
        Stretch(3.0, forward=0.8, turn=0.9),
        Stretch(1.5),
        Stretch(3.0, forward=0.5),
        Stretch(3.0, forward=0.6, turn=-0.8),
        Stretch(2.0),
    ),
    "turn": (
        Stretch(1.5),
        Stretch(2.5, turn=1.2),
        Stretch(1.0),
        Stretch(2.5, turn=-1.3),
        Stretch(1.0),
        Stretch(2.0, turn=0.6),
        Stretch(2.0, turn=-0.6),
        Stretch(1.5),
    ),
    "sidestep": (
        Stretch(1.5),
        Stretch(2.5, sideways=0.5),
        Stretch(1.0),
        Stretch(2.5, sideways=-0.5),
        Stretch(1.0),
        Stretch(2.5, forward=-0.6),
        Stretch(2.0, forward=-0.5, turn=0.5),
        Stretch(1.5),
    ),
    "crouch": (
        Stretch(2.0, crouch=0.38),
        Stretch(3.0, forward=0.6, crouch=0.38),
        Stretch(2.0, turn=0.8, crouch=0.38),
        Stretch(2.5, forward=0.6, turn=-0.4, crouch=0.36),
        Stretch(2.0, turn=-0.8, crouch=0.38),
        Stretch(2.0, crouch=0.38),
    ),
    "visit": (
        Stretch(1.5),
        Stretch(2.5, forward=0.9),
        Stretch(1.5, turn=1.0),
        Stretch(1.5),
        Stretch(2.0, crouch=0.38),
        Stretch(2.0, forward=0.5, crouch=0.36),
        Stretch(1.5),
        Stretch(2.0, sideways=0.4),
        Stretch(2.5, forward=1.1, turn=-0.7),
        Stretch(1.5),
    ),
}
"""Demo takes by name. "visit" is the user's: its motion is in no database of the demo."""


def demo_motion(script: str, seed: int = 0, fps: float = 60.0, height: float = 1.75) -> Motion:
    """A demo take.

    Args:
        script: a key of `SCRIPTS`.
        seed: decides where the person looks and what the hands do; same seed, same motion.
        fps: frames per second.
        height: body height, metres.
    """
    skeleton = demo_skeleton(height)
    path, yaws, crouch = _path(SCRIPTS[script], fps)
    feet, foot_yaws, foot_pitch = _feet(path, yaws, fps, height)
    ankles = feet + quat.rotate(_foot_turn(foot_yaws, foot_pitch), _toe_to_ankle(skeleton))
    rotations = np.zeros((len(path), len(skeleton), 4))
    rotations[..., 0] = 1.0
    hips = _hips(path, yaws, crouch, ankles, skeleton)
    rotations[:, 0] = quat.multiply(quat.from_yaw(yaws), quat.from_axis("X", -0.25 * crouch))
    rng = np.random.default_rng(seed)
    _pose_upper_body(rotations, skeleton, feet, yaws, path, crouch, rng, fps)
    _pose_legs(rotations, skeleton, hips, ankles, foot_yaws, foot_pitch)
    return Motion(skeleton, fps, hips, quat.continuous(rotations))


def _path(script: tuple[Stretch, ...], fps: float) -> tuple[Array, Array, Array]:
    """Ground positions `(T, 2)`, yaws `(T,)` and crouch `(T,)` of a script, with soft starts and stops."""
    rows = [[s.sideways, s.forward, s.turn, s.crouch] for s in script for _ in range(round(s.seconds * fps))]
    commands = np.array(rows)
    half = round(0.35 * fps)
    kernel = np.hanning(2 * half + 3)[1:-1]
    padded = np.pad(commands, ((half, half), (0, 0)), mode="edge")
    smooth = np.stack([np.convolve(c, kernel / kernel.sum(), mode="valid") for c in padded.T], axis=-1)
    yaws = np.cumsum(smooth[:, 2]) / fps
    path = np.cumsum(angles.turn(smooth[:, :2], yaws), axis=0) / fps
    return path, yaws, smooth[:, 3]


def _feet(path: Array, yaws: Array, fps: float, height: float) -> tuple[Array, Array, Array]:
    """Toe positions `(T, 2, 3)`, foot yaws `(T, 2)` and pitches `(T, 2)`: planted, then swung to the next hold."""
    count = len(path)
    times = np.arange(count) / fps
    toes, foot_yaws, pitch = np.zeros((count, 2, 3)), np.zeros((count, 2)), np.zeros((count, 2))
    for side in range(2):
        cycle = times * _STEPS_PER_S / 2.0 + 0.5 * side
        step = np.floor(cycle).astype(int)
        share = cycle - step
        # a hold lies where the body is in the middle of the stance that uses it
        holds: Array = np.arange(int(step.max()) + 3, dtype=np.float64)
        middle = (holds - 0.5 * side + 0.5 * _STANCE) * 2.0 / _STEPS_PER_S
        at = np.clip(np.round(middle * fps).astype(int), 0, count - 1)
        aside = np.array([-_HALF_STANCE_M if side == 0 else _HALF_STANCE_M, 0.14]) * height / 1.75
        places = path[at] + angles.turn(aside, yaws[at])
        swing = np.clip((share - _STANCE) / (1.0 - _STANCE), 0.0, 1.0)
        ease = swing**3 * (10.0 - 15.0 * swing + 6.0 * swing**2)
        here, there = places[step], places[step + 1]
        toes[:, side, :2] = here + ease[:, None] * (there - here)
        foot_yaws[:, side] = yaws[at][step] + ease * (yaws[at][step + 1] - yaws[at][step])
        stride = np.linalg.norm(there - here, axis=-1) + 0.2 * np.abs(yaws[at][step + 1] - yaws[at][step])
        lift = np.sin(np.pi * ease) ** 2
        toes[:, side, 2] = 0.02 * height / 1.75 + lift * np.minimum(0.12, 0.12 * stride)
        pitch[:, side] = -lift * np.minimum(0.6, 0.7 * stride)
    return toes, foot_yaws, pitch


def _foot_turn(foot_yaws: Array, pitch: Array) -> Array:
    """Foot rotations `(T, 2, 4)`: heading, then toes down for negative pitch."""
    return quat.multiply(quat.from_yaw(foot_yaws), quat.from_axis("X", pitch))


def _toe_to_ankle(skeleton: Skeleton) -> Array:
    """`(2, 3)` from toe joint to ankle joint in T-pose."""
    return -skeleton.offsets[[skeleton.joint(f"toe.{side}") for side in SIDES]]


def _hips(path: Array, yaws: Array, crouch: Array, ankles: Array, skeleton: Skeleton) -> Array:
    """Hips `(T, 3)`: over the feet's middle, low enough that both legs reach their ankles."""
    middle = 0.6 * path + 0.4 * ankles[..., :2].mean(axis=1)
    forward = angles.direction(yaws)
    ground = middle - 0.10 * crouch[:, None] * forward
    reach = 0.985 * skeleton.leg_length()
    drop = -skeleton.offsets[skeleton.joint("thigh.L"), 2]
    aside = np.stack([-np.ones_like(yaws), np.ones_like(yaws)], axis=-1)[..., None] * _HALF_HIPS_M
    sockets = ground[:, None] + aside * np.stack([np.cos(yaws), np.sin(yaws)], axis=-1)[:, None]
    flat = np.linalg.norm(sockets - ankles[..., :2], axis=-1)
    highest = np.min(np.sqrt(np.maximum(reach**2 - flat**2, 0.01)) + ankles[..., 2], axis=1) + drop
    height = np.minimum(highest, skeleton.offsets[0, 2] * (0.985 - crouch))
    return np.column_stack([ground, height])


def _pose_upper_body(
    rotations: Array,
    skeleton: Skeleton,
    feet: Array,
    yaws: Array,
    path: Array,
    crouch: Array,
    rng: np.random.Generator,
    fps: float,
) -> None:
    """Spine against the crouch, head looking around, arms swinging against the legs and reaching now and then."""
    count = len(yaws)
    for role in ("spine1", "spine2", "spine3", "chest"):
        rotations[:, skeleton.joint(role)] = quat.from_axis("X", -0.08 * crouch)
    look = _wander(rng, count, fps, 3.0)
    nod = _wander(rng, count, fps, 4.0)
    counter = quat.from_axis("X", 0.5 * crouch - 0.05 + 0.15 * nod)
    rotations[:, skeleton.joint("head")] = quat.multiply(quat.from_yaw(0.5 * look), counter)
    rotations[:, skeleton.joint("neck")] = quat.from_yaw(0.3 * look)
    ahead = np.einsum("tsk,tk->ts", feet[..., :2] - path[:, None], angles.direction(yaws))
    for side, sign in ((0, 1.0), (1, -1.0)):
        reach = np.clip(_wander(rng, count, fps, 2.5), 0.0, 1.0)
        swing = -1.2 * (ahead[:, side] - 0.14) + 0.9 * reach
        hang = quat.from_axis("Y", np.full(count, -sign * 1.35))
        upper = quat.multiply(quat.from_axis("X", swing), hang)
        rotations[:, skeleton.joint(f"upper_arm.{'LR'[side]}")] = upper
        bend = 0.35 + 0.5 * reach + 0.15 * np.abs(swing)
        rotations[:, skeleton.joint(f"forearm.{'LR'[side]}")] = quat.from_axis("Z", -sign * bend)


def _wander(rng: np.random.Generator, count: int, fps: float, period_s: float) -> Array:
    """Smooth noise `(T,)` of about unit size."""
    knots = rng.normal(size=int(count / fps / period_s) + 4)
    at = np.arange(count) / fps / period_s
    index = at.astype(int)
    share = (1.0 - np.cos(np.pi * (at - index))) / 2.0
    return knots[index] + share * (knots[index + 1] - knots[index])


def _pose_legs(
    rotations: Array, skeleton: Skeleton, hips: Array, ankles: Array, foot_yaws: Array, pitch: Array
) -> None:
    """Legs that put the ankles where they are to be, knees over the feet (law of cosines)."""
    for side, letter in enumerate(SIDES):
        thigh, shin, foot, _ = (skeleton.joint(f"{part}.{letter}") for part in LEG)
        upper, lower = (-skeleton.offsets[j, 2] for j in (shin, foot))
        socket = hips + quat.rotate(rotations[:, 0], skeleton.offsets[thigh])
        line = ankles[:, side] - socket
        length = np.minimum(np.linalg.norm(line, axis=-1), (upper + lower) * 0.9999)
        down = _unit(line)
        ahead: Array = np.column_stack([angles.direction(foot_yaws[:, side]), np.zeros(len(hips))])
        hinge = _unit(np.cross(ahead, -down))
        bend = np.arccos(np.clip((upper**2 + length**2 - lower**2) / (2 * upper * length), -1.0, 1.0))
        knee = np.arccos(np.clip((upper**2 + lower**2 - length**2) / (2 * upper * lower), -1.0, 1.0))
        straight = quat.from_matrix(np.stack([hinge, np.cross(-down, hinge), -down], axis=-1))
        thigh_turn = quat.multiply(straight, quat.from_axis("X", bend))
        shin_turn = quat.multiply(thigh_turn, quat.from_axis("X", knee - np.pi))
        foot_turn = _foot_turn(foot_yaws[:, side], pitch[:, side])
        rotations[:, thigh] = quat.multiply(quat.conjugate(rotations[:, 0]), thigh_turn)
        rotations[:, shin] = quat.multiply(quat.conjugate(thigh_turn), shin_turn)
        rotations[:, foot] = quat.multiply(quat.conjugate(shin_turn), foot_turn)
        rotations[:, skeleton.joint(f"toe.{letter}")] = quat.from_axis("X", -pitch[:, side])


def _unit(vectors: Array) -> Array:
    """`vectors` `(T, 3)` at length one."""
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)

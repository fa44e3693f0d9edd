"""The takes that the motion model learns from, brought onto its one body, with what is told of every frame."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from footwork.core.body import forward_kinematics as fk
from footwork.core.body.edit import cut, mirror, resample
from footwork.core.body.motion import Motion
from footwork.core.body.retarget import retarget
from footwork.core.body.skeleton import SIDES
from footwork.core.maths import angles, filters, kinematics
from footwork.core.mocap import checks
from footwork.core.mocap.take import Take
from footwork.core.mocap.takes import load_take
from footwork.nn.motion.body import TOE_HEIGHT, ankle_of, put_ankles, starter_skeleton
from footwork.nn.motion.conditions import Root, conditions, poses_of, root_of, soft_contacts
from footwork.nn.train.curation import curate
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]

FPS = 30.0
CONTACT_SPEED = 0.25
"""m/s of a toe below which it stands."""
_EDGE_S = 1.0
"""Seconds at a stretch's ends of which the path before or after is not known."""

PEOPLE = ("o3de", "xsens", "fubot", "reactidle")
O3DE = "MIT, Open 3D Engine contributors (elected from Apache-2.0 or MIT)"
SOURCES: tuple[tuple[str, str, str], ...] = (
    ("o3de/*.bvh", "o3de", O3DE),
    ("xsens/JL_mm_run.bvh", "xsens", "MIT, (c) 2023 Reiya Itatani"),
    ("xsens/100STYLE_*.bvh", "xsens", 'CC BY 4.0, "The 100STYLE Dataset", Ian Mason'),
    ("fubot_vr/*.bvh", "fubot", "MIT, (c) 2021 Tomiha (FuBoT-VR)"),
    ("reactidle/*genuine.bvh", "reactidle", "MIT, (c) 2025 RSAIT"),
)
"""Patterns of take files, whose they are, and their licence: all allow weights that ship."""
LEFT_OUT = (
    *("O3DE_Jumps1", "O3DE_JumpsFreeRoam1", "O3DE_Pushes1", "O3DE_OutofRange1"),
    *("jobsimulator_1", "jobsimulator_2", "jobsimulator_3", "beatsaber_10", "beatsaber_11"),
)
"""Jumps and pushes are not meant, and drifted suits are not true."""
HELD_OUT = ("beatsaber_5",)
"""Kept back as a user whom the model does not know."""
REVERSED = ("O3DE_Walk1", "O3DE_Walk2", "O3DE_WalkStopTurn1", "JL_mm_run", "100STYLE_Neutral_FW")
"""Walks that are also shown in reversed time where they then go backwards: real ones are rare."""


@dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """A part of a take on the model's body, with its root and contacts."""

    take: str
    person: int
    motion: Motion
    root: Root
    contacts: NDArray[np.bool_]
    """`(T, 2)`."""
    valid: NDArray[np.bool_]
    """`(T,)` frames to learn from."""


def normalised(motion: Motion) -> tuple[Motion, float, float]:
    """The motion on the model's body with its toes as they stood, the share of frames with a leg too short before that,
    and the metres that the hips were lowered for it.
    """
    body = starter_skeleton()
    ratio = body.leg_length() / motion.skeleton.leg_length()
    moved = retarget(motion, body, scale_travel=True)
    sources, _ = motion.forward()
    positions, rotations = moved.forward()
    toes = np.stack([sources[:, motion.skeleton.joint(f"toe.{s}")] for s in SIDES], axis=1) * ratio
    standing = np.linalg.norm(kinematics.velocity(toes, motion.fps), axis=-1) < CONTACT_SPEED
    low = toes[..., 2][standing & (toes[..., 2] < np.quantile(toes[..., 2], 0.3) + 0.05)]
    toes[..., 2] += TOE_HEIGHT - float(np.median(low))
    feet = [rotations[:, body.joint(f"foot.{s}")] for s in SIDES]
    ankles = np.stack([ankle_of(body, s, toes[:, i], feet[i]) for i, s in enumerate(SIDES)], axis=1)
    reach = np.max(
        [
            np.linalg.norm(ankles[:, i] - positions[:, body.joint(f"thigh.{s}")], axis=-1)
            for i, s in enumerate(SIDES)
        ],
        axis=0,
    )
    over = reach - 0.998 * body.leg_length()
    drop = max(0.0, float(np.quantile(over, 0.97)))
    positions = positions - (0.0, 0.0, drop)
    world = put_ankles(body, positions, rotations, ankles)
    out = Motion(body, motion.fps, positions[:, 0], fk.local_rotations(world, body.parents))
    return out, float(np.mean(over > 0.0)), drop


def contacts_of(motion: Motion) -> NDArray[np.bool_]:
    """Contacts `(T, 2)` by the speed of the toes, without flicker."""
    positions, _ = motion.forward()
    toes = np.stack([positions[:, motion.skeleton.joint(f"toe.{s}")] for s in SIDES], axis=1)
    speed = np.linalg.norm(kinematics.velocity(toes, motion.fps), axis=-1)
    return filters.median(speed < CONTACT_SPEED, filters.odd_window(0.1, motion.fps))


def stretches_of(take: Take, person: str) -> list[Stretch]:
    """What of a take is fit to learn from, and its mirror image, and its reverse where that helps."""
    motion = resample(take.motion, FPS)
    ratio = FPS / take.motion.fps
    bad = checks.glitches(take.motion)
    found: list[Stretch] = []
    for start, stop in curate(take).stretches:
        a, b = int(np.ceil(start * ratio)), min(int(stop * ratio), len(motion))
        if b - a < 4.0 * FPS:
            continue
        part, short, drop = normalised(cut(motion, a, b))
        print(
            f"  {take.name} {a}-{b}: {100 * short:.1f} % of frames with a leg too short, "
            f"hips lowered by {100 * drop:.1f} cm"
        )
        good = np.ones(b - a, dtype=bool)
        for frame in np.flatnonzero(bad[start:stop]) * ratio:
            good[max(int(frame) - 8, 0) : int(frame) + 9] = False
        backwards = take.name in REVERSED
        for image in (part, mirror(part)):
            found.append(_stretch(take.name, person, image, good))
            if backwards:
                reverse = replace(image, positions=image.positions[::-1], rotations=image.rotations[::-1])
                made = _stretch(take.name, person, reverse, good[::-1])
                ahead = velocities(made.root)[:, 1]
                found.append(replace(made, valid=made.valid & (ahead < -0.2) & (ahead > -1.3)))
    return found


def _stretch(name: str, person: str, motion: Motion, good: NDArray[np.bool_]) -> Stretch:
    edge = int(_EDGE_S * FPS)
    valid = good.copy()
    valid[:edge] = valid[-edge:] = False
    return Stretch(name, PEOPLE.index(person), motion, root_of(motion), contacts_of(motion), valid)


def velocities(root: Root) -> Array:
    """`(T, 4)`: to the right, ahead (m/s), turn (rad/s), height of the hips (m)."""
    speed = angles.turn(kinematics.velocity(root.places, root.fps), -root.yaws)
    turn = kinematics.velocity(root.yaws[:, None], root.fps)
    return np.column_stack([speed, turn, root.heights])


def weights_of(stretch: Stretch) -> Array:
    """How often each frame is shown `(T,)`: what is rare, more."""
    side, ahead, turn, height = velocities(stretch.root).T
    speed = np.hypot(side, ahead)
    standing = starter_skeleton().offsets[0, 2]
    weight = np.ones(len(side))
    weight[(np.abs(side) > 0.2) & (np.abs(side) > 0.7 * np.abs(ahead))] = 3.0
    weight[ahead < -0.15] = 2.5
    weight[(speed < 0.3) & (np.abs(turn) > 0.6)] = 2.5
    weight[height < 0.86 * standing] = 3.0
    weight[(speed > 1.9) & (speed < 3.5)] = 2.0
    weight[speed > 4.0] = 0.3
    if PEOPLE[stretch.person] == "fubot":
        weight[(speed < 0.1) & (np.abs(turn) < 0.3)] *= 0.4
    if PEOPLE[stretch.person] == "reactidle":
        weight *= 0.4
    return np.where(stretch.valid, weight, 0.0)


def load(folder: Path, *, held_out: bool = False) -> tuple[list[Stretch], dict[str, tuple[str, str]]]:
    """All stretches, and by name of the take its SHA-256 and licence."""
    stretches: list[Stretch] = []
    told: dict[str, tuple[str, str]] = {}
    for pattern, person, licence in SOURCES:
        for file in sorted(folder.glob(pattern)):
            if file.stem in LEFT_OUT or (file.stem in HELD_OUT) != held_out:
                continue
            take = load_take(file)
            made = stretches_of(take, person)
            if made:
                stretches += made
                told[take.name] = take.sha256, licence
    return stretches, told


def arrays(stretches: list[Stretch]) -> dict[str, Array]:
    """Inputs, answers and weights of all frames, one after another."""
    parts: dict[str, list[Array]] = {
        key: [] for key in ("x", "y", "w", "person", "yaw", "place", "contact", "run")
    }
    for n, item in enumerate(stretches):
        count = len(item.root)
        parts["x"].append(conditions(item.root, soft_contacts(item.contacts, FPS)))
        parts["y"].append(poses_of(item.motion, item.root))
        parts["w"].append(weights_of(item))
        parts["person"].append(np.full(count, item.person))
        parts["yaw"].append(item.root.yaws)
        parts["place"].append(np.column_stack([item.root.places, item.root.heights]))
        parts["contact"].append(item.contacts.astype(np.float64))
        parts["run"].append(np.full(count, n))
    return {key: np.concatenate(value) for key, value in parts.items()}

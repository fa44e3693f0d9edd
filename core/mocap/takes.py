"""Takes: mocap files read into Footwork's one convention, with what was found in them and what is doubtful."""

from __future__ import annotations

import os
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body import forward_kinematics as fk
from ..body.edit import resample
from ..body.motion import Motion
from ..body.skeleton import SIDES, Skeleton
from ..bounds import BODY_LENGTH, BONE_SHARE, RESAMPLED_JOINT_FRAMES, RESAMPLED_TIMES
from ..errors import InputError
from ..maths import quat
from . import checks
from .answers import NO_ANSWERS, STATED_UNITS, TakeAnswers
from .bvh import BvhFile
from .containers import SceneReader, container_of, read_container
from .floor import SOLE, floor_height, is_floor, standing_height
from .raw_body import UNITS, RawBody, find_unit, find_up, reduce_to_body, some_poses, with_toes
from .roles import match_roles
from .take import Take
from .tpose import FORWARD, NEAR, lifted_arms, looks_like_tpose, tpose_rotations
from .typical import typical_pose

Array = NDArray[np.floating[Any]]

_POSES = 24
"""Frames in which the structure of an unknown skeleton is looked at."""
_RATES = (5.0, 1000.0)
"""Frames per second of usual mocap."""
_USUAL = (24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 90.0, 100.0, 120.0, 240.0)
_FEW_DIGITS = 4
_WRITTEN = 0.005
"""Share by which a frame time that is written with few digits may be off."""
_TPOSE_FRAME = np.radians(25.0)
"""A first frame whose limbs are this near to T-pose is one."""
_THROWN = 6.0
"""m/s: a body that leaves a T-pose faster than this was put there by a program."""
_LEAD_OUT_S = 0.1
"""Some converters smooth the jump from the T-pose over a few frames, no more than this."""
_UP_AXES = {
    "X": quat.from_axis("Y", np.pi / 2),
    "Y": quat.from_axis("X", -np.pi / 2),
    "Z": quat.IDENTITY,
}
"""What turns Blender's up to the axis of a file that points up."""
_TALL = (1.0, 2.3)
"""Metres that a person is tall."""
_LENGTH_SHARE = 0.87
"""Of a person's height: along thigh and shin and from the hips to the head."""
_RARE_UNITS = ("dm", "in")
_FLOATING = 0.3
"""Metres over the file's ground at which no foot stands."""
_LONGEST_JUMP = 1.0
"""Seconds: one of 1.2 m high."""
_SLIDE = 0.01
"""Metres that a joint may move against its parent before it is mentioned."""


def is_take(path: str | os.PathLike[str]) -> bool:
    """Whether a file is one of `CONTAINERS`, whatever its name; InputError where it cannot be read."""
    return not Path(path).is_dir() and container_of(path) is not None


def load_take(
    path: str | os.PathLike[str],
    fps: float | None = None,
    answers: TakeAnswers = NO_ANSWERS,
    scenes: SceneReader | None = None,
) -> Take:
    """Read a mocap file into metres, Z up, T-pose at zero.

    Args:
        path: a file of one of `CONTAINERS`.
        fps: frames per second of the result; None keeps the file's rate.
        answers: what a person says of the file; what is not said the file and the motion tell.
        scenes: reads FBX and glTF; None where there is no Blender.

    Raises:
        InputError: not a file of one humanoid's motion; says what is wrong. With `answers.strict` also a doubt.
    """
    answers.check()
    return take_from_bvh(read_container(path, answers.rate, scenes), fps, answers)


def take_from_bvh(bvh: BvhFile, fps: float | None = None, answers: TakeAnswers = NO_ANSWERS) -> Take:
    """As `load_take`, from a file that has been read already."""
    notes = _Notes(doubts=list(bvh.doubts))
    body = _read_body(bvh, answers, notes)
    rate = answers.rate or _find_rate(bvh.frame_time, notes)
    said = f"frame time {bvh.frame_time:g} s" if answers.rate is None else "as stated"
    notes.found["rate"] = f"{rate:g} fps ({said}), {len(bvh)} frames, {len(bvh) / rate:.1f} s"
    cut, in_tpose = _first_frame(body, rate, notes)
    tpose = _find_tpose(body, in_tpose, cut, rate, notes, chance=bvh.zero_is_a_frame)
    motion = _on_floor(to_motion(body.frames(cut), tpose, rate), notes)
    _check(motion, cut, notes)
    if answers.strict and notes.doubts:
        raise InputError(f"{bvh.file}: {notes.doubts[0]}; this counts as a fault with --strict")
    if fps is not None and fps != rate:
        size = len(motion) * len(motion.skeleton)
        if size * fps / rate > max(RESAMPLED_JOINT_FRAMES, RESAMPLED_TIMES * size):
            raise InputError(
                f"{bvh.file}: {rate:g} frames per second are too few to be brought to {fps:g}; check its frame time, "
                "or say it with --rate"
            )
        motion = resample(motion, fps)
        notes.found["resampled"] = f"to {fps:g} fps, {len(motion)} frames"
    return Take(
        name=Path(bvh.file).stem,
        file=bvh.file,
        sha256=bvh.sha256,
        motion=motion,
        found=notes.found,
        doubts=tuple(notes.doubts),
    )


def _find_rate(frame_time: float, notes: _Notes) -> float:
    """Frames per second of a file, with what is doubtful about it."""
    rate = frame_rate(frame_time)
    if abs(1.0 / rate - frame_time) > _WRITTEN * frame_time:
        notes.doubts.append(
            f"the frame time {frame_time:g} s is taken for 1/{rate:g}, which it may be short for; "
            f"say it: --rate {rate:g}"
        )
    if not _RATES[0] <= rate <= _RATES[1]:
        notes.doubts.append(f"{rate:g} frames per second are unlikely; say the rate: --rate N")
    return rate


def frame_rate(frame_time: float) -> float:
    """Frames per second of a frame time written with few digits: whole or broadcast rates where they fit."""
    digits = len(np.format_float_positional(frame_time).partition(".")[2])
    slack = 0.51 * 10.0**-digits
    whole = float(max(round(1.0 / frame_time), 1))
    broadcast = max(round(1.001 / frame_time), 1) / 1.001
    for rate in (whole, broadcast):
        if abs(rate * frame_time - 1.0) < 1e-4:
            return rate
    usual = min(_USUAL, key=lambda rate: abs(1.0 / rate - frame_time))
    for rate in (*((usual,) if digits <= _FEW_DIGITS else ()), whole, broadcast):
        if abs(1.0 / rate - frame_time) <= slack:
            return rate
    return 1.0 / frame_time


def to_motion(body: RawBody, tpose: Array, fps: float) -> Motion:
    """Rotations since T-pose: a change of basis that moves no joint. The hips' own offset is left at 0."""
    offsets = quat.rotate(tpose[np.maximum(body.parents, 0)], body.offsets)
    offsets[0] = 0.0
    since = quat.multiply(body.rotations, quat.conjugate(tpose))
    skeleton = Skeleton(body.names, body.parents, offsets, body.roles, quat.rotate(tpose, body.tips))
    rotations = fk.local_rotations(since, body.parents)
    return Motion(skeleton, fps, body.positions[:, 0], rotations)


@dataclass(slots=True)
class _Notes:
    """What is said about a take, while it is read."""

    found: dict[str, str] = field(default_factory=dict[str, str])
    doubts: list[str] = field(default_factory=list[str])


def _read_body(bvh: BvhFile, answers: TakeAnswers, notes: _Notes) -> RawBody:
    """The humanoid's joints in metres and Z up."""
    try:
        match = match_roles(bvh.names, bvh.parents, poses=lambda: some_poses(bvh, _POSES))
    except InputError as error:
        raise InputError(f"{bvh.file}: {error}") from None
    known = sum(role != "" for role in match.roles)
    notes.found["joint names"] = f"{match.family}, {known} of {len(bvh.names)} joints have a role"
    notes.doubts.extend(match.doubts)
    body, made = with_toes(reduce_to_body(bvh, match.roles))
    metres = _find_unit(body, answers, bvh.file, notes)
    up = _find_up(body, answers, notes)
    body = body.turned(quat.conjugate(_UP_AXES[up]), metres)
    notes.found["axes"] = up
    if made:
        notes.found["toes"] = f"made at the ends of {' and '.join(made)}, which have none"
    elif "toe.L" not in body.roles or "toe.R" not in body.roles:
        notes.doubts.append("the feet have neither toes nor end sites: contacts are judged at the ankles")
    for name, slide in zip(body.names, body.slide.tolist(), strict=True):
        if slide > _SLIDE:
            notes.doubts.append(
                f"{name} slides by up to {100 * slide:.1f} cm on its parent; it is held at its median place"
            )
    return body


def _find_unit(body: RawBody, answers: TakeAnswers, file: str, notes: _Notes) -> float:
    """Metres of the file's unit, as stated or else as the body's size tells."""
    unit, length = find_unit(body)
    if answers.unit:
        metres = STATED_UNITS[answers.unit]
        unit, length = answers.unit, length / UNITS[unit] * metres
    else:
        metres = UNITS[unit]
    stated = ", as stated" if answers.unit else ""
    notes.found["unit"] = f"{unit} (thigh, shin and hips to head measure {length:.2f} m{stated})"
    tall = length / _LENGTH_SHARE
    if not _TALL[0] <= tall <= _TALL[1]:
        ask = "check --unit" if answers.unit else "say the unit: --unit m, cm, in ..."
        notes.doubts.append(
            f"the body is about {tall:.2f} m tall with {unit} as unit: not an adult's size; {ask}"
        )
    elif not answers.unit and unit in _RARE_UNITS:
        notes.doubts.append(
            f"{unit} is a rare unit, taken since the body is {tall:.2f} m tall then; say it: --unit {unit}"
        )
    _check_size(body, file, length, metres)
    return metres


def _find_up(body: RawBody, answers: TakeAnswers, notes: _Notes) -> str:
    """The file's axis that points up, as stated or else as the body tells."""
    if answers.up:
        notes.found["up axis"] = f"{answers.up}, as stated"
        return answers.up
    up, share = find_up(body)
    notes.found["up axis"] = up
    if share < 0.6:
        notes.doubts.append(
            f"{up} is taken as up, but the head is above the feet along it for little of the time; say it: --up {up}"
        )
    return up


def _check_size(body: RawBody, file: str, length: float, metres: float) -> None:
    """Refuse bodies that no unit makes a person, whose limbs have no length or whose legs are one.

    Args:
        body: in the file's unit.
        file: its name.
        length: of the body as `find_unit` measures it, metres.
        metres: of the file's unit.
    """
    if not BODY_LENGTH[0] <= length <= BODY_LENGTH[1]:
        raise InputError(
            f"{file}: the body measures {length:.3g} m, whatever the unit: no length of a person; export anew"
        )
    bones = np.linalg.norm(body.offsets[1:], axis=-1) * metres
    if bones.max() > BONE_SHARE * length:
        name = body.names[1 + int(bones.argmax())]
        raise InputError(
            f"{file}: the bone that ends at {name} measures {bones.max():.3g} m of {length:.2f} m; export anew"
        )
    least = 1e-3 * float(np.linalg.norm(body.offsets[1:], axis=-1).sum())
    for side in SIDES:
        for part in ("forearm", "hand", "shin", "foot"):
            joint = body.joint(f"{part}.{side}")
            if np.linalg.norm(body.offsets[joint]) <= least:
                raise InputError(
                    f"{file}: the bone that ends at {body.names[joint]} has no length; export anew"
                )
    apart = body.positions[:, body.joint("thigh.R")] - body.positions[:, body.joint("thigh.L")]
    if np.linalg.norm(apart, axis=-1).max() <= least:
        raise InputError(f"{file}: both legs start at the same place; export anew")


def _first_frame(body: RawBody, fps: float, notes: _Notes) -> tuple[int, bool]:
    """How many frames to cut at the start, and whether the first one shows a T-pose."""
    if not looks_like_tpose(body.roles, body.positions[0], _TPOSE_FRAME):
        return 0, False
    half_second = max(int(0.5 * fps), 2)
    speeds = np.linalg.norm(np.diff(body.positions[: 2 * half_second], axis=0), axis=-1).max(axis=1) * fps
    if len(speeds) < 2 or speeds[0] < max(_THROWN, 3.0 * float(np.median(speeds[1:]))):
        notes.found["first frame"] = "T-pose"
        return 0, True
    cut, last = 1, min(int(_LEAD_OUT_S * fps), len(speeds))
    while cut < last and speeds[cut] > max(2.0, 1.5 * float(np.median(speeds[cut : cut + half_second]))):
        cut += 1
    notes.found["first frame"] = f"T-pose, cut ({cut} frame{'s' * (cut > 1)})"
    return cut, True


def _find_tpose(
    body: RawBody, first_frame: bool, cut: int, fps: float, notes: _Notes, *, chance: bool
) -> Array:
    """Global rotations in T-pose, from the zero pose, a first frame in T-pose or the data.

    A zero pose that came about by chance, as one of the motion's own, is trusted as a T-pose alone.
    """
    up = _UP_AXES[notes.found.pop("axes")]
    zero = np.repeat(quat.conjugate(up)[None], len(body.names), axis=0)
    rest, positions = zero, body.pose(zero)
    source = "the file's zero pose"
    lifted = None if chance else lifted_arms(body.parents, body.roles, zero, positions)
    if lifted is not None:
        rest, positions = lifted
    if lifted is not None and looks_like_tpose(body.roles, positions, NEAR):
        source = "the file's zero pose, its hanging arms lifted"
    elif not looks_like_tpose(body.roles, positions, _TPOSE_FRAME if chance else NEAR):
        rest, positions = zero, body.pose(zero)
        source = "the data (the file's zero pose is none)"
        if len(body.positions) - cut < 2 and not first_frame:
            notes.doubts.append(
                "one frame, and neither it nor the zero pose is a T-pose: rotations are unsure"
            )
        if first_frame:
            rest, positions = body.rotations[0], body.positions[0]
            source = "the first frame"
    tpose = tpose_rotations(body.parents, body.roles, rest, positions, typical_pose(body.frames(cut), fps))
    # where the hips' forward points in the file when the hips are not turned
    forward = quat.rotate(quat.multiply(up, quat.multiply(zero[0], quat.conjugate(tpose[0]))), FORWARD)
    notes.found["T-pose"] = f"from {source}"
    notes.found["hips forward"] = f"{_axis_name(forward)} of the unturned hips"
    return tpose


def _axis_name(direction: Array) -> str:
    """ "+Z", or the vector where no axis is within a degree."""
    axis = int(np.argmax(np.abs(direction)))
    if abs(direction[axis]) > np.cos(np.radians(1.0)):
        return ("+" if direction[axis] > 0 else "-") + "XYZ"[axis]
    return "({:.2f}, {:.2f}, {:.2f})".format(*direction)


def _on_floor(motion: Motion, notes: _Notes) -> Motion:
    """The motion with its floor at Z = 0, and the T-pose standing as high above it as the feet do."""
    height = floor_height(motion)
    kept = is_floor(height)
    stand = height if kept else SOLE
    what = "kept" if kept else f"moved {'up' if height < 0 else 'down'} to {100 * SOLE:.0f} cm"
    notes.found["floor"] = f"joints of standing feet are at {100 * height:.1f} cm, {what}"
    if height > _FLOATING:
        notes.doubts.append(
            f"the feet stand {100 * height:.0f} cm over the file's ground and are moved down to it: "
            "check --unit and --up, or leave out stairs and boxes"
        )
    skeleton = motion.skeleton
    offsets = skeleton.offsets.copy()
    offsets[0, 2] = stand - standing_height(skeleton)
    positions = motion.positions if kept else motion.positions - (0.0, 0.0, height - stand)
    return replace(motion, skeleton=replace(skeleton, offsets=offsets), positions=positions)


def _check(motion: Motion, cut: int, notes: _Notes) -> None:
    """Compare the motion with what people do; frames are told as the file counts them, from 0."""
    aside = checks.toes_aside(motion) if len(motion) > 1 else None
    way, seconds = checks.walking_aside(motion)
    walked = f"; walks {np.degrees(way):.0f} degrees off it for {seconds:.1f} s" if seconds > 1.0 else ""
    if checks.in_place(motion):
        notes.doubts.append(
            "the feet move, but the hips stay at one point: export it with its way, not in place"
        )
    elif (seconds := checks.in_the_air(motion)) > _LONGEST_JUMP:
        notes.doubts.append(
            f"for {seconds:.1f} s at a stretch no part of the body is near the floor: stairs or boxes, or hips without "
            "their height; check --up and --unit"
        )
    if aside is not None:
        notes.found["hips forward"] += f"; toes point {np.degrees(aside):.0f} degrees off it{walked}"
        if abs(aside) > np.radians(60.0):
            notes.doubts.append(
                f"toes point {np.degrees(aside):.0f} degrees off the hips' forward: "
                "left and right are swapped, or the file is mirrored"
            )
    parts = checks.heading_parts(motion)
    if parts is not None and checks.drifted(parts).any():
        listed = " ".join(str(round(value)) for value in np.degrees(parts).tolist())
        notes.doubts.append(
            f"drift: the head's heading parts from the hips' by {listed} degrees over the take's "
            f"{len(parts)} parts; leave it out of orientation training"
        )
    jumps = checks.arm_jumps(motion) + cut
    if len(jumps):
        notes.doubts.append(f"arms jump by more than 40 degrees in one frame, at {_frames(jumps)}")
    bad = checks.glitches(motion)
    if bad.any():
        starts = np.flatnonzero(np.diff(bad.astype(np.int8), prepend=0) > 0)
        notes.doubts.append(
            f"a limb moves as no limb does, at {_frames(starts + cut)}: databases leave these stretches out"
        )
    jumps = checks.hips_jumps(motion) + cut
    if len(jumps):
        notes.doubts.append(f"the hips jump at {_frames(jumps)}: dropped frames or a splice")


def _frames(frames: NDArray[np.intp]) -> str:
    shown = ", ".join(str(frame) for frame in frames[:5].tolist())
    return (
        f"frame {shown}"
        if len(frames) == 1
        else f"{len(frames)} frames ({shown}{', ...' * (len(frames) > 5)})"
    )

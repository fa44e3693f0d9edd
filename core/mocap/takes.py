"""Takes: BVH files read into Footwork's one convention, with what was found in them and what is doubtful."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..maths import kinematics, quat
from .body import UNITS, Body, chain_positions, find_unit, find_up, reduce_to_body, with_toes
from .bvh import BvhFile, read_bvh
from .edit import resample
from .roles import match_roles
from .skeleton import Motion, Skeleton, Take
from .tpose import tpose_rotations
from .typical import typical_pose

Array = NDArray[np.floating[Any]]


def load_take(path: str | os.PathLike[str], fps: float | None = None) -> Take:
    """Read a mocap file into metres, Z up, T-pose at zero.

    Args:
        path: a BVH file.
        fps: frames per second of the result; None keeps the file's rate.

    Raises:
        InputError: not a file of one humanoid's motion; says what is wrong.
    """
    return take_from_bvh(read_bvh(path), fps)


def take_from_bvh(bvh: BvhFile, fps: float | None = None) -> Take:
    """The same from a BVH file that is read already."""
    try:
        match = match_roles(bvh.names, bvh.parents)
    except InputError as error:
        raise InputError(f"{bvh.file}: {error}") from None
    body, _ = with_toes(reduce_to_body(bvh, match.roles))
    unit, _ = find_unit(body)
    up, _ = find_up(body)
    axes = quat.from_axis("X", np.pi / 2 if up == "Y" else 0.0)
    body = body.turned(axes, UNITS[unit])
    rate = frame_rate(bvh.frame_time)
    rest = np.repeat(axes[None], len(body.names), axis=0)
    rest_positions = chain_positions(np.zeros((1, 3)), rest[None], body.offsets, body.parents)[0]
    tpose = tpose_rotations(body.parents, body.roles, rest, rest_positions, typical_pose(body, rate))
    motion = to_motion(body, tpose, rate)
    if fps is not None:
        motion = resample(motion, fps)
    return Take(
        name=Path(bvh.file).stem,
        file=bvh.file,
        sha256=bvh.sha256,
        motion=motion,
        found={"preset": match.preset, "unit": unit, "up": up, "rate": f"{rate:g}"},
        doubts=match.doubts,
    )


def frame_rate(frame_time: float) -> float:
    """Frames per second of a frame time written with few digits: whole or broadcast rates where they fit."""
    digits = len(np.format_float_positional(frame_time).partition(".")[2])
    slack = 0.51 * 10.0**-digits
    whole = max(round(1.0 / frame_time), 1)
    broadcast = max(round(1.001 / frame_time), 1) / 1.001
    for rate in (whole, broadcast):
        if abs(1.0 / rate - frame_time) <= slack:
            return float(rate)
    return float(whole) if abs(whole * frame_time - 1.0) < 0.003 else 1.0 / frame_time


def to_motion(body: Body, tpose: Array, fps: float) -> Motion:
    """Rotations since T-pose: a change of basis that moves no joint."""
    parents = body.parents
    offsets = quat.rotate(tpose[np.maximum(parents, 0)], body.offsets)
    offsets[0] = 0.0
    since = quat.multiply(body.rotations, quat.conjugate(tpose))
    skeleton = Skeleton(body.names, parents, offsets, body.roles, quat.rotate(tpose, body.tips))
    lowest = skeleton.tpose_positions()[:, 2].min()
    offsets[0, 2] = -lowest
    return Motion(skeleton, fps, body.hips, kinematics.local_rotations(since, parents))

"""What is in a motion database, and what it covers, for people and for reports."""

from __future__ import annotations

import math
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ..body.motion import Motion
from ..body.toes import place_toes
from ..errors import FaultError
from ..json_text import parse_json
from ..maths import angles, kinematics, quat
from ..recording.mounts import SIMULATED_MOUNTS
from .motion_database import Clip, MotionDatabase

Array = NDArray[np.floating[Any]]

SPEED_BINS = (0.0, 0.1, 0.3, 0.6, 1.0, 1.5, 2.0, 3.0, math.inf)
"""Borders in m/s of the root's ground speed: from standing (below 0.1) to sprinting."""
TURN_BINS_DEG = (-math.inf, -180.0, -90.0, -45.0, -15.0, 15.0, 45.0, 90.0, 180.0, math.inf)
"""Borders in degrees per second of the root's turning; positive to the left."""
DIRECTIONS = ("forward", "left", "backward", "right")
"""Where the root goes, as it sees it: quarters of the circle about these."""
_SMOOTHING_S = 0.5
"""Speed and turning are counted without the sway of single steps."""


def describe_database(database: MotionDatabase) -> dict[str, Any]:
    """Contents, coverage and provenance, ready for JSON; numbers rounded for reading.

    `coverage.frames` counts frames by direction, speed and turning. `foot_skate_cm_s` is the mean horizontal
    toe speed in contact: no bake on this database can be expected to skate less before feet are locked.
    """
    positions, rotations = _in_root_space(database).forward()
    ratios = _headset_heights(database, positions, rotations) / database.head_height
    toes = place_toes(database.skeleton, positions, rotations)
    provenance = {key: _json_or_text(value) for key, value in database.provenance.items()}
    return {
        "name": database.name,
        "frames": len(database),
        "seconds": round(len(database) / database.fps, 3),
        "fps": database.fps,
        "found_frames": int(database.features.trajectory_valid.sum()),
        "joints": len(database.skeleton),
        "head_height_m": round(database.head_height, 4),
        "body_height": _body_height(provenance),
        "height_range": list(database.height_range),
        "suggested_height_range": list(_kept_range(ratios)),
        "tags": list(database.tags),
        "clips": [_clip(clip, database.fps) for clip in database.clips],
        "coverage": _coverage(database),
        "hips_height_m": _percentiles(database.poses.hips_positions[:, 2]),
        "headset_height_ratio": _percentiles(ratios),
        "feet": _feet(database, toes),
        "provenance": provenance,
    }


def _in_root_space(database: MotionDatabase) -> Motion:
    """All frames as one motion whose virtual root stands still at the origin."""
    poses = database.poses
    return Motion(database.skeleton, database.fps, poses.hips_positions, poses.rotations)


def _headset_heights(database: MotionDatabase, positions: Array, rotations: Array) -> Array:
    head = database.skeleton.joint("head")
    return positions[:, head, 2] + quat.rotate(rotations[:, head], SIMULATED_MOUNTS.offsets[0])[:, 2]


def _kept_range(ratios: Array) -> tuple[float, float]:
    low, high = np.percentile(ratios, [2.0, 98.0])
    low, high = math.floor(low * 100.0) / 100.0, math.ceil(high * 100.0) / 100.0
    return low, max(high, low + 0.01)


def _body_height(provenance: dict[str, Any]) -> float:
    """What the takes were brought to, as a share of standing; 1 where nothing is said."""
    settings = provenance.get("settings")
    said = cast(dict[str, Any], settings).get("body_height") if isinstance(settings, dict) else None
    return float(said) if isinstance(said, (int, float)) else 1.0


def _clip(clip: Clip, fps: float) -> dict[str, Any]:
    return {
        "name": clip.name,
        "start": clip.start,
        "stop": clip.stop,
        "seconds": round((clip.stop - clip.start) / fps, 3),
        "file": clip.file,
        "sha256": clip.sha256,
        "mirrored": clip.mirrored,
    }


def _coverage(database: MotionDatabase) -> dict[str, Any]:
    """Frames by direction, speed and turning rate, and the shares of each alone."""
    velocities, turning = _smooth_root_motion(database)
    speeds: Array = np.linalg.norm(velocities, axis=-1)
    quarter = np.round(angles.yaw_of(velocities) / (0.5 * np.pi)).astype(int) % 4
    speed_bin = np.searchsorted(SPEED_BINS[1:-1], speeds, side="right")
    turn_bin = np.searchsorted(TURN_BINS_DEG[1:-1], np.degrees(turning), side="right")
    counts = np.zeros((len(DIRECTIONS), len(SPEED_BINS) - 1, len(TURN_BINS_DEG) - 1), dtype=int)
    np.add.at(counts, (quarter, speed_bin, turn_bin), 1)
    moving = speed_bin > 0
    return {
        "directions": list(DIRECTIONS),
        "speed_borders_m_s": list(SPEED_BINS[:-1]),
        "turn_borders_deg_s": list(TURN_BINS_DEG[1:-1]),
        "frames": counts.tolist(),
        "standing_share": round(1.0 - float(moving.mean()), 4),
        "direction_shares": {
            name: round(float((quarter[moving] == i).mean()) if moving.any() else 0.0, 4)
            for i, name in enumerate(DIRECTIONS)
        },
        "speed_m_s": _percentiles(speeds),
        "turn_deg_s": _percentiles(np.degrees(turning)),
    }


def _smooth_root_motion(database: MotionDatabase) -> tuple[Array, Array]:
    """Root velocities `(N, 2)` in root space and turning rates `(N,)`, averaged over a step of their clip."""
    poses, half = database.poses, max(1, round(0.5 * _SMOOTHING_S * database.fps))
    velocities, turning = np.empty((len(poses), 2)), np.empty(len(poses))
    for clip in database.clips:
        frames = np.arange(clip.start, clip.stop)
        before = np.maximum(frames - half, clip.start)
        after = np.minimum(frames + half, clip.stop - 1)
        seconds = np.maximum(after - before, 1) / database.fps
        way = poses.root_positions[after] - poses.root_positions[before]
        velocities[frames] = angles.turn(way, -poses.root_yaws[frames]) / seconds[:, None]
        turning[frames] = (poses.root_yaws[after] - poses.root_yaws[before]) / seconds
    return velocities, turning


def _feet(database: MotionDatabase, toes: Array) -> dict[str, Any]:
    """How much each foot is in contact, and how fast toes `(N, 2, 3)` in root space slide then."""
    poses, skate = database.poses, np.empty((len(database), 2))
    ground = angles.turn(toes[..., :2], poses.root_yaws[:, None]) + poses.root_positions[:, None]
    for clip in database.clips:
        run = slice(clip.start, clip.stop)
        skate[run] = np.linalg.norm(kinematics.velocity(ground[run], database.fps), axis=-1)
    down = poses.contacts
    left, right = down.mean(axis=0).tolist()
    return {
        "contact_share": {"left": round(left, 4), "right": round(right, 4)},
        "airborne_share": round(float((~down.any(axis=1)).mean()), 4),
        "foot_skate_cm_s": round(float(100.0 * skate[down].mean()), 3) if down.any() else None,
        "toe_height_m": _percentiles(toes[..., 2][down]) if down.any() else None,
    }


def _percentiles(values: Array) -> dict[str, float]:
    low, median, high = np.percentile(values, [5.0, 50.0, 95.0])
    return {
        "min": round(float(values.min()), 4),
        "p5": round(float(low), 4),
        "median": round(float(median), 4),
        "p95": round(float(high), 4),
        "max": round(float(values.max()), 4),
    }


def _json_or_text(text: str) -> Any:
    try:
        return parse_json(text.encode())
    except FaultError:
        return text

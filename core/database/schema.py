"""What a motion database's file holds, and the checks of everything the rest of Footwork relies on."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ..body import hierarchy
from ..body.skeleton import ARM, LEG, REQUIRED_ROLES, ROLES, SIDES
from ..bounds import (
    CLIPS,
    FARTHEST,
    FASTEST,
    FEATURE,
    FRAMES,
    HEAD_HEIGHT,
    HEIGHT_SHARE,
    JOINTS,
    LONGEST_BONE,
    MOST_TURNS,
    TEXTS,
)
from ..errors import FaultError
from ..json_text import parse_json
from .features import horizon_frames
from .motion_database import FEATURE_COUNT, FEATURE_GROUPS, HORIZONS_S
from .virtual_root import to_root_space

Arrays = dict[str, NDArray[Any]]

FORMAT = "footwork-motion-database"
SCHEMA = 2

LAYOUT: dict[str, tuple[str, tuple[int | str, ...]]] = {
    "name": ("U", ()),
    "fps": ("f8", ()),
    "head_height": ("f8", ()),
    "height_range": ("f8", (2,)),
    "tags": ("U", ("K",)),
    "provenance": ("U", ()),
    "joint_names": ("U", ("J",)),
    "joint_roles": ("U", ("J",)),
    "joint_parents": ("i4", ("J",)),
    "joint_offsets": ("f8", ("J", 3)),
    "joint_tips": ("f8", ("J", 3)),
    "clip_names": ("U", ("C",)),
    "clip_starts": ("i8", ("C",)),
    "clip_stops": ("i8", ("C",)),
    "clip_files": ("U", ("C",)),
    "clip_sha256": ("U", ("C",)),
    "clip_mirrored": ("?", ("C",)),
    "root_positions": ("f4", ("N", 2)),
    "root_yaws": ("f4", ("N",)),
    "hips_positions": ("f4", ("N", 3)),
    "rotations": ("f4", ("N", "J", 4)),
    "root_velocities": ("f4", ("N", 2)),
    "root_yaw_velocities": ("f4", ("N",)),
    "hips_velocities": ("f4", ("N", 3)),
    "angular_velocities": ("f4", ("N", "J", 3)),
    "contacts": ("?", ("N", 2)),
    "features": ("f4", ("N", FEATURE_COUNT)),
    "feature_mean": ("f8", (FEATURE_COUNT,)),
    "feature_deviation": ("f8", (FEATURE_COUNT,)),
    "feature_groups": ("U", (len(FEATURE_GROUPS),)),
    "feature_starts": ("i4", (len(FEATURE_GROUPS),)),
    "feature_horizons": ("f8", (len(HORIZONS_S),)),
    "trajectory_valid": ("?", ("N",)),
}
"""Every array beside `format`, `schema` and `producer`: kind and shape; letters are free lengths."""


_COMPARED = 1000
"""Frames whose features are compared with their poses."""
_NEAR_M = 0.02
_MOST = {"K": TEXTS, "J": JOINTS, "C": CLIPS, "N": FRAMES}
"""The letters of `LAYOUT`."""

_RENAMED = {2: {"eye_height": "head_height"}}
"""For each schema since the first: the arrays that have another name from it on, old name to new."""


def names_in(schema: int) -> dict[str, str]:
    """For each array of `LAYOUT` the name that files of a schema give it."""
    names = {name: name for name in LAYOUT}
    for renamed in (_RENAMED[number] for number in sorted(_RENAMED, reverse=True) if number > schema):
        before = {new: old for old, new in renamed.items()}
        names = {name: before.get(old, old) for name, old in names.items()}
    return names


def kind_of(name: str) -> np.dtype[Any]:
    """The type of a `LAYOUT` array in the file: little-endian wherever it is written."""
    return np.dtype(LAYOUT[name][0]).newbyteorder("<")


def most_elements(name: str) -> int:
    """How many elements a `LAYOUT` array may have, whatever the others say."""
    return math.prod(size if isinstance(size, int) else _MOST[size] for size in LAYOUT[name][1])


def check_arrays(arrays: Arrays) -> None:
    """Raise FaultError for the first thing that is wrong with arrays read from a file."""
    _check_layout(arrays)
    _check_skeleton(arrays)
    _check_clips(arrays)
    _check_values(arrays)
    _check_features(arrays)
    _check_paths(arrays)


def _check_layout(arrays: Arrays) -> None:
    """Kinds, shapes and finiteness by `LAYOUT`."""
    lengths: dict[int | str, int] = {}
    for name, (_, shape) in LAYOUT.items():
        if name not in arrays:
            raise FaultError(f"has no array {name!r}")
        array, kind = arrays[name], kind_of(name)
        if array.dtype.kind != kind.kind:
            raise FaultError(f"{name!r} holds {array.dtype} where {kind} is expected")
        sizes = tuple(lengths.get(size, size) for size in shape)
        if array.ndim != len(shape) or any(
            isinstance(size, int) and size != given for size, given in zip(sizes, array.shape, strict=True)
        ):
            raise FaultError(f"{name!r} has the shape {array.shape} where {_text(shape, sizes)} is expected")
        lengths.update(zip(shape, array.shape, strict=True))
        if kind.kind == "f" and not np.isfinite(array).all():
            raise FaultError(f"{name!r} holds numbers that are not finite")


def _text(shape: tuple[int | str, ...], sizes: tuple[int | str, ...]) -> str:
    """An expected shape for people, e.g. `(N = 120, 4)`."""
    parts = [
        f"{name} = {size}" if name != size else str(size) for name, size in zip(shape, sizes, strict=True)
    ]
    return f"({', '.join(parts)})"


def _check_skeleton(arrays: Arrays) -> None:
    parents, offsets = arrays["joint_parents"], arrays["joint_offsets"]
    roles = arrays["joint_roles"].tolist()
    count = len(parents)
    if count == 0 or parents[0] != -1 or (parents[1:] < 0).any() or (parents >= np.arange(count)).any():
        raise FaultError("'joint_parents' is no hierarchy: -1 first, then parents before their children")
    if roles[0] != "hips":
        raise FaultError(f"the first joint has the role {roles[0]!r} where 'hips' is expected")
    for role in roles:
        if role and (role not in ROLES or roles.count(role) > 1):
            raise FaultError(f"{role!r} in 'joint_roles' is unknown or there twice")
    for role in REQUIRED_ROLES:
        if role not in roles:
            raise FaultError(f"has no joint with the role {role!r}")
    for limb in (ARM, LEG):
        for side in SIDES:
            # clavicles and toes may be missing
            found = [part for part in limb if f"{part}.{side}" in roles]
            joints = [roles.index(f"{part}.{side}") for part in found]
            if any(a not in hierarchy.above(parents, b) for a, b in pairwise(joints)):
                raise FaultError(f"{', '.join(found)} ({side}) do not follow each other in 'joint_parents'")
    legs = [roles.index(f"{part}.{side}") for part in ("shin", "foot") for side in SIDES]
    if (np.linalg.norm(offsets[legs], axis=-1) < 1e-3).any():
        raise FaultError("'joint_offsets' has legs without length")


def _check_clips(arrays: Arrays) -> None:
    starts, stops = arrays["clip_starts"], arrays["clip_stops"]
    frames = len(arrays["root_yaws"])
    if len(starts) == 0 or frames == 0:
        raise FaultError("holds no clips or no frames")
    if starts[0] != 0 or stops[-1] != frames or (starts[1:] != stops[:-1]).any() or (stops <= starts).any():
        raise FaultError(f"its clip table does not cover the {frames} frames one clip after the other")


def _check_values(arrays: Arrays) -> None:
    fps, low_high = float(arrays["fps"]), arrays["height_range"]
    if not 1.0 <= fps <= 1000.0:
        raise FaultError(f"'fps' is {fps:g}")
    if not HEAD_HEIGHT[0] <= arrays["head_height"] <= HEAD_HEIGHT[1]:
        raise FaultError(f"'head_height' is {arrays['head_height']:g} m, which is no person's")
    bounds = {
        "height_range": HEIGHT_SHARE[1],
        "joint_offsets": LONGEST_BONE,
        "joint_tips": LONGEST_BONE,
        "root_positions": FARTHEST,
        "root_yaws": MOST_TURNS,
        "hips_positions": FARTHEST,
        "root_velocities": FASTEST,
        "root_yaw_velocities": 4.0 * fps,
        "hips_velocities": FASTEST,
        "angular_velocities": 4.0 * fps,
        "features": FEATURE,
        "feature_mean": FEATURE,
        "feature_deviation": FEATURE,
    }
    for name, bound in bounds.items():
        most = float(np.abs(arrays[name]).max(initial=0.0))
        if most > bound:
            raise FaultError(f"{name!r} holds {most:.4g}, more than any body's {bound:g}")
    if low_high[0] >= low_high[1]:
        raise FaultError(f"'height_range' {low_high[0]:g} to {low_high[1]:g} is empty")
    lengths = np.linalg.norm(arrays["rotations"], axis=-1)
    if (np.abs(lengths - 1.0) > 1e-3).any():
        raise FaultError("'rotations' holds quaternions that are not of unit length")
    if not _is_text_by_text(arrays["provenance"]):
        raise FaultError("'provenance' is no JSON object of texts")


def _check_features(arrays: Arrays) -> None:
    if (arrays["feature_deviation"] <= 0.0).any():
        raise FaultError("'feature_deviation' holds numbers that are not above zero")
    layout = dict(zip(arrays["feature_groups"].tolist(), arrays["feature_starts"].tolist(), strict=True))
    if layout != {name: columns.start for name, columns in FEATURE_GROUPS.items()} or not np.allclose(
        arrays["feature_horizons"], HORIZONS_S
    ):
        raise FaultError("its features are laid out in another way than here")
    last_found = np.repeat(arrays["clip_stops"], arrays["clip_stops"] - arrays["clip_starts"])
    last_found -= horizon_frames(float(arrays["fps"]))[-1]
    valid = arrays["trajectory_valid"]
    if not valid.any() or (valid & (np.arange(len(valid)) >= last_found)).any():
        raise FaultError("'trajectory_valid' holds no frame, or frames too near to a clip's end")


def _check_paths(arrays: Arrays) -> None:
    """Features and poses are of the same motion: where the root is at the first horizon, both tell."""
    frames = np.flatnonzero(arrays["trajectory_valid"])
    frames = frames[:: max(1, len(frames) // _COMPARED)]
    mean, deviation = arrays["feature_mean"][:2], arrays["feature_deviation"][:2]
    found = arrays["features"][frames, :2] * deviation + mean
    roots, yaws = arrays["root_positions"].astype(np.float64), arrays["root_yaws"].astype(np.float64)
    ahead = roots[frames + int(horizon_frames(float(arrays["fps"]))[0])] - roots[frames]
    wanted = to_root_space(ahead, yaws[frames])
    if (np.abs(found - wanted) > _NEAR_M + 1e-3 * np.abs(roots[frames])).any():
        raise FaultError("'features' are not those of its poses")


def _is_text_by_text(array: NDArray[Any]) -> bool:
    try:
        value: Any = parse_json(str(array).encode())
    except FaultError:
        return False
    return isinstance(value, dict) and all(
        isinstance(item, str) for item in cast(dict[str, Any], value).values()
    )

"""The motion database's side-car file: a `.npz` without pickles (described in docs/database-format.md)."""

from __future__ import annotations

import os
from dataclasses import replace
from typing import Any

import numpy as np

from .. import VERSION
from ..body.skeleton import Skeleton
from ..errors import FaultError, InputError
from ..files import sha256_of
from ..json_text import parse_json, to_json
from ..npz import Npz, open_npz, write_npz
from ..transaction import Transaction, write_atomically
from .motion_database import (
    FEATURE_GROUPS,
    HORIZONS_S,
    Clip,
    FeatureDatabase,
    MotionDatabase,
    PoseDatabase,
)
from .schema import FORMAT, LAYOUT, SCHEMA, Arrays, check_arrays, kind_of, most_elements, names_in

_POSES = (
    "root_positions",
    "root_yaws",
    "hips_positions",
    "rotations",
    "root_velocities",
    "root_yaw_velocities",
    "hips_velocities",
    "angular_velocities",
)


def save_database(
    path: str | os.PathLike[str], database: MotionDatabase, outputs: Transaction | None = None
) -> None:
    """Write a database, at once or in a transaction; the same database gives the same bytes.

    Raises:
        InputError: the file cannot be written.
    """
    header = {"format": FORMAT, "schema": SCHEMA, "producer": f"footwork {VERSION}"}
    arrays = {name: np.asarray(value) for name, value in header.items()} | _to_arrays(database)
    write_atomically(path, lambda file: write_npz(file, arrays), outputs)


def load_database(path: str | os.PathLike[str]) -> MotionDatabase:
    """Read a database and check all that the rest of Footwork relies on.

    Raises:
        InputError: one line that names the file, its first fault and what to do.
    """
    try:
        arrays = _read(path)
        check_arrays(arrays)
    except FaultError as fault:
        raise InputError(f"{path}: {fault}; build the database again") from None
    return replace(_from_arrays(arrays), sha256=sha256_of(path))


def _to_arrays(database: MotionDatabase) -> Arrays:
    """The arrays of `LAYOUT`, in its order and of its kinds."""
    skeleton, clips, features = database.skeleton, database.clips, database.features
    values: dict[str, Any] = {
        "name": database.name,
        "fps": database.fps,
        "head_height": database.head_height,
        "height_range": database.height_range,
        "tags": database.tags,
        "provenance": to_json(database.provenance),
        "joint_names": skeleton.names,
        "joint_roles": skeleton.roles,
        "joint_parents": skeleton.parents,
        "joint_offsets": skeleton.offsets,
        "joint_tips": skeleton.tips,
        "clip_names": [clip.name for clip in clips],
        "clip_starts": [clip.start for clip in clips],
        "clip_stops": [clip.stop for clip in clips],
        "clip_files": [clip.file for clip in clips],
        "clip_sha256": [clip.sha256 for clip in clips],
        "clip_mirrored": [clip.mirrored for clip in clips],
        **{name: getattr(database.poses, name) for name in _POSES},
        "contacts": database.poses.contacts,
        "features": features.values,
        "feature_mean": features.mean,
        "feature_deviation": features.deviation,
        "feature_groups": list(FEATURE_GROUPS),
        "feature_starts": [columns.start for columns in FEATURE_GROUPS.values()],
        "feature_horizons": HORIZONS_S,
        "trajectory_valid": features.trajectory_valid,
    }
    return {name: np.asarray(values[name], kind_of(name), "C") for name in LAYOUT}


def _read(path: str | os.PathLike[str]) -> Arrays:
    """The arrays of `LAYOUT` that are in the file, unchecked but for the header."""
    with open_npz(path) as archive:
        names = names_in(_checked_schema(path, archive))
        return {name: archive.read(old, most_elements(name)) for name, old in names.items() if old in archive}


def _checked_schema(path: str | os.PathLike[str], archive: Npz) -> int:
    """The schema of a database; raises where this is none, or of a schema that is not known here."""
    if "format" not in archive or "schema" not in archive:
        raise InputError(f"{path}: is a .npz file, but no motion database; choose another file")
    name = str(archive.read("format", 1))
    if name != FORMAT:
        raise InputError(f"{path}: is a {name[:80]!r}, no motion database; choose another file")
    schema = archive.read("schema", 1)
    if schema.shape != () or schema.dtype.kind not in "iu" or schema < 1:
        raise FaultError("its schema is no number")
    if schema > SCHEMA:
        raise InputError(
            f"{path}: comes from a newer Footwork (schema {schema}, here {SCHEMA}); update Footwork"
        )
    return int(schema)


def _from_arrays(arrays: Arrays) -> MotionDatabase:
    arrays = {name: array.astype(kind_of(name), copy=False) for name, array in arrays.items()}
    columns = ("names", "starts", "stops", "files", "sha256", "mirrored")
    rows = zip(*(arrays[f"clip_{column}"].tolist() for column in columns), strict=True)
    low, high = arrays["height_range"].tolist()
    poses = {name: arrays[name].astype(np.float64) for name in _POSES}
    return MotionDatabase(
        name=str(arrays["name"]),
        skeleton=Skeleton(
            names=tuple(arrays["joint_names"].tolist()),
            parents=arrays["joint_parents"].astype(np.intp),
            offsets=arrays["joint_offsets"],
            roles=tuple(arrays["joint_roles"].tolist()),
            tips=arrays["joint_tips"],
        ),
        fps=float(arrays["fps"]),
        clips=tuple(Clip(*row) for row in rows),
        poses=PoseDatabase(**poses, contacts=arrays["contacts"]),
        features=FeatureDatabase(
            arrays["features"],
            arrays["feature_mean"],
            arrays["feature_deviation"],
            arrays["trajectory_valid"],
        ),
        head_height=float(arrays["head_height"]),
        height_range=(low, high),
        tags=tuple(arrays["tags"].tolist()),
        provenance=parse_json(str(arrays["provenance"]).encode()),
    )

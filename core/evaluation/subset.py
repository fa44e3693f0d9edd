"""Databases cut down to a share of themselves, to see what their size is worth (paper, section 6.2)."""

from __future__ import annotations

from dataclasses import fields, replace
from itertools import pairwise
from typing import Any

import numpy as np

from ..database.features import horizon_frames, normalize_features
from ..database.motion_database import Clip, MotionDatabase, PoseDatabase
from ..errors import InputError

STRETCH_S = 10.0
"""Clips are kept or dropped in stretches of at most this length; shorter ones would mostly be ends that the
search cannot enter."""


def reduce_database(database: MotionDatabase, share: float) -> MotionDatabase:
    """The database with about `share` of its frames.

    The rule: every clip falls into equal stretches of at most ten seconds. Stretches are kept in the order of
    the binary van der Corput sequence over their place in the database (the first, the middle one, the
    quarters ...), until `share` of the frames is reached; the last one kept is cut to fit. So what is kept is
    spread over the whole database, and of two shares the smaller is part of the larger. Features are
    normalised anew over what is kept.

    Args:
        database: any.
        share: in (0, 1].

    Raises:
        InputError: so little would be left that nothing can be found in it.
    """
    if share >= 1.0:
        return database
    stretches = _stretches(database)
    left = round(share * len(database))
    kept: list[tuple[int, int, Clip]] = []
    for index in van_der_corput(len(stretches)):
        start, stop, clip = stretches[index]
        stop = min(stop, start + left)
        if stop > start:
            kept.append((start, stop, clip))
        left -= stop - start
    kept.sort(key=lambda item: item[0])
    rows = np.concatenate([np.arange(start, stop) for start, stop, _ in kept])
    clips: list[Clip] = []
    for start, stop, clip in kept:
        at = clips[-1].stop if clips else 0
        clips.append(replace(clip, start=at, stop=at + stop - start))
    horizon = int(horizon_frames(database.fps)[-1])
    ends = np.repeat([clip.stop for clip in clips], [clip.stop - clip.start for clip in clips])
    valid = np.arange(len(rows)) + horizon < ends
    if not valid.any():
        raise InputError(
            f"database {database.name!r}: {share:.0%} of its {len(database)} frames hold no clip of more than a "
            "second; give a larger one"
        )
    features = database.features
    values = features.values[rows] * features.deviation + features.mean
    columns: dict[str, Any] = {
        item.name: getattr(database.poses, item.name)[rows] for item in fields(PoseDatabase)
    }
    return replace(
        database,
        clips=tuple(clips),
        poses=PoseDatabase(**columns),
        features=normalize_features(values, valid),
    )


def _stretches(database: MotionDatabase) -> list[tuple[int, int, Clip]]:
    """First and last frame of all stretches, and the clip each is of."""
    out: list[tuple[int, int, Clip]] = []
    for clip in database.clips:
        length = clip.stop - clip.start
        pieces = max(1, int(np.ceil(length / (STRETCH_S * database.fps))))
        edges = clip.start + np.rint(np.linspace(0, length, pieces + 1)).astype(int)
        out += [(a, b, clip) for a, b in pairwise(edges.tolist())]
    return out


def van_der_corput(count: int) -> list[int]:
    """0 ... `count` - 1 in the order of their mirrored binary digits: 0, 4, 2, 6, 1, 5, 3, 7 for eight."""
    bits = max(1, (count - 1).bit_length())
    return [place for i in range(2**bits) if (place := int(f"{i:0{bits}b}"[::-1], 2)) < count]

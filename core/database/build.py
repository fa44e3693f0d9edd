"""Takes become a motion database (paper, sections 5.1 and 5.2)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import VERSION
from ..body.edit import cut, mirror, resample
from ..body.motion import Motion
from ..body.skeleton import Skeleton
from ..body.standing import standing_head_height
from ..errors import InputError
from ..jobs import Job
from ..json_text import to_json
from ..mocap.take import Take
from ..settings import DatabaseSettings, check
from .carry import carry_over
from .clips import Exclusion, check_exclusions, file_name, glitch_exclusions, kept_ranges
from .contact_edits import ContactEdit, check_contact_edits, edit_contacts, edits_of
from .contacts import detect_contacts
from .features import clip_features, horizon_frames, normalize_features
from .motion_database import Clip, MotionDatabase, PoseDatabase
from .poses import clip_poses, join_poses
from .variants import at_body_height, usual_height_range
from .virtual_root import virtual_root

Array = NDArray[np.floating[Any]]

_LEAST_VALID_FRAMES = 5
"""A clip must hold so many frames that the search can find."""


@dataclass(frozen=True, slots=True, eq=False)
class _Piece:
    """One clip on its way into the database; its clip still counts from 0."""

    clip: Clip
    poses: PoseDatabase
    features: Array
    trajectory_valid: NDArray[np.bool_]


def build_database(
    takes: Sequence[Take],
    settings: DatabaseSettings,
    *,
    name: str,
    tags: Sequence[str] = (),
    exclude: Sequence[Exclusion] = (),
    contact_edits: Sequence[ContactEdit] = (),
    skeleton: Skeleton | None = None,
) -> Job[MotionDatabase]:
    """Build a motion database.

    Takes on another skeleton than the database's are carried over by joint role, takes at another rate are
    resampled, and brought to `settings.body_height`; a height range left at its default is then the usual one of
    that height. With `settings.mirror` the mirror images follow after all clips. Stretches in which a limb is thrown as
    no limb is are left out too; the provenance has a line for each under `skipped`.

    Args:
        takes: at least one.
        settings: rate, contacts, mirror, body height, height range.
        name: shown to people.
        tags: words to find the database by.
        exclude: stretches of takes to leave out; what remains on both sides becomes clips of its own.
        contact_edits: where feet are planted or lifted, whatever is detected; sides are those of the take, in its
            mirror image the other foot's contacts change.
        skeleton: the database's, such as that of another database that a bake is to use, too; by default the
            first take's.

    Raises:
        InputError: no take, a setting out of bounds, an exclusion or a contact of an unknown take, contacts that
            contradict each other, a body height that the feet do not reach, or nothing long enough.
    """
    _check(takes, settings, name)
    check_exclusions(takes, exclude)
    check_contact_edits(takes, contact_edits)
    skeleton = skeleton or takes[0].motion.skeleton
    pieces: list[_Piece] = []
    mirrored: list[_Piece] = []
    skipped: list[str] = []
    motions: list[Motion] = []
    for i, take in enumerate(takes):
        yield 0.2 * i / len(takes), f"Skeleton of {take.name}"
        motions.append(carry_over(resample(take.motion, settings.fps), skeleton))
    standing = standing_head_height(*motions)
    for i, (take, motion) in enumerate(zip(takes, motions, strict=True)):
        yield 0.2 + 0.75 * i / len(takes), f"Features of {take.name}"
        edits = edits_of(take, contact_edits)
        wild = glitch_exclusions(take)
        skipped += [f"{item}: a limb moves as no limb does, a glitch" for item in wild]
        for clip in _clips(take, motion, [*exclude, *wild], skipped):
            part = cut(motion, clip.start, clip.stop)
            contacts = edit_contacts(detect_contacts(part, settings), edits, motion.fps, clip.start)
            part = at_body_height(part, contacts, settings.body_height, standing)
            pieces.append(_piece(clip, part, contacts, settings))
            if settings.mirror:
                image = carry_over(mirror(part), skeleton)
                mirrored.append(_piece(replace(clip, mirrored=True), image, contacts[:, ::-1], settings))
    pieces += mirrored
    if not pieces:
        raise InputError(f"database {name!r}: nothing to use: {'; '.join(skipped)}")
    yield 0.95, "Normalising features"
    features = normalize_features(
        np.concatenate([piece.features for piece in pieces]),
        np.concatenate([piece.trajectory_valid for piece in pieces]),
    )
    return MotionDatabase(
        name=name,
        skeleton=skeleton,
        fps=settings.fps,
        clips=_clip_table(pieces),
        poses=join_poses([piece.poses for piece in pieces]),
        features=features,
        head_height=standing,
        height_range=_height_range(settings),
        tags=tuple(tags),
        provenance=_provenance(takes, settings, exclude, contact_edits, skipped),
    )


def _check(takes: Sequence[Take], settings: DatabaseSettings, name: str) -> None:
    check(settings)
    if settings.height_low >= settings.height_high:
        low, high = settings.height_low, settings.height_high
        raise InputError(f"height range {low:g} to {high:g}: its end must lie above its start")
    if not takes:
        raise InputError(f"database {name!r}: no takes; give at least one mocap file")


def _height_range(settings: DatabaseSettings) -> tuple[float, float]:
    said, default = ((item.height_low, item.height_high) for item in (settings, DatabaseSettings()))
    return usual_height_range(settings.body_height) if said == default else said


def _clips(take: Take, motion: Motion, exclude: Sequence[Exclusion], skipped: list[str]) -> list[Clip]:
    """The clips of a take, numbered in its own frames; what is too short goes to `skipped`, with why."""
    least = int(horizon_frames(motion.fps)[-1]) + _LEAST_VALID_FRAMES
    ranges = kept_ranges(take, exclude, len(motion), motion.fps)
    clips: list[Clip] = []
    for start, stop in ranges:
        name = take.name
        if stop - start < len(motion):
            name += f" {start / motion.fps:.2f}-{stop / motion.fps:.2f} s"
        if stop - start < least:
            length = (stop - start) / motion.fps
            skipped.append(f"{name}: {length:.2f} s long, a clip needs {least / motion.fps:.2f} s")
        else:
            clips.append(Clip(name, start, stop, file_name(take.file), take.sha256, mirrored=False))
    if not ranges:
        skipped.append(f"{take.name}: excluded as a whole")
    return clips


def _piece(clip: Clip, motion: Motion, contacts: NDArray[np.bool_], settings: DatabaseSettings) -> _Piece:
    positions, yaws = virtual_root(motion, settings.root_smoothing)
    features, valid = clip_features(motion, positions, yaws)
    return _Piece(clip, clip_poses(motion, positions, yaws, contacts), features, valid)


def _clip_table(pieces: Sequence[_Piece]) -> tuple[Clip, ...]:
    stops = np.cumsum([len(piece.poses) for piece in pieces]).tolist()
    starts = [0, *stops[:-1]]
    return tuple(
        replace(piece.clip, start=start, stop=stop)
        for piece, start, stop in zip(pieces, starts, stops, strict=True)
    )


def _provenance(
    takes: Sequence[Take],
    settings: DatabaseSettings,
    exclude: Sequence[Exclusion],
    contact_edits: Sequence[ContactEdit],
    skipped: Sequence[str],
) -> dict[str, str]:
    """What the database was made of, as JSON texts.

    Neither times nor folders, so that the same takes give the same bytes anywhere.
    """
    sources = [
        {
            "name": take.name,
            "file": file_name(take.file),
            "sha256": take.sha256,
            "frames": len(take.motion),
            "fps": round(take.motion.fps, 6),
        }
        for take in takes
    ]
    return {
        "producer": f"footwork {VERSION}",
        "sources": to_json(sources),
        "settings": to_json(asdict(settings)),
        "excluded": to_json([str(replace(item, take=file_name(item.take))) for item in exclude]),
        "contacts": to_json([str(replace(item, take=file_name(item.take))) for item in contact_edits]),
        "skipped": to_json(list(skipped)),
    }

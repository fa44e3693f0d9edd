"""Foot contacts that are not as detected: what a person says of a take, over what its toes' speed says."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np
from numpy.typing import NDArray

from ..body.skeleton import SIDES
from ..errors import InputError
from ..mocap.take import Take
from .clips import SECONDS, names_take, parse_seconds, takes_named

_STATES = {"planted": True, "lifted": False}
_FORM = "write TAKE:FOOT:STATE:FROM-TO in seconds, for example walk:L:planted:1.2-1.65"


@dataclass(frozen=True, slots=True)
class ContactEdit:
    """A stretch of a take in which a foot is on the ground, or in the air, whatever was detected."""

    take: str
    """Name of the take, or its file with or without folders."""
    side: str
    """"L" or "R"."""
    planted: bool
    """On the ground; else in the air."""
    start: float
    """Seconds from the take's start."""
    stop: float
    """Seconds from the take's start; infinite for its end."""

    def __str__(self) -> str:
        """As `parse_contact_edit` reads it."""
        return f"{self.take}:{self.within_take}"

    @property
    def within_take(self) -> str:
        """The text without the take's name: `L:planted:1.2-1.65`."""
        state = "planted" if self.planted else "lifted"
        stop = "" if math.isinf(self.stop) else _seconds(self.stop)
        return f"{self.side}:{state}:{_seconds(self.start)}-{stop}"


def parse_contact_edit(text: str) -> ContactEdit:
    """`TAKE:FOOT:STATE:FROM-TO`, e.g. `walk:L:planted:1.2-1.65`.

    FOOT is L or R, STATE planted or lifted, FROM and TO are seconds; without FROM from the start, without TO to
    the end.

    Raises:
        InputError: the text is not of that form, or TO is not after FROM.
    """
    match = re.fullmatch(rf"(.+):\s*([^:]*?)\s*:\s*([^:]*?)\s*:\s*{SECONDS}", text)
    if match is None:
        raise InputError(f"contact {text!r}: {_FORM}")
    start, stop = parse_seconds(match[4], match[5], f"contact {text!r}", _FORM)
    if match[2] not in SIDES:
        raise InputError(f"contact {text!r}: the foot is {match[2]!r}; write L or R")
    if match[3] not in _STATES:
        raise InputError(f"contact {text!r}: the foot is {match[3]!r}; write planted or lifted")
    return ContactEdit(match[1], match[2], _STATES[match[3]], start, stop)


def check_contact_edits(takes: Sequence[Take], edits: Sequence[ContactEdit]) -> None:
    """Raise InputError for an edit that names no take or leaves those it names, or for two that contradict."""
    for edit in edits:
        named = takes_named(edit.take, takes, f"contact {str(edit)!r}")
        length = max(len(take.motion) / take.motion.fps for take in named)
        # a frame may be lost in resampling
        frame = max(1.0 / take.motion.fps for take in named)
        if edit.start >= length or length + frame < edit.stop < math.inf:
            raise InputError(
                f"contact {str(edit)!r}: the take ends at {length:.2f} s; choose a time before it, "
                "or leave TO away for its end"
            )
    for take in takes:
        for one, other in combinations(edits_of(take, edits), 2):
            start, stop = max(one.start, other.start), min(one.stop, other.stop)
            if one.side == other.side and one.planted != other.planted and start < stop:
                raise InputError(
                    f"contact {str(one)!r}: {other.within_take!r} says the opposite from {start:g} s on; "
                    "shorten one of them"
                )


def edits_of(take: Take, edits: Sequence[ContactEdit]) -> list[ContactEdit]:
    """Those of the edits that name this take."""
    return [edit for edit in edits if names_take(edit.take, take)]


def edit_contacts(
    contacts: NDArray[np.bool_],
    edits: Sequence[ContactEdit],
    fps: float,
    first: int = 0,
) -> NDArray[np.bool_]:
    """Contacts `(T, 2)` with a take's edits put over them.

    Args:
        contacts: left and right, of the take or of a part of it, at `fps`.
        edits: of this take, none contradicting another.
        fps: frames per second.
        first: the frame of the take at which `contacts` begin.
    """
    edited = contacts.copy()
    for edit in edits:
        start, stop = (_frame(seconds, fps, first, len(contacts)) for seconds in (edit.start, edit.stop))
        edited[start:stop, SIDES.index(edit.side)] = edit.planted
    return edited


def find_contact_edits(
    take: str, wanted: NDArray[np.bool_], detected: NDArray[np.bool_], fps: float
) -> list[ContactEdit]:
    """The edits that make `wanted` of `detected`, both `(T, 2)` at `fps`, in order of time.

    Every contact, or time between two, that is not as detected becomes one edit as a whole. So a small difference
    in the detection, as between two bodies, leaves no splinter at its ends.
    """
    edits: list[ContactEdit] = []
    for column, side in enumerate(SIDES):
        states = wanted[:, column]
        borders = [0, *(np.flatnonzero(states[1:] != states[:-1]) + 1).tolist(), len(states)]
        for start, stop in pairwise(borders):
            if (states[start:stop] != detected[start:stop, column]).any():
                end = math.inf if stop == len(states) else round(stop / fps, 3)
                edits.append(ContactEdit(take, side, bool(states[start]), round(start / fps, 3), end))
    return sorted(edits, key=lambda edit: (edit.start, edit.side))


def _frame(seconds: float, fps: float, first: int, count: int) -> int:
    """The frame at a time, counted from `first` and held within `count` frames."""
    return count if math.isinf(seconds) else min(max(round(seconds * fps) - first, 0), count)


def _seconds(value: float) -> str:
    return f"{value:.3f}".rstrip("0").rstrip(".")

"""Which parts of a take become clips."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import InputError
from ..mocap.checks import glitches
from ..mocap.take import Take

SECONDS = r"(\d*\.?\d*)\s*-\s*(\d*\.?\d*)\s*"
"""FROM-TO, either of which may be left away."""


@dataclass(frozen=True, slots=True)
class Exclusion:
    """A stretch of a take that is left out of the database."""

    take: str
    """Name of the take, or its file with or without folders."""
    start: float
    """Seconds from the take's start."""
    stop: float
    """Seconds from the take's start; infinite for its end."""

    def __str__(self) -> str:
        """As `parse_exclusion` reads it."""
        return f"{self.take}:{self.start:g}-{'' if math.isinf(self.stop) else f'{self.stop:g}'}"


def parse_exclusion(text: str) -> Exclusion:
    """`TAKE:FROM-TO` in seconds, e.g. `walk:0-1.5`; without FROM from the start, without TO to the end.

    Raises:
        InputError: the text is not of that form, or TO is not after FROM.
    """
    match = re.fullmatch(rf"(.+):\s*{SECONDS}", text)
    form = "write TAKE:FROM-TO in seconds, for example walk:0-1.5"
    if match is None:
        raise InputError(f"exclude {text!r}: {form}")
    return Exclusion(match[1], *parse_seconds(match[2], match[3], f"exclude {text!r}", form))


def parse_seconds(start: str, stop: str, where: str, form: str) -> tuple[float, float]:
    """The two groups of `SECONDS` as numbers: without FROM from 0, without TO to infinity.

    Raises:
        InputError: one is no number, or TO is not after FROM; it begins with `where` and ends with the right `form`.
    """
    try:
        first, last = float(start or 0.0), float(stop or math.inf)
    except ValueError:
        raise InputError(f"{where}: {form}") from None
    if last <= first:
        raise InputError(f"{where}: {last:g} s is not after {first:g} s; {form}")
    return first, last


def check_exclusions(takes: Sequence[Take], exclusions: Sequence[Exclusion]) -> None:
    """Raise InputError for an exclusion that names no take or starts past the end of those it names."""
    for exclusion in exclusions:
        named = takes_named(exclusion.take, takes, f"exclude {exclusion.take!r}")
        length = max(len(take.motion) / take.motion.fps for take in named)
        if exclusion.start >= length:
            raise InputError(
                f"exclude {exclusion.take!r}: from {exclusion.start:g} s is past its end at {length:.2f} s"
            )


def glitch_exclusions(take: Take) -> list[Exclusion]:
    """The stretches of a take in which a limb glitches (`core.mocap.checks.glitches`)."""
    bad = np.concatenate([[False], glitches(take.motion), [False]]).astype(np.int8)
    edges = np.diff(bad)
    fps = take.motion.fps
    starts, stops = np.flatnonzero(edges == 1).tolist(), np.flatnonzero(edges == -1).tolist()
    return [
        Exclusion(take.name, round(start / fps, 3), round(stop / fps, 3))
        for start, stop in zip(starts, stops, strict=True)
    ]


def kept_ranges(
    take: Take, exclusions: Sequence[Exclusion], frames: int, fps: float
) -> list[tuple[int, int]]:
    """The runs of frames `[start, stop)` of a take that no exclusion touches, in order.

    Args:
        take: whose name and file decide which exclusions count.
        exclusions: of any takes.
        frames: number of frames at `fps`.
        fps: frames per second.
    """
    kept: list[tuple[int, int]] = []
    at = 0
    for exclusion in sorted(exclusions, key=lambda item: item.start):
        if names_take(exclusion.take, take):
            start = min(round(exclusion.start * fps), frames)
            if start > at:
                kept.append((at, start))
            at = max(at, frames if math.isinf(exclusion.stop) else min(round(exclusion.stop * fps), frames))
    if at < frames:
        kept.append((at, frames))
    return kept


def file_name(path: str) -> str:
    """The last part of a path of any system: what a database tells of where its takes were."""
    return re.split(r"[\\/]", path)[-1]


def takes_named(name: str, takes: Sequence[Take], where: str) -> list[Take]:
    """The takes that go by this name; InputError that begins with `where` if none does."""
    named = [take for take in takes if names_take(name, take)]
    if not named:
        raise InputError(f"{where}: no such take; there are {', '.join(take.name for take in takes)}")
    return named


def names_take(name: str, take: Take) -> bool:
    """Whether a take goes by this name: its own, or its file with or without folders."""
    return name in (take.name, take.file, file_name(take.file))

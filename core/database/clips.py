"""Which parts of a take become clips."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

from ..errors import InputError
from ..mocap.skeleton import Take


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
    match = re.fullmatch(r"(.+):\s*(\d*\.?\d*)\s*-\s*(\d*\.?\d*)\s*", text)
    try:
        if match is None:
            raise ValueError
        start = float(match[2]) if match[2] else 0.0
        stop = float(match[3]) if match[3] else math.inf
    except ValueError:
        raise InputError(f"exclude {text!r}: write TAKE:FROM-TO in seconds, for example walk:0-1.5") from None
    if stop <= start:
        raise InputError(f"exclude {text!r}: {stop:g} s is not after {start:g} s; write TAKE:FROM-TO")
    return Exclusion(match[1], start, stop)


def check_exclusions(takes: Sequence[Take], exclusions: Sequence[Exclusion]) -> None:
    """Raise InputError for an exclusion that names no take or starts past the end of those it names."""
    for exclusion in exclusions:
        named = [take for take in takes if names_take(exclusion.take, take)]
        if not named:
            names = ", ".join(take.name for take in takes)
            raise InputError(f"exclude {exclusion.take!r}: no such take; there are {names}")
        length = max(len(take.motion) / take.motion.fps for take in named)
        if exclusion.start >= length:
            raise InputError(
                f"exclude {exclusion.take!r}: from {exclusion.start:g} s is past its end at {length:.2f} s"
            )


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


def names_take(name: str, take: Take) -> bool:
    """Whether a take goes by this name: its own, or its file with or without folders."""
    return name in (take.name, take.file, file_name(take.file))

"""What trackers did that a person should know of, and when; a part of a recording tells of its own alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .recording import Happening

NAMES = ("headset", "left controller", "right controller")
_LONG_STILL_S = 5.0
_DOUBTFUL_SHARE = 0.02
_JUMP_ADVICE = ("recentred? use one side of it only", "lost and found again, bridged")


def clip(happenings: Sequence[Happening], start: float, stop: float) -> tuple[Happening, ...]:
    """What happened from `start` to `stop` seconds, in seconds from `start`."""
    kept: list[Happening] = []
    for item in happenings:
        inside = (item.stops >= start) & (item.starts <= stop)
        if inside.any():
            starts, stops = (
                np.clip(times[inside], start, stop) - start for times in (item.starts, item.stops)
            )
            kept.append(replace(item, starts=starts, stops=stops))
    return tuple(kept)


def in_words(happenings: Sequence[Happening], length: float) -> tuple[str, ...]:
    """A line for each that lasted long enough to matter in a recording of `length` seconds."""
    lines = (_line(item, length) for item in happenings)
    return tuple(line for line in lines if line)


def _line(item: Happening, length: float) -> str:
    name, first = NAMES[item.tracker], float(item.starts[0])
    lasted = float((item.stops - item.starts).sum())
    match item.kind:
        case "jump":
            times = "once" if len(item.starts) == 1 else f"{len(item.starts)} times"
            return f"{name} jumps {times}, first at {first:.2f} s: {_JUMP_ADVICE[item.tracker > 0]}"
        case "still" if lasted > _LONG_STILL_S:
            return f"{name} stands exactly still for {lasted:.1f} s: if it slept, set its valid column to 0"
        case "lost" if lasted >= length:
            return f"{name} never tracked: its arm follows the matched motion"
        case "lost" if lasted > _DOUBTFUL_SHARE * length:
            return f"{name} not tracked for {lasted:.1f} of {length:.1f} s"
        case "laid down":
            return f"{name} lies still at {item.height:.2f} m from {first:.0f} s on: leave that out"
        case _:
            return ""

"""Times of rows: columns named so or that rise steadily, dates of any kind, seconds beside their fractions."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ..recording import Array
from .meaning import SECONDS, Understood, words_of

_CLOCK = re.compile(
    r"(?:(\d+):)?(\d{1,2}):(\d{1,2})(?:[.,:](\d+))?\s*(?:([AaPp])\.?[Mm]\.?)?\s*(?:Z|[-+]\d\d:?\d\d)?\s*$"
)
_USUAL_RATE = 72.0
_DAY_S = 86400.0
_UNITS = (1.0, 1e-3, 1e-6, 1e-7, 1e-9)
_STEPS_S = (0.002, 0.115)
"""Recorders take 9 to 500 samples a second."""
_RISING = 0.98
"""Share of the steps of a clock that do not fall."""
_WHOLE = 0.6
"""Share of the steps of a column of whole seconds that are zero."""


@dataclass(frozen=True, slots=True, eq=False)
class Sheet:
    """Rows of numbers under names."""

    names: tuple[str, ...]
    values: Array
    """`(N, C)`; NaN for what is no number."""
    texts: tuple[tuple[str, ...], ...]
    """Columns that are of no pose as texts, by index in `names`; () for the others."""
    lines: NDArray[np.intp]
    """`(N,)` line of each row in its file."""


@dataclass(frozen=True, slots=True, eq=False)
class Clock:
    """When a sheet's rows were taken."""

    times: Array
    """`(N,)` seconds from the first row on, or numbers of samples."""
    counted: bool
    """Whether they are numbers of samples."""
    told: str = ""
    """For people, where no name told which column it is."""


def clock_of(sheet: Sheet, found: Understood, file: str) -> Clock:
    """The times of a sheet's rows.

    Raises:
        InputError: a column of times holds what is no time, or times of no unit.
    """
    if found.time >= 0:
        values, dated = clock(sheet, found.time, file)
        whole = _with_fractions(sheet, found, values) if not dated else None
        if whole is not None:
            return Clock(_from_first(whole), False)
        if np.nanmax(values, initial=-np.inf) > np.nanmin(values, initial=np.inf) or len(values) < 2:
            seconds = 1.0 if dated else found.seconds or _unit(_from_first(values), file)
            return Clock(_from_first(values) * seconds, False)
    risen = _risen(sheet, found)
    if risen is not None:
        return risen
    if found.number >= 0:
        numbers = np.array([number(text) for text in sheet.texts[found.number]])
        if np.isfinite(numbers).all():
            return Clock(numbers - (numbers[0] if len(numbers) else 0.0), True)
    return Clock(np.arange(len(sheet.values), dtype=np.float64), True)


def own_times(sheet: Sheet, found: Understood, times: Array, file: str) -> dict[str, Array]:
    """Seconds `(N,)` of the trackers that have columns of times of their own, on the clock of `times`."""
    if not found.times or found.time < 0:
        return {}
    common, _ = clock(sheet, found.time, file)
    span, seconds = np.nanmax(common) - np.nanmin(common), np.nanmax(times) - np.nanmin(times)
    unit = float(seconds / span) if span > 0.0 else 1.0
    return {
        tracker: times + (clock(sheet, column, file)[0] - common) * unit
        for tracker, column in found.times.items()
    }


def clock(sheet: Sheet, column: int, file: str) -> tuple[Array, bool]:
    """What a column of times says `(N,)`, NaN where nothing, and whether these are seconds of dates.

    Raises:
        InputError: a cell is neither a number nor a time.
    """
    texts = sheet.texts[column]
    values, dated = np.empty(len(texts)), False
    for row, text in enumerate(texts):
        values[row] = number(text)
        if np.isnan(values[row]) and text.strip():
            values[row], dated = date(text), True
            if np.isnan(values[row]):
                where = f"{file}: line {int(sheet.lines[row])}"
                raise InputError(f"{where}: {text!r} is no time; correct or remove it")
    return _over_midnight(values) if dated else values, dated


def number(text: str) -> float:
    """A number with a point or a comma; NaN for any other text."""
    try:
        return float(text)
    except ValueError:
        pass
    try:
        return float(text.replace(",", ".", 1))
    except ValueError:
        return math.nan


def date(text: str) -> float:
    """Seconds of a date in ISO 8601, or else of its time of the day, which ends the text; NaN for none."""
    try:
        return datetime.fromisoformat(text.strip().replace("Z", "+00:00")).timestamp()
    except (ValueError, OverflowError, OSError):
        pass
    found = _CLOCK.search(text)
    if found is None:
        return math.nan
    hours = float(found[1] or 0)
    if found[5]:
        hours = hours % 12.0 + 12.0 * (found[5] in "pP")
    return 3600.0 * hours + 60.0 * float(found[2]) + float(f"{found[3]}.{found[4] or 0}")


def _over_midnight(values: Array) -> Array:
    """Times of the day that go on rising where a day ends."""
    steps: Array = np.diff(values, prepend=values[:1])
    return values + _DAY_S * np.cumsum(np.nan_to_num(steps) < -0.5 * _DAY_S)


def _from_first(values: Array) -> Array:
    known = values[np.isfinite(values)]
    return values - (known[0] if len(known) else 0.0)


def _unit(values: Array, file: str) -> float:
    """Seconds in the unit of times that do not say it."""
    unit = fitting(values)
    if unit:
        return unit
    raise InputError(f"{file}: its times tell no unit; call their column time_s, time_ms, time_us or time_ns")


def fitting(values: Array) -> float:
    """The unit in which times are those of a recorder; 0 for none."""
    steps: Any = np.diff(values)
    steps = steps[steps > 0.0]
    step = float(np.median(steps)) if len(steps) else 0.0
    if step == 0.0:
        return 1.0
    fitting = [unit for unit in _UNITS if _STEPS_S[0] <= step * unit <= _STEPS_S[1]]
    return min(fitting, key=lambda unit: abs(math.log(step * unit * _USUAL_RATE)), default=0.0)


def _others(sheet: Sheet, found: Understood) -> Iterator[tuple[int, Array, bool]]:
    """Columns that are of no pose, device or frame number, what they say as times, and whether as dates."""
    taken = {found.device, found.number, found.time, *found.times.values()}
    for column, texts in enumerate(sheet.texts):
        if column in taken or not texts:
            continue
        values = np.array([number(text) for text in texts])
        dated = bool(np.isnan(values).all())
        if dated:
            values = _over_midnight(np.array([date(text) for text in texts]))
        if np.isfinite(values).mean() > 0.9:
            yield column, values, dated


def _with_fractions(sheet: Sheet, found: Understood, values: Array) -> Array | None:
    """Whole seconds with the column added that counts within them; None where there is none."""
    steps: Array = np.diff(values)
    whole = len(steps) > 2 and bool((np.nan_to_num(values) == np.floor(np.nan_to_num(values))).all())
    if not whole or np.mean(steps == 0.0) < _WHOLE or found.seconds not in (0.0, 1.0):
        return None
    for _, part, dated in _others(sheet, found):
        most = float(np.nanmax(part))
        if dated or np.nanmin(part) < 0.0 or most < 1.0:
            continue
        size = next((size for size in (1e3, 1e6, 1e9) if most <= size), 0.0)
        if size and np.mean(np.diff(values + part / size) > 0.0) > _RISING:
            return values + part / size
    return None


def _risen(sheet: Sheet, found: Understood) -> Clock | None:
    """The clock in a column that rises steadily as clocks of recorders do; None where there is none."""
    best: tuple[float, Clock] | None = None
    for column, values, dated in _others(sheet, found):
        steps: Array = np.diff(values)
        counts = bool((steps == 1.0).all()) and not dated
        if len(steps) < 3 or counts or np.mean(steps >= 0.0) < _RISING or np.mean(steps > 0.0) < 0.2:
            continue
        named = next(
            (SECONDS[word] for word in reversed(words_of(sheet.names[column])) if word in SECONDS), 0.0
        )
        unit = 1.0 if dated else named or fitting(values)
        if unit:
            told = f"column {sheet.names[column]!r}, which rises steadily"
            share = float(np.mean(steps > 0.0)) + (1.0 if named or dated else 0.0)
            if best is None or share > best[0]:
                best = share, Clock(_from_first(values) * unit, False, told)
    return best[1] if best else None

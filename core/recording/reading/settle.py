"""Which of all readings of a recording shows a person: stated ones are checked, open ones are chosen.

A format may say what its axes, units and rotations are. What it says is believed as long as it shows a person; else
the reading that does is taken, and a doubt says so. What it leaves open is chosen by the same scores, and asked for
where two readings come out alike.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ...errors import InputError
from ...maths import quat
from ..raw import RawRecording, Reading
from ..recording import Array
from .answers import NO_ANSWERS, Answers
from .apply import applied
from .mishaps import coarse, one_clock, unswapped
from .plausibility import Figures, Moments, in_world, measure, moving, take_moments
from .rotations import KINDS, kind_of, to_quaternions
from .scores import COMMON, ORDERS, UNITS, Candidate, Seen, Span, best_unit, score, see, up_axis, worlds

_CLEAR = 3.0
"""Points by which the chosen reading must be ahead of the next one that shows something else."""
_RIVAL = 2.0
"""Points by which the movement must speak against what a file states to be worth a doubt: in sound recordings 0.7 at
most, with axes or rotations changed 2.5 to 23."""
_BETTER = 0.5
"""Points by which other rotations must fit the movement better to be worth a doubt."""
_BELIEF = {"axes": 6.0, "rotation": 5.0, "unit": 2.0, "sides": 4.0, "hands": 4.0}
"""Points against a reading other than what is stated or usual."""
_FLOOR = (0.9, 2.2)
"""Metres between which a headset is over a floor; one that is told from where it starts is near 0."""
_MOST_RADIANS = 7.0
"""Angles that are all smaller than this are radians."""
_START = 0.5
"""Metres within which a headset stays that is told from where it starts."""
_UNMOVED = "the headset stays at one point all the time: it was not worn, or not tracked"
_SAME = 2.0
"""Degrees and centimetres within which two readings show the same."""


def settle(raw: RawRecording, file: str, answers: Answers = NO_ANSWERS) -> RawRecording:
    """The recording in Blender's axes and metres, read as a person.

    `found` gets an entry "reading" where something was chosen, `doubts` a line for each thing that is not as stated.

    Raises:
        InputError: a rate or an axis has to be told; or no reading shows a person, without `force`.
    """
    answers.check()
    raw = _timed(raw, file, answers)
    stated = _answered(raw, answers)
    moments = take_moments(raw)
    if moments is None:
        return applied(raw, stated)
    if not moving(moments)[0]:
        if not answers.force and not {"axes", "rotation"} <= raw.stated | _said(answers):
            raise InputError(f"{file}: {_UNMOVED}; record it again, or use --force")
        return replace(applied(raw, stated), doubts=(*raw.doubts, _UNMOVED))
    search = _Search(raw, moments, stated, answers)
    given = search.candidate(stated)
    settled = raw.stated | _said(answers)
    if {"axes", "rotation"} <= settled and (answers.force or not search.faults(given)):
        doubts = search.faults(given) or (
            () if _said(answers) & {"axes", "rotation"} else search.rivals(given)
        )
        return _told(raw, given, doubts, answers)
    ranked = search.ranked(settled)
    best = ranked[0]
    if search.faults(best) and {"axes", "rotation"} <= settled:
        return _told(raw, given, search.faults(given), answers, file)
    left = search.faults(best)
    if left and not answers.force:
        raise InputError(
            f"{file}: no reading of it shows a person: {left[0]}; give --axes, --unit and --rotation, or --force"
        )
    alike = () if {"axes", "rotation"} <= settled else _alike(ranked, search, file)
    return _told(raw, best, (*_changes(given, best, search, settled), *alike), answers)


def faults(seen: Seen, floor: str) -> list[str]:
    """What in a reading no person does, the worst first.

    Args:
        seen: what the reading shows.
        floor: whether heights are above the floor: "yes", "no", or "open" where they may be from the start, too.
    """
    out: list[str] = []
    if seen.upright < 0.45:
        out.append(f"the head is not upright (its up axis points up by {seen.upright:.2f})")
    if not math.isnan(seen.ahead) and seen.ahead < 0.45:
        out.append(f"hands are ahead of the head only {seen.ahead:.0%} of the time")
    if not math.isnan(seen.left) and seen.left < 0.4:
        out.append(f"the left hand is on the left only {seen.left:.0%} of the time")
    started = floor == "open" and abs(seen.height) < _START
    if floor != "no" and not 0.55 <= seen.height <= 2.4 and not started:
        out.append(f"the headset is at {seen.height:.2f} m")
    if not math.isnan(seen.reach) and seen.reach < 0.6:
        out.append(f"hands are within reach only {seen.reach:.0%} of the time")
    return out


@dataclass(frozen=True, slots=True, eq=False)
class _Search:
    """All readings of one recording."""

    raw: RawRecording
    moments: Moments
    stated: Reading
    answers: Answers

    def candidate(self, reading: Reading) -> Candidate:
        """One reading, judged."""
        figures = measure(self.moments, reading.rotation, reading.hands)
        return self._judged(figures, see(figures, self._span(reading), reading), reading, frozenset(_BELIEF))

    @property
    def floor(self) -> str:
        """As for `faults`."""
        # who tells the eye height says that the floor is somewhere else
        if not self.raw.on_floor or self.answers.eye_height is not None:
            return "no"
        return "yes" if "origin" in self.raw.stated else "open"

    def faults(self, candidate: Candidate) -> list[str]:
        """What in a reading no person does."""
        return faults(candidate.seen, self.floor)

    def ranked(self, settled: frozenset[str]) -> list[Candidate]:
        """Every reading, the likeliest first; hands told from the head only where no other shows a person."""
        ranked: list[Candidate] = []
        for hands in (("world",), self._hands()):
            ranked = self._listed(settled, self._rotations(), hands)
            if not self.faults(ranked[0]):
                break
        return ranked

    def rivals(self, given: Candidate) -> tuple[str, ...]:
        """A doubt where the movement alone fits other axes, or rotations the other way round, clearly better."""
        stated, best = given.reading, given
        own = given.score + self.belief(stated, frozenset(_BELIEF))
        span, top = self._span(stated), own + _RIVAL
        axes = dict.fromkeys((stated.axes, *COMMON, *map(_mirrored, COMMON)))
        for rotation in (stated.rotation, f"{stated.rotation}-inverse"):
            if rotation not in KINDS[kind_of(stated.rotation)]:
                continue
            figures = measure(self.moments, rotation, stated.hands)
            for name in axes:
                reading = replace(stated, axes=name, devices="", rotation=rotation)
                seen = see(figures, span, reading)
                points = score(seen, figures, reading.metres)
                if reading != stated and points > top:
                    best, top = Candidate(reading, seen, points), points
        if best is given:
            return ()
        return (
            f"the movement fits {_differing(best.reading, stated)} better than what the file states: check it",
        )

    def _listed(
        self, settled: frozenset[str], rotations: tuple[str, ...], placings: tuple[str, ...]
    ) -> list[Candidate]:
        out: list[Candidate] = []
        for rotation, hands in itertools.product(rotations, placings):
            base = replace(self.stated, rotation=rotation, hands=hands)
            figures, span = measure(self.moments, rotation, hands), self._span(base)
            metres = {
                up: self._unit(span, up, "unit" in settled) for up in itertools.product(range(3), (1.0, -1.0))
            }
            for axes, devices in self._worlds(settled):
                reading = replace(
                    base, axes=axes, devices=devices, metres=metres[up_axis(axes)], swapped=False
                )
                seen = see(figures, span, reading)
                for swapped in (True,) if self.answers.swap_hands else (False, True):
                    reading = replace(reading, swapped=swapped)
                    left = 1.0 - seen.left if swapped else seen.left
                    out.append(self._judged(figures, replace(seen, left=left), reading, settled))
        return sorted(out, key=lambda candidate: -candidate.score)

    def _judged(self, figures: Figures, seen: Seen, reading: Reading, settled: frozenset[str]) -> Candidate:
        points = score(seen, figures, reading.metres) - self.belief(reading, settled)
        return Candidate(reading, seen, points)

    def _unit(self, span: Span, up: tuple[int, float], stated: bool) -> float:
        if self.answers.unit:
            return self.stated.metres
        units = tuple(dict.fromkeys((self.stated.metres, *UNITS.values())))
        return best_unit(span, up, self.stated.metres, units, 2.0 if stated else 0.5)

    def belief(self, reading: Reading, settled: frozenset[str]) -> float:
        """Points against what is not stated, or where nothing is, not usual."""
        stated, total = self.stated, 0.0
        if "axes" in settled:
            total += _BELIEF["axes"] * ((reading.axes, reading.devices) != (stated.axes, stated.devices))
        else:
            # no program has an axis that points down, but for images
            total += 0.0 if reading.axes in COMMON else 5.0 if "D" in reading.axes else 2.5
            total += 1.0 if reading.devices not in ("", reading.axes) else 0.0
        if "rotation" in settled:
            total += _BELIEF["rotation"] * (reading.rotation != stated.rotation)
        else:
            total += _unusual(reading, stated)
        if reading.rotation != stated.rotation:
            total += 2.0 * (reading.rotation.startswith("vector") or reading.rotation.endswith("inverse"))
        total += _BELIEF["unit"] * ("unit" in settled and reading.metres != stated.metres)
        total += _BELIEF["sides"] * (reading.swapped != stated.swapped)
        return total + _BELIEF["hands"] * (reading.hands != stated.hands)

    def _rotations(self) -> tuple[str, ...]:
        if self.answers.rotation:
            return (self.stated.rotation,)
        kind = kind_of(self.stated.rotation)
        if kind not in ("euler", "rotator"):
            return KINDS[kind]
        # no recording stays within six degrees
        known = [values[np.isfinite(values)] for values in self.moments.values]
        most = max((float(np.abs(values).max()) for values in known if values.size), default=0.0)
        unit = "radians" if most < _MOST_RADIANS else "degrees"
        return tuple(name for name in KINDS[kind] if name.endswith(unit))

    def _hands(self) -> tuple[str, ...]:
        return ("world", "offset", "local") if self.moments.known[:, 1:].any() else ("world",)

    def _worlds(self, settled: frozenset[str]) -> Iterator[tuple[str, str]]:
        if self.answers.axes:
            yield self.stated.axes, self.stated.devices
            return
        up = "XYZ".find(self.answers.up) if self.answers.up else -1
        for axes, devices in worlds():
            if up < 0 or axes[up] in "UD":
                yield axes, devices
        if (self.stated.devices, "axes" in settled) != ("", False):
            yield self.stated.axes, self.stated.devices

    def _span(self, reading: Reading) -> Span:
        turns = [to_quaternions(values, reading.rotation) for values in self.moments.values]
        places, _ = in_world(self.moments.positions, turns, reading.hands)
        head, known = places[0, :, 0], self.moments.known
        reaches = [np.linalg.norm(places[0, known[:, i], i] - head[known[:, i]], axis=-1) for i in (1, 2)]
        low, high = np.percentile(head, [5, 95], axis=0)
        return Span(np.stack([low, high], axis=-1), np.concatenate(reaches))


def _unusual(reading: Reading, stated: Reading) -> float:
    """Points against a way of writing rotations that nothing states, by the axes that go with it."""
    order = reading.rotation.partition("-")[0]
    usual = ORDERS.get(reading.axes, ())
    if kind_of(stated.rotation) not in ("euler", "rotator"):
        return 0.5 * (reading.rotation != stated.rotation)
    return 0.0 if order in (*usual[:1], *usual[-1:]) else 0.7 if order in usual else 1.5


def _said(answers: Answers) -> frozenset[str]:
    """What a person has answered."""
    said = {
        "axes": answers.axes,
        "unit": answers.unit,
        "rotation": answers.rotation,
        "sides": answers.swap_hands,
    }
    return frozenset(name for name, value in said.items() if value)


def _timed(raw: RawRecording, file: str, answers: Answers) -> RawRecording:
    """The recording with times in seconds that run on."""
    if not raw.counted:
        return one_clock(raw)
    if answers.rate is None:
        raise InputError(f"{file}: frames without times; give their number per second, such as --rate 72")
    return replace(
        raw,
        counted=False,
        tracks=tuple(replace(track, times=track.times / answers.rate) for track in raw.tracks),
        extra=tuple(
            replace(item, track=replace(item.track, times=item.track.times / answers.rate))
            for item in raw.extra
        ),
    )


def _answered(raw: RawRecording, answers: Answers) -> Reading:
    """The reading that the file states, with what a person says otherwise."""
    reading = raw.reading
    if answers.rotation and kind_of(answers.rotation) != kind_of(reading.rotation):
        raise InputError(
            f"--rotation {answers.rotation}: the file has {kind_of(reading.rotation)}s; give one of those"
        )
    return replace(
        reading,
        axes=answers.axes or reading.axes,
        devices="" if answers.axes else reading.devices,
        metres=UNITS[answers.unit] if answers.unit else reading.metres,
        rotation=answers.rotation or reading.rotation,
        swapped=answers.swap_hands,
    )


def _shown(search: _Search, reading: Reading) -> Array:
    """Some moments as a reading shows them, `(N, 3, 7)`, from the first one's place and heading."""
    raw = search.raw
    picked = [
        replace(
            track,
            times=search.moments.seconds,
            positions=search.moments.positions[0, :, i],
            rotations=search.moments.values[i][0],
            valid=search.moments.known[:, i],
        )
        for i, track in enumerate(raw.tracks)
    ]
    tracks = applied(replace(raw, tracks=(picked[0], picked[1], picked[2])), reading).tracks
    positions = np.stack([track.positions for track in tracks], axis=1)
    rotations = np.stack([quat.normalize(np.nan_to_num(track.rotations)) for track in tracks], axis=1)
    back = quat.from_yaw(-quat.heading(rotations[:1, :1]))
    positions = quat.rotate(
        np.broadcast_to(back, rotations.shape), positions - positions[:1, :1] * (1.0, 1.0, 0.0)
    )
    return np.concatenate(
        [positions, quat.multiply(np.broadcast_to(back, rotations.shape), rotations)], axis=-1
    )


def _alike(ranked: list[Candidate], search: _Search, file: str) -> tuple[str, ...]:
    """A doubt where the next reading that shows something else is about as likely; InputError where axes are."""
    best, shown = ranked[0], _shown(search, ranked[0].reading)
    for other in ranked[1:]:
        if other.score < best.score - _CLEAR:
            break
        now = _shown(search, other.reading)
        apart = 100.0 * np.linalg.norm(now[..., :3] - shown[..., :3], axis=-1)
        turned = np.degrees(
            2.0 * np.arccos(np.clip(np.abs((now[..., 3:] * shown[..., 3:]).sum(-1)), 0.0, 1.0))
        )
        known = search.moments.known
        if np.median(apart[known]) <= _SAME and np.median(turned[known]) <= _SAME:
            continue
        old, new = best.reading, other.reading
        if old.rotation != new.rotation and old.axes == new.axes:
            # orders of angles differ little while heads are upright
            return (
                f"rotations are read as {old.rotation}; {new.rotation} fits nearly as well: --rotation says which",
            )
        raise InputError(
            f"{file}: it fits {_differing(old, new)} and {_differing(new, old)} alike; say which"
        )
    return _moving_better(ranked, search)


def _moving_better(ranked: list[Candidate], search: _Search) -> tuple[str, ...]:
    """A doubt where the movement alone, without any belief in names, speaks for other rotations."""
    settled = search.raw.stated | _said(search.answers)

    def moving(candidate: Candidate) -> float:
        return candidate.score + search.belief(candidate.reading, settled)

    best = ranked[0]
    if "D" in best.reading.axes and "axes" not in settled:
        return (f"axes are read as {best.reading.axes}, which no known program writes: check them",)
    other = max((c for c in ranked if c.reading.axes == best.reading.axes), key=moving)
    if other.reading.rotation == best.reading.rotation or moving(other) < moving(best) + _BETTER:
        return ()
    return (
        f"rotations are read as {best.reading.rotation}, though the movement fits {other.reading.rotation} better: "
        "--rotation says which",
    )


def _differing(reading: Reading, other: Reading) -> str:
    """What a reading has that another has not, as options."""
    parts = [
        f"--axes {reading.axes}" if reading.axes != other.axes else "",
        f"--rotation {reading.rotation}" if reading.rotation != other.rotation else "",
        "--swap-hands" if reading.swapped and not other.swapped else "",
        f"hands in the {reading.hands}" if reading.hands != other.hands else "",
    ]
    return " ".join(part for part in parts if part) or f"--axes {reading.axes}"


def _axes_named(reading: Reading) -> str:
    axes = reading.axes
    return f"{axes} ({COMMON[axes]})" if axes in COMMON else axes


def _mirrored(axes: str) -> str:
    return axes.translate(str.maketrans("RL", "LR"))


def _unit_named(metres: float) -> str:
    return next((name for name, value in UNITS.items() if value == metres), f"{metres:g} m")


def _changes(given: Candidate, best: Candidate, search: _Search, settled: frozenset[str]) -> tuple[str, ...]:
    """What of the stated reading the chosen one contradicts, and why, a line each."""
    old, new = given.reading, best.reading
    parts: list[str] = []
    if "axes" in settled and (old.axes, old.devices) != (new.axes, new.devices):
        parts.append(f"axes {_axes_named(new)} in place of {_axes_named(old)}")
    if "unit" in settled and old.metres != new.metres:
        parts.append(f"unit {_unit_named(new.metres)} in place of {_unit_named(old.metres)}")
    if "rotation" in settled and old.rotation != new.rotation:
        parts.append(f"rotations {new.rotation} in place of {old.rotation}")
    if old.swapped != new.swapped:
        parts.append(
            f"left and right hand swapped (if they are right, it is mirrored: --axes {_mirrored(new.axes)})"
        )
    if old.hands != new.hands:
        parts.append("hands told from the head" + (", in its turned axes" if new.hands == "local" else ""))
    if not parts:
        return ()
    why = search.faults(given)
    because = f": otherwise {why[0]}" if why else ", which fits better"
    return (f"read with {', '.join(parts)}{because}",)


def _told(
    raw: RawRecording,
    chosen: Candidate,
    doubts: tuple[str, ...] | list[str],
    answers: Answers,
    file: str = "",
) -> RawRecording:
    """The recording as chosen, with what was chosen and how clear that was."""
    lines = (
        tuple(doubts)
        if not file
        else tuple(f"{doubt}: check axes, unit, rotations and sides" for doubt in doubts)
    )
    grounded = raw.on_floor and answers.eye_height is None
    if file and doubts and not answers.force and _is_absurd(chosen.seen, grounded):
        raise InputError(f"{file}: no reading of it shows a person: {doubts[0]}; correct it, or use --force")
    reading, seen = chosen.reading, chosen.seen
    parts = [_axes_named(reading), _unit_named(reading.metres), reading.rotation]
    if not math.isnan(seen.ahead):
        parts.append(f"hands ahead {seen.ahead:.0%} of the time")
    read, swaps = unswapped(applied(raw, reading))
    on_floor = raw.on_floor
    if not on_floor and _FLOOR[0] <= seen.height <= _FLOOR[1]:
        on_floor = True
        lines = (
            *lines,
            f"heights are taken from the floor, not from the start: the headset is at {seen.height:.2f} m",
        )
    elif on_floor and abs(seen.height) < _START and "origin" not in raw.stated:
        on_floor = False
    return replace(
        read,
        found={**raw.found, "reading": ", ".join(parts)},
        doubts=(*raw.doubts, *coarse(raw), *lines, *swaps),
        on_floor=on_floor,
    )


def _is_absurd(seen: Seen, on_floor: bool) -> bool:
    """Whether a reading cannot even be an odd person."""
    return seen.upright < -0.3 or (on_floor and (seen.height > 3.0 or seen.height < -2.0))

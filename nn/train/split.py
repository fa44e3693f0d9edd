"""Which samples a training learns from and which it is measured on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...core.errors import InputError
from ...core.mocap.take import Take
from ..inputs import RATE
from ..settings import TrainSettings
from .samples import Sample, samples_of


@dataclass(frozen=True, slots=True, eq=False)
class Material:
    """What a training works on."""

    training: list[Sample]
    testing: list[Sample]
    left_out: list[str]
    """A line for each stretch of a take that is fit for neither."""


def split(takes: Sequence[Take], held_out: Sequence[Take], settings: TrainSettings) -> Material:
    """Samples to learn from and to measure on: whole takes, or the end of a single one.

    Args:
        takes: what to learn from.
        held_out: takes to measure on; where there are none, the settings' share of `takes`.
        settings: that share, the seed that draws it, and the kind, which says how long a sample must be.

    Raises:
        InputError: too little is left to learn from.
    """
    samples, notes = samples_of(takes)
    if held_out:
        testing, more = samples_of(held_out)
        return Material(_long_enough(samples, settings), testing, notes + more)
    if len({sample.take for sample in samples}) < 2:
        halves = [_cut(sample, 1.0 - settings.held_out) for sample in samples]
        return Material(_long_enough([a for a, _ in halves], settings), [b for _, b in halves], notes)
    chosen = _drawn(samples, settings)
    training = [sample for sample in samples if sample.take not in chosen]
    return Material(_long_enough(training, settings), [s for s in samples if s.take in chosen], notes)


def _drawn(samples: Sequence[Sample], settings: TrainSettings) -> set[str]:
    """Names of the takes that are held out, one at least stays to learn from."""
    names = sorted({sample.take for sample in samples})
    order = np.random.default_rng(settings.seed).permutation(len(names))
    lengths = {name: sum(len(s) for s in samples if s.take == name) for name in names}
    wanted, chosen = settings.held_out * sum(lengths.values()), set[str]()
    for index in map(int, order[:-1]):
        if wanted <= 0:
            break
        chosen.add(names[index])
        wanted -= lengths[names[index]]
    return chosen


def _long_enough(samples: list[Sample], settings: TrainSettings) -> list[Sample]:
    least = settings.iterations + 2 if settings.kind == "paper" else 2
    kept = [sample for sample in samples if len(sample) >= least]
    if sum(len(sample) for sample in kept) < 10 * RATE:
        raise InputError("the takes hold less than ten seconds fit to learn from; give more or longer takes")
    return kept


def _cut(sample: Sample, share: float) -> tuple[Sample, Sample]:
    at = int(len(sample) * share)
    first, second = (
        replace(sample, positions=sample.positions[s], rotations=sample.rotations[s], yaws=sample.yaws[s])
        for s in (slice(None, at), slice(at, None))
    )
    return first, second

"""Limits on metrics, for machines that have to say yes or no."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from ..errors import InputError
from ..measure.catalogue import METRICS
from ..measure.metric import STATISTICS, get

_COMPARE: dict[str, Callable[[float, float], bool]] = {
    ">": operator.gt,
    ">=": operator.ge,
    "<": operator.lt,
    "<=": operator.le,
    "==": operator.eq,
    "!=": operator.ne,
}
_FORM = re.compile(r"\s*([a-z0-9_.]+)\s*(>=|<=|==|!=|>|<)\s*([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)\s*")


@dataclass(frozen=True, slots=True)
class Limit:
    """A condition under which an evaluation has failed."""

    text: str
    path: str
    compare: str
    bound: float

    def failure(self, metrics: Mapping[str, Any]) -> str | None:
        """What is wrong with a report's `metrics`, in words; None where they are within the limit.

        What was not measured has failed: a limit that nothing can pass would say yes to everything.
        """
        value = get(metrics, self.path)
        if value is None:
            return f"{self.text}: {self.path} was not measured here"
        if _COMPARE[self.compare](value, self.bound):
            return f"{self.text}: it is {value:.4g}"
        return None


def parse_limit(text: str) -> Limit:
    """A limit as it is written, e.g. `foot_skate_cm_s.mean > 2`.

    Raises:
        InputError: the text is no comparison of a known metric's statistic with a number.
    """
    where = f"--fail-if {text!r}"
    match = _FORM.fullmatch(text)
    try:
        if match is None:
            raise ValueError
        path, compare, bound = match[1], match[2], float(match[3])
    except ValueError:
        raise InputError(
            f'{where}: write METRIC COMPARISON NUMBER, as in "foot_skate_cm_s.mean > 2"'
        ) from None
    _check_path(where, path)
    return Limit(text, path, compare, bound)


def _check_path(where: str, path: str) -> None:
    name, *rest = path.split(".")
    metric = METRICS.get(name.removesuffix("_floor")) or METRICS.get(name)
    if metric is None:
        raise InputError(f"{where}: there is no metric {name!r}; there are {', '.join(METRICS)}")
    if metric.kind != "distribution":
        if rest:
            raise InputError(f"{where}: {name} is a single number; leave out .{'.'.join(rest)}")
        return
    if rest[:1] == ["floor"]:
        rest = rest[1:]
    if len(rest) != 1 or rest[0] not in STATISTICS:
        raise InputError(f"{where}: say which of {', '.join(STATISTICS)}, as in {name}.mean")


def failures(metrics: Mapping[str, Any], limits: list[Limit]) -> list[str]:
    """All that is wrong, a line each."""
    return [line for limit in limits if (line := limit.failure(metrics)) is not None]

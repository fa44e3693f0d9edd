"""Long work as generators: each step yields how far it is, the end returns the result.

A modal operator takes a few steps per timer tick; scripts and the command line run them straight through.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import TypeVar

Result = TypeVar("Result")
Progress = tuple[float, str]
"""Fraction in [0, 1] and a short message in the user's words."""
Job = Generator[Progress, None, Result]


def run(job: Job[Result], report: Callable[[float, str], None] | None = None) -> Result:
    """Run a job to its end and return its result, telling `report` of each step."""
    while True:
        try:
            fraction, message = next(job)
        except StopIteration as end:
            return end.value
        if report is not None:
            report(fraction, message)


def part(job: Job[Result], start: float, end: float) -> Job[Result]:
    """Run `job` as the stretch from `start` to `end` of a longer one."""
    while True:
        try:
            fraction, message = next(job)
        except StopIteration as stop:
            return stop.value
        yield start + (end - start) * fraction, message

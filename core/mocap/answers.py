"""What a person says about a take that its file does not, or says wrongly."""

from __future__ import annotations

from dataclasses import dataclass

from ..bounds import TAKE_RATE
from ..errors import InputError
from .raw_body import UNITS

STATED_UNITS = {**UNITS, "ft": 0.3048}
"""Units that can be stated, in metres: those that are guessed, and feet."""


@dataclass(frozen=True, slots=True)
class TakeAnswers:
    """Answers to what the reader of a take may ask; what is empty, the take is asked itself."""

    unit: str = ""
    """Of lengths, one of `STATED_UNITS`."""
    up: str = ""
    """"X", "Y" or "Z", the axis that points up."""
    rate: float | None = None
    """Frames per second, in place of the file's."""
    strict: bool = False
    """Whether doubts are errors."""

    def check(self) -> None:
        """Raise InputError for an answer that cannot be one."""
        if self.unit and self.unit not in STATED_UNITS:
            raise InputError(f"--unit {self.unit}: of takes give one of {', '.join(STATED_UNITS)}")
        if self.up and self.up not in ("X", "Y", "Z"):
            raise InputError(f"--up {self.up}: give X, Y or Z")
        if self.rate is not None and not TAKE_RATE[0] <= self.rate <= TAKE_RATE[1]:
            raise InputError(f"--rate {self.rate:g}: of takes give frames per second, such as 30")


NO_ANSWERS = TakeAnswers()

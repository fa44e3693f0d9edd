"""What a person says about a recording that the recording itself does not, or says wrongly."""

from __future__ import annotations

from dataclasses import dataclass

from ...bounds import EYE_HEIGHT, RECORDING_RATE
from ...errors import InputError
from ..mounts import FITTED, shape_of
from ..raw import DIRECTIONS
from .rotations import KINDS
from .scores import UNITS

_PAIRS = ("RL", "UD", "FB")
ROTATIONS = tuple(dict.fromkeys(name for names in KINDS.values() for name in names))
"""Every way of writing rotations."""


@dataclass(frozen=True, slots=True)
class Answers:
    """Answers to what a reader may ask; what is empty, the recording is asked itself."""

    axes: str = ""
    """Where x, y and z point: three of R L U D F B."""
    unit: str = ""
    """Of lengths, one of `UNITS`."""
    up: str = ""
    """"X", "Y" or "Z", the axis that points up."""
    rate: float | None = None
    """Samples per second, for files without times."""
    rotation: str = ""
    """One of `ROTATIONS`."""
    swap_hands: bool = False
    """Whether left and right change places."""
    eye_height: float | None = None
    """Height of the headset in metres when its wearer stands at ease."""
    mounts: str = ""
    """How devices sit: one of `mounts.SHAPES`, `mounts.FITTED`, or four numbers as in `mounts.shape_of`."""
    strict: bool = False
    """Whether doubts are errors."""
    force: bool = False
    """Whether to go on with what can be no person, read as it is stated."""
    auto_trim: bool = False
    """Whether to cut what is no play off both ends."""

    def check(self) -> None:
        """Raise InputError for an answer that cannot be one."""
        axes = self.axes
        if axes and not is_axes(axes):
            raise InputError(
                f"--axes {axes}: say where x, y and z point, one each of R or L, U or D, F or B: RUB or RUF"
            )
        if self.unit and self.unit not in UNITS:
            raise InputError(f"--unit {self.unit}: give one of {', '.join(UNITS)}")
        if self.up and self.up not in "XYZ":
            raise InputError(f"--up {self.up}: give X, Y or Z")
        if self.up and axes and axes["XYZ".index(self.up)] not in "UD":
            raise InputError(f"--up {self.up}: --axes {axes} says otherwise; give one of them")
        if self.rate is not None and not RECORDING_RATE[0] <= self.rate <= RECORDING_RATE[1]:
            raise InputError(f"--rate {self.rate:g}: give samples per second, such as 72")
        if self.rotation and self.rotation not in ROTATIONS:
            raise InputError(f"--rotation {self.rotation}: give one of {', '.join(ROTATIONS[:10])} ...")
        if self.mounts not in ("", FITTED):
            try:
                shape_of(self.mounts)
            except ValueError as error:
                raise InputError(f"--mounts {self.mounts}: {error}") from None
        height = self.eye_height
        if height is not None and not EYE_HEIGHT[0] <= height <= EYE_HEIGHT[1]:
            raise InputError(f"eye height {height:g} m is no person's; give metres, such as 1.65")


NO_ANSWERS = Answers()


def is_axes(text: str) -> bool:
    """Whether a text names three axes that stand upright on one another."""
    return (
        len(text) == 3
        and all(letter in DIRECTIONS for letter in text)
        and all(sum(letter in text for letter in pair) == 1 for pair in _PAIRS)
    )

"""Flags by which a person says of a recording or a take what its file does not, or says wrongly."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..core.mocap.answers import TakeAnswers
    from ..core.recording.reading.answers import Answers


def add_take_answers(parser: argparse.ArgumentParser) -> None:
    """Add the flags to a verb that reads takes."""
    _add_shared(parser.add_argument_group("how to read takes (default: as the file and its movement tell)"))


def add_answers(parser: argparse.ArgumentParser, what: str = "recordings") -> None:
    """Add the flags to a verb that reads recordings, or takes as well: `what` says which."""
    group = parser.add_argument_group(f"how to read {what} (default: as the file and its movement tell)")
    _add_shared(group)
    group.add_argument(
        "--axes",
        default="",
        metavar="XYZ",
        help="where x, y and z point: RUB (OpenXR), RUF (Unity), RFU (Blender)",
    )
    group.add_argument(
        "--rotation",
        default="",
        metavar="R",
        help="how rotations are written: wxyz, xyzw, YXZ-degrees, matrix ...",
    )
    group.add_argument("--swap-hands", action="store_true", help="left and right controller change places")
    group.add_argument("--eye-height", type=float, metavar="M", help="standing eye height, m")
    group.add_argument(
        "--mounts",
        default="",
        metavar="M",
        help="how devices sit: vive-wands, quest-touch, index, wmr, pico, hands, fitted, or AHEAD,ABOVE,REACH,DEGREES",
    )
    group.add_argument("--force", action="store_true", help="go on with what can be no person")
    group.add_argument(
        "--auto-trim", action="store_true", help="leave out what follows the headset's being laid down"
    )


def _add_shared(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--unit", default="", metavar="U", help="of lengths: m, cm, mm, ft or in; of takes dm and CMU as well"
    )
    group.add_argument("--up", default="", metavar="X|Y|Z", help="the axis that points up")
    group.add_argument(
        "--rate",
        type=float,
        metavar="N",
        help="samples per second of recordings without times, frames per second of takes",
    )
    group.add_argument("--strict", action="store_true", help="doubts about what is read are errors")


def read_take_answers(options: argparse.Namespace) -> TakeAnswers:
    """What the flags say of takes; InputError where that cannot be."""
    from ..core.mocap.answers import TakeAnswers

    answers = TakeAnswers(unit=options.unit, up=options.up.upper(), rate=options.rate, strict=options.strict)
    answers.check()
    return answers


def read_answers(options: argparse.Namespace) -> Answers:
    """What the flags say; InputError where that cannot be."""
    from ..core.recording.reading.answers import Answers

    answers = Answers(
        axes=options.axes.upper(),
        unit=options.unit,
        up=options.up.upper(),
        rate=options.rate,
        rotation=options.rotation,
        swap_hands=options.swap_hands,
        eye_height=options.eye_height,
        mounts=options.mounts,
        strict=options.strict,
        force=options.force,
        auto_trim=options.auto_trim,
    )
    answers.check()
    return answers

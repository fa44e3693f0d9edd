"""Flags by which a person says of a recording what its file does not, or says wrongly."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..core.recording.reading.answers import Answers


def add_answers(parser: argparse.ArgumentParser) -> None:
    """Add the flags to a verb that reads recordings."""
    group = parser.add_argument_group("how to read recordings (default: as the file and its movement tell)")
    group.add_argument(
        "--axes",
        default="",
        metavar="XYZ",
        help="where x, y and z point: RUB (OpenXR), RUF (Unity), RFU (Blender)",
    )
    group.add_argument("--unit", default="", metavar="U", help="of lengths: m, cm, mm, ft or in")
    group.add_argument("--up", default="", metavar="X|Y|Z", help="the axis that points up")
    group.add_argument("--rate", type=float, metavar="N", help="samples per second, for files without times")
    group.add_argument(
        "--rotation",
        default="",
        metavar="R",
        help="how rotations are written: wxyz, xyzw, YXZ-degrees, matrix ...",
    )
    group.add_argument("--swap-hands", action="store_true", help="left and right controller change places")
    group.add_argument("--eye-height", type=float, metavar="M", help="standing eye height, m")
    group.add_argument("--strict", action="store_true", help="doubts about a recording are errors")
    group.add_argument("--force", action="store_true", help="go on with what can be no person")
    group.add_argument(
        "--auto-trim", action="store_true", help="leave out what follows the headset's being laid down"
    )


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
        strict=options.strict,
        force=options.force,
        auto_trim=options.auto_trim,
    )
    answers.check()
    return answers

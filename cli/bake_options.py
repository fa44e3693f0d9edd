"""The options of a bake, wherever they are said: on the command line, in a row of a table, or in an earlier report.

What was said is a mapping of names to values that holds nothing else, so that one such mapping can be laid over
another: a row over the command line, both over a report.
"""

from __future__ import annotations

import argparse
import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any, NoReturn

from ..core.errors import FaultError, InputError
from ..core.methods import ENGINES, TRAVELS
from ..core.settings import BakeSettings
from .answers import add_answers
from .options import InputPath, add_bone_map, add_database, add_limits, add_settings

Said = Mapping[str, Any]

FALSE, TRUE = ("false", "no", "off", "0"), ("true", "yes", "on", "1")


def add_bake_options(parser: argparse.ArgumentParser) -> None:
    """Add all options but what is read first and what is written; `--bone-map` comes with the verb."""
    parser.add_argument(
        "--rig",
        type=InputPath,
        metavar="FILE[:OBJECT]",
        help=".blend, .fbx, .glb or .vrm; default: a mannequin of the user's height is made",
    )
    parser.add_argument(
        "--body",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="whether the armature that is made without --rig has a mesh (default: yes)",
    )
    parser.add_argument(
        "--ground",
        type=InputPath,
        metavar="FILE.blend[:NAME]",
        help="what the feet stand on: an object or collection of a .blend, or all of it; comes into the output, too",
    )
    _add_layers(parser)
    add_answers(parser)
    parser.add_argument(
        "--fps", type=float, metavar="N", help="frame rate of the scene (default: the database's)"
    )
    _add_part(parser)
    add_database(parser, required=False)
    parser.add_argument(
        "--predictor", type=InputPath, metavar="P.npz", help='body-orientation weights, or "headset" for none'
    )
    parser.add_argument(
        "--fit-range",
        action=argparse.BooleanOptionalAction,
        help="make the scene's range that of the bake (default: unless the rig is in a .blend, which keeps its range "
        "and gets the bake from the range's first frame on)",
    )
    add_limits(parser)
    parser.add_argument(
        "--settings",
        type=InputPath,
        metavar="REPORT.json",
        help="a report of an earlier bake, to be repeated: all that is not given is as it was there",
    )
    add_settings(parser, BakeSettings)


def _add_layers(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--at",
        default="recording",
        metavar="PLACE",
        help='where the bake starts: "rig" for where the rig stands and faces, or the name of an object in the rig\'s '
        'file, along whose Y axis the body then faces (default: "recording", its own world)',
    )
    parser.add_argument(
        "--layer",
        choices=("new", "range", "strip"),
        default="new",
        help="a new action, the bake's frames in a copy of the rig's present action, or an NLA strip on top of it "
        "(default: new)",
    )
    parser.add_argument(
        "--blend",
        type=int,
        default=0,
        metavar="FRAMES",
        help="frames over which a range or a strip fades in and out (default: 0)",
    )
    parser.add_argument(
        "--travel",
        choices=tuple(TRAVELS),
        help="what carries the way over the ground: the hips, a root bone above them, or nothing (default: hips)",
    )
    parser.add_argument(
        "--fewer-keys",
        type=float,
        default=0.0,
        metavar="MM",
        help="leave out keys without which no joint is farther than this from where all keys have it, in millimetres "
        "(default: 0, all keys)",
    )
    parser.add_argument(
        "--deform-only",
        action=argparse.BooleanOptionalAction,
        help="export deforming bones alone, with the bones above them (default: for an engine)",
    )
    parser.add_argument(
        "--engine",
        choices=tuple(ENGINES),
        help="export for a game engine: deforming bones, axes and scales as it reads them, and the way on a root bone "
        "where the rig has one",
    )


def _add_part(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--from",
        dest="start",
        type=float,
        metavar="S",
        help="second of the recording to start at (default: its start)",
    )
    parser.add_argument(
        "--to",
        dest="stop",
        type=float,
        metavar="S",
        help="second of the recording to stop at (default: its end)",
    )


class BakeParser(argparse.ArgumentParser):
    """The parser of a bake's options outside of a command line: a fault is a FaultError."""

    def __init__(self) -> None:
        super().__init__(add_help=False, allow_abbrev=False)
        add_bone_map(self)
        add_bake_options(self)

    def error(self, message: str) -> NoReturn:
        """What argparse objects to."""
        raise FaultError(message)

    def actions(self) -> dict[str, argparse.Action]:
        """Each argument by what a table may call it: its flags without dashes, or where it is kept."""
        found: dict[str, argparse.Action] = {}
        for action in self._actions:
            for name in (action.dest, *action.option_strings):
                found[_plain(name)] = action
        return found


def only_said(parser: argparse.ArgumentParser) -> None:
    """Have a parser leave out of its result whatever option is not said."""
    for action in parser._actions:
        if action.option_strings:
            action.default = argparse.SUPPRESS


def read_said(values: Mapping[str, Any]) -> dict[str, Any]:
    """What a row of a table, or a report, says of a bake.

    Args:
        values: by name of the flag, with or without dashes; texts, numbers, truth values or lists of texts; what is
            empty says nothing.

    Raises:
        FaultError: an option that there is not, or a value that it cannot have.
    """
    parser, actions = _said_parser()
    words: list[str] = []
    for name, value in values.items():
        action = actions.get(_plain(name))
        if action is None:
            raise FaultError(f"there is no option {name!r}")
        if value is not None and value != "":
            words += _words(action, name, value)
    return vars(parser.parse_args(words))


def completed(options: argparse.Namespace, *layers: Said) -> None:
    """Fill in a bake's options: earlier layers count before later ones, and all of them before the defaults.

    Args:
        options: what was said first; is changed.
        layers: what else was said.
    """
    for layer in (*layers, bake_defaults()):
        for name, value in layer.items():
            if not hasattr(options, name):
                setattr(options, name, list(value) if isinstance(value, list) else value)


@functools.cache
def bake_defaults() -> Said:
    """Every option of a bake where nothing is said."""
    return {action.dest: action.default for action in BakeParser()._actions}


@functools.cache
def _said_parser() -> tuple[BakeParser, dict[str, argparse.Action]]:
    parser = BakeParser()
    only_said(parser)
    return parser, parser.actions()


def part_of(options: argparse.Namespace) -> tuple[float, float] | None:
    """The seconds to bake; None for the whole recording."""
    if options.start is None and options.stop is None:
        return None
    return options.start or 0.0, math.inf if options.stop is None else options.stop


def setting_names() -> frozenset[str]:
    """The options that are settings of the bake."""
    return frozenset(item.name for item in fields(BakeSettings))


def check_complete(options: argparse.Namespace) -> None:
    """Raise InputError where it is not said what to bake."""
    if not options.recording:
        raise InputError("no recording: give RECORDING, or --settings of a report that names one")


def paths_from(said: Said, folder: Path) -> dict[str, Any]:
    """What a table says, with its files looked for from the table's own folder."""

    def found(value: Any) -> Any:
        if isinstance(value, list):
            return [found(item) for item in value]
        if isinstance(value, InputPath) and value != "headset":
            return InputPath(folder / value)
        return value

    return {name: found(value) for name, value in said.items()}


def _plain(name: str) -> str:
    return name.strip().lstrip("-").replace("_", "-")


def _words(action: argparse.Action, name: str, value: Any) -> list[str]:
    """A value as it would stand on a command line."""
    flag = action.option_strings[0]
    if action.nargs == 0:
        said = str(value).strip().lower()
        if said not in (*TRUE, *FALSE):
            raise FaultError(f"{name}: {value!r} is neither true nor false")
        off = next((other for other in action.option_strings if other.startswith("--no-")), None)
        return [flag] if said in TRUE else [off] if off else []
    if action.nargs is not None:  # none of a bake's options has more than one value
        raise FaultError(f"{name}: cannot be said here")
    several: Sequence[Any] = [value]
    if isinstance(action, argparse._AppendAction):
        several = value if isinstance(value, list) else str(value).split(";")
    if any(isinstance(item, (dict, list, bool)) for item in several):
        raise FaultError(f"{name}: {value!r} is no value of it")
    return [f"{flag}={str(item).strip()}" for item in several]

"""Arguments that several verbs share, flags made from settings, and arguments that are files."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any

from ..core.errors import InputError
from ..core.settings import check
from ..core.transaction import Transaction

STDOUT = "-"


class InputPath(str):
    """The `type` of arguments that name a file to read, or FILE:OBJECT."""

    __slots__ = ()

    def files(self) -> list[str]:
        """What must not be overwritten."""
        file, colon, _ = self.rpartition(":")
        return [str(self), file] if colon and file else [str(self)]


class OutputPath(str):
    """The `type` of arguments that name a file to write, or "-"."""

    suffixes: tuple[str, ...] = ()
    beside: tuple[str, ...] = ()

    @staticmethod
    def to(suffix: str, *beside: str, others: tuple[str, ...] = ()) -> Callable[[str], OutputPath]:
        """For files that can only be of one kind, or of `others`; `beside` are endings that files next to it add."""

        def make(text: str) -> OutputPath:
            path = OutputPath(text)
            path.suffixes, path.beside = (suffix, *others), beside
            return path

        return make

    def files(self) -> list[str]:
        """What is written; InputError where its kind is wrong."""
        if self == STDOUT and not self.suffixes:
            return []
        if self.suffixes and Path(self).suffix.lower() not in self.suffixes:
            kinds = " or ".join(self.suffixes)
            raise InputError(f"{self}: cannot write this kind of file; let its name end in {kinds}")
        return [str(self), *(f"{self}{ending}" for ending in self.beside)]


class OutputFolder(str):
    """The `type` of arguments that name a folder to write files into."""

    certain: tuple[str, ...] = ()

    @staticmethod
    def of(*names: str) -> Callable[[str], OutputFolder]:
        """For folders that always get files of these names."""

        def make(text: str) -> OutputFolder:
            folder = OutputFolder(text)
            folder.certain = names
            return folder

        return make

    def files(self) -> list[str]:
        """What is certainly written; the transaction looks at the rest when it comes."""
        return [str(Path(self) / name) for name in self.certain]


def add_database(parser: argparse.ArgumentParser, *, required: bool = True) -> None:
    """The option for one or more databases."""
    parser.add_argument(
        "--database",
        type=InputPath,
        action="append",
        default=[],
        required=required,
        metavar="DB.npz",
        help="a motion database; may be repeated" + ("" if required else " (default: the starter motion)"),
    )


def add_bone_map(parser: argparse.ArgumentParser) -> None:
    """The option for bone maps that count before all others."""
    parser.add_argument(
        "--bone-map",
        type=InputPath,
        action="append",
        default=[],
        metavar="MAP.json",
        help="names of joints or bones, as docs/takes.md says; counts before all others; may be repeated",
    )


def add_limits(parser: argparse.ArgumentParser) -> None:
    """Add `--fail-if`."""
    parser.add_argument(
        "--fail-if",
        action="append",
        default=[],
        metavar="CONDITION",
        help='end with code 3 where a metric is so, as in "foot_skate_cm_s.mean > 2"; may be repeated',
    )


def add_output(
    parser: argparse.ArgumentParser, metavar: str, help: str, *beside: str, others: tuple[str, ...] = ()
) -> None:
    """The option for the one file that a verb must write; the end of `metavar` is its kind, or it is one of `others`.

    `beside` are the endings that the names of files written next to it add to its own.
    """
    kind = OutputPath.to(Path(metavar).suffix, *beside, others=others)
    parser.add_argument("-o", "--output", type=kind, required=True, metavar=metavar, help=help)


def add_settings(parser: argparse.ArgumentParser, settings: type, skip: Sequence[str] = ()) -> None:
    """One flag for each field of a settings dataclass, under its field name."""
    for item in fields(settings):
        if item.name in skip:
            continue
        meta, flag = item.metadata, "--" + item.name.replace("_", "-")
        assert item.default is not MISSING
        if isinstance(item.default, bool):
            parser.add_argument(
                flag,
                action=argparse.BooleanOptionalAction,
                default=item.default,
                help=f"{meta['help']} (default: {'on' if item.default else 'off'})",
            )
            continue
        unit = f" {meta['unit']}" if meta["unit"] else ""
        shown = f"{item.default:g}" if isinstance(item.default, float) else str(item.default)
        choices = "".join(f"; {name}: {tip}" for name, tip in (meta["choices"] or {}).items())
        parser.add_argument(
            flag,
            type=type(item.default),
            default=item.default,
            choices=list(meta["choices"]) if meta["choices"] else None,
            metavar=None
            if meta["choices"]
            else meta["unit"].upper().replace("/", "_PER_").removeprefix("1_") or "N",
            help=f"{meta['help']}{choices} (default: {shown}{unit})".replace("%", "%%"),
        )


def read_settings(options: argparse.Namespace, settings: type, **fixed: Any) -> Any:
    """The checked settings dataclass that the flags say, with `fixed` fields from elsewhere."""
    names = [item.name for item in fields(settings) if item.name not in fixed]
    made = settings(**{name: getattr(options, name) for name in names}, **fixed)
    check(made)
    return made


def open_outputs(options: argparse.Namespace) -> Transaction:
    """The transaction of all that a verb writes, which keeps its hands off all that the verb reads.

    Raises:
        InputError: before any work, where an output cannot be written or is one of the inputs.
    """
    given = [
        item for value in vars(options).values() for item in (value if isinstance(value, list) else [value])
    ]
    outputs = Transaction(file for item in given if isinstance(item, InputPath) for file in item.files())
    targets: set[Path] = set()
    for item in given:
        if isinstance(item, OutputFolder):
            outputs.folder(item)
        for path in item.files() if isinstance(item, OutputPath | OutputFolder) else []:
            target = outputs.check(path)
            if target in targets:
                raise InputError(f"{path}: is to be written twice; give each output a name of its own")
            targets.add(target)
    return outputs

"""Arguments that several verbs share, flags made from settings, and the check of outputs."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any

from ..core.errors import InputError
from ..core.files import check_target
from ..core.settings import check
from .verb import Verb


def add_database(parser: argparse.ArgumentParser) -> None:
    """The option for one or more databases."""
    parser.add_argument(
        "--database",
        action="append",
        required=True,
        metavar="DB.npz",
        help="a motion database; may be repeated",
    )


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


def check_outputs(options: argparse.Namespace) -> None:
    """Raise InputError, before any work, where what a verb is to write cannot be written or is one of its inputs."""
    verb: Verb = options.chosen
    outputs = [options.output, *getattr(options, "export", ())] if verb.writes else []
    if outputs and Path(outputs[0]).suffix.lower() != verb.writes:
        raise InputError(f"{outputs[0]}: cannot write this kind of file; let its name end in {verb.writes}")
    plot = getattr(options, "plot", None)
    if plot is not None:
        if Path(plot).suffix.lower() != ".png":
            raise InputError(f"{plot}: figures are PNG; let its name end in .png")
        outputs.append(plot)
    if options.json not in (None, "-"):
        outputs.append(options.json)
    inputs = {Path(path).resolve() for path in _inputs(options, verb)}
    targets: set[Path] = set()
    for path in outputs:
        target = check_target(path)
        if target in inputs:
            raise InputError(f"{path}: is one of the files to read; write to another one")
        if target in targets:
            raise InputError(f"{path}: is to be written twice; give each output a name of its own")
        targets.add(target)


def _inputs(options: argparse.Namespace, verb: Verb) -> list[str]:
    """Every file that the verb is to read."""
    paths: list[str] = []
    for name in verb.reads:
        value = getattr(options, name) or []
        paths += [value] if isinstance(value, str) else value
    # of FILE:OBJECT the file, too
    return paths + [path.rpartition(":")[0] for path in paths if ":" in path]

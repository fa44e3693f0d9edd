"""`map`: how an unknown recording is read, what of that is wrong, and keeping the answer."""

from __future__ import annotations

import argparse
from typing import Any

from ..core.errors import InputError
from ..core.transaction import Transaction
from .answers import add_answers, read_answers
from .common import say
from .options import InputPath
from .verb import Report, Verb


def _add(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", type=InputPath, metavar="FILE", help="a recording")
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="COLUMN=MEANING",
        help="what a column is: time, frame, device, nothing, or a part of a pose such as head.px, left.qw, right.rx; "
        "or whose rows a device's name has: HMD=head",
    )
    parser.add_argument("--keep", default="", metavar="NAME", help="keep it for files with the same columns")
    add_answers(parser)


def _said(options: argparse.Namespace) -> dict[str, str]:
    from ..core.recording.reading.kept import check_said

    said: dict[str, str] = {}
    for text in options.set:
        column, equals, meaning = text.rpartition("=")
        if not equals or not column:
            raise InputError(f"--set {text}: give COLUMN=MEANING, such as 'x=head.px'")
        try:
            said[column] = check_said(meaning)
        except ValueError as error:
            raise InputError(f"--set {text}: {error}") from None
    return said


def _map(options: argparse.Namespace, outputs: Transaction) -> Report:
    """Show what a file's columns were taken for and the poses that come of it; keep it under a name."""
    from ..core.recording.mapping import look, poses_in_words
    from ..core.recording.reading.kept import keep_map

    answers = read_answers(options)
    said = _said(options)
    seen = look(options.file, said, answers)
    say(options, options.file)
    width = max((len(column.name) for column in seen.columns), default=0)
    for column in seen.columns:
        by = {"": "", "you": "  (you say so)", "kept": "  (kept)"}[column.by]
        say(options, f"  {column.name:<{min(width, 40)}}  {column.example[:14]:<14}  {column.said}{by}")
    if not seen.columns:
        say(options, "  no columns: its format says what its numbers are")
    if seen.recording is None:
        raise InputError(f"{seen.fault}; or say what columns are, such as --set COLUMN=head.px")
    poses = poses_in_words(seen.recording)
    for name, text in (*poses.items(), *seen.recording.found.items()):
        say(options, f"  {name:<16} {text}")
    for doubt in seen.recording.doubts:
        say(options, f"  doubtful         {doubt}")
    report: dict[str, Any] = {
        "file": options.file,
        "columns": [
            {"name": column.name, "first": column.example, "said": column.said, "by": column.by}
            for column in seen.columns
        ],
        "poses": poses,
        "found": seen.recording.found,
        "doubts": list(seen.recording.doubts),
    }
    if options.keep:
        if not seen.columns:
            raise InputError(f"--keep {options.keep}: the file has no columns whose meaning could be kept")
        path = keep_map(seen.to_keep(options.keep, said, answers))
        say(options, f"  kept in {path}")
        report["kept"] = str(path)
    return report


MAP = Verb("map", "show how an unknown recording is read, correct it, and keep the answer", _add, _map)

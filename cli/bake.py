"""`bake`: an animated rig from a recording."""

from __future__ import annotations

import argparse

from ..core.transaction import Transaction
from .bake_options import add_bake_options, check_complete, only_said
from .baking import TRACKS, Library, make
from .common import run, say, tell
from .options import InputPath, OutputPath, add_output
from .repeat import complete_bake, differences, read_earlier
from .verb import Report, Verb


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    from ..bridge import exports

    parser.add_argument(
        "recording",
        type=InputPath,
        nargs="?",
        metavar="RECORDING",
        help="the three trackers, in any known format (default: that of --settings)",
    )
    add_output(
        parser,
        "OUT.blend",
        "the file to write; OUT.npz for the bones' tracks alone, which needs no Blender",
        others=(TRACKS,),
    )
    parser.add_argument(
        "--export",
        type=OutputPath,
        action="append",
        metavar="FILE",
        help=f"also write {exports.in_words()}",
    )
    add_bake_options(parser)
    only_said(parser)


def _prepare(options: argparse.Namespace) -> None:
    options.export = getattr(options, "export", [])
    options.json = getattr(options, "json", None)
    complete_bake(options)
    check_complete(options)


def _run(options: argparse.Namespace, outputs: Transaction) -> Report:
    """An animated rig from a recording, written as a Blender file."""
    from ..core.measure.words import report_in_words

    report = make(options, [*options.export, options.output], outputs, Library(), run)
    if options.settings:
        report["warnings"] += differences(read_earlier(options.settings), report)
    failed = [f"failed: {line}" for line in report.get("failed", [])]
    for line in (*report["warnings"], *failed):
        tell(f"footwork bake: {line}")
    written = report["written"]
    say(options, *report_in_words(report))
    say(
        options,
        f"{options.output}: {written['object']}, {written['frames']} frames at {written['fps']:g} per second",
    )
    return report


BAKE = Verb(
    "bake",
    "turn a recording into an animated rig",
    _add_arguments,
    _run,
    prepare=_prepare,
    maps_bones=True,
)

"""From arguments to an exit code."""

from __future__ import annotations

import argparse
import sys
import traceback
from collections.abc import Sequence

from ..core.errors import InputError
from ..core.transaction import Transaction
from .common import report_text, tell, with_bone_maps
from .options import STDOUT, open_outputs
from .parser import make_parser
from .streams import ended_by_sigterm, forgiving_streams, quiet_stdout, send
from .verb import Report
from .work import WORKER, serve

DONE, BUG, BAD_INPUT, LIMIT, UNFINISHED = 0, 1, 2, 3, 4


def main(argv: Sequence[str] | None = None) -> int:
    """Run one verb and return its exit code; nothing but the code says that it failed to a caller in Blender.

    Exit codes: 0 done, 1 our bug, 2 bad usage, bad input or cancelled, 3 a limit of --fail-if is passed, 4 some
    recordings of a batch failed. With 1 and 2 all files are as they were, but for what a batch had done before.
    """
    if (sys.argv[1:] if argv is None else list(argv)) == [WORKER]:
        return serve()
    with forgiving_streams():
        parser = make_parser()
        try:
            options = parser.parse_args(argv)
        except SystemExit as end:
            return int(end.code or 0)
        return _run(options)


def _run(options: argparse.Namespace) -> int:
    outputs: Transaction | None = None
    report: Report = {}
    try:
        with ended_by_sigterm(), _prepared(options) as outputs:
            with quiet_stdout(options.json == STDOUT), with_bone_maps(options):
                report = options.chosen.run(options, outputs)
            if options.json is not None:
                _put(report, options.json, outputs)
    except InputError as error:
        for line in error.lines:
            tell(f"footwork {options.verb}: {line}")
        return BAD_INPUT
    except (Exception, KeyboardInterrupt) as error:
        # Blender's operators turn a cancel into an error of theirs
        if not isinstance(error, KeyboardInterrupt) and "KeyboardInterrupt" not in traceback.format_exc():
            traceback.print_exc()
            tell(f"footwork {options.verb}: this is a bug in Footwork; please report the lines above")
            return BUG
        # it came too late where all is written
        if outputs is None or not outputs.committed:
            return _cancelled(options)
    if report.get("unfinished"):
        return UNFINISHED
    return LIMIT if report.get("failed") else DONE


def _prepared(options: argparse.Namespace) -> Transaction:
    """The verb's transaction, once its options are complete."""
    options.chosen.prepare(options)
    return open_outputs(options)


def _put(report: Report, target: str, outputs: Transaction) -> None:
    """The report as a file among the others, or on standard output before they are there."""
    text = report_text(report)
    if target == STDOUT:
        send(text)
    else:
        outputs.write(target, lambda file: file.write(text.encode()))


def _cancelled(options: argparse.Namespace) -> int:
    tell(f"footwork {options.verb}: cancelled{options.chosen.when_cancelled(options)}")
    return BAD_INPUT

"""From arguments to an exit code."""

from __future__ import annotations

import argparse
import os
import sys
import traceback
from collections.abc import Sequence

from ..core.errors import InputError
from .common import quiet_stdout, write_report
from .options import check_outputs
from .parser import make_parser

DONE, BUG, BAD_INPUT, LIMIT = 0, 1, 2, 3


def main(argv: Sequence[str] | None = None) -> int:
    """Run one verb and return its exit code; nothing but the code says that it failed to a caller in Blender.

    Exit codes: 0 done, 1 our bug, 2 bad usage or bad input, 3 a limit of --fail-if is passed.
    """
    parser = make_parser()
    try:
        options = parser.parse_args(argv)
    except SystemExit as end:
        return int(end.code or 0)
    try:
        check_outputs(options)
        with quiet_stdout(options.json == "-"):
            report = options.chosen.run(options)
        if options.json is not None:
            write_report(report, options.json)
    except InputError as error:
        for line in str(error).splitlines():
            print(f"footwork {options.verb}: {line}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        return _cancelled(options)
    except BrokenPipeError:  # whoever read our output has read enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except Exception:
        # Blender's operators turn a cancel into an error of theirs
        if "KeyboardInterrupt" in traceback.format_exc():
            return _cancelled(options)
        traceback.print_exc()
        print(
            f"footwork {options.verb}: this is a bug in Footwork; please report the lines above",
            file=sys.stderr,
        )
        return BUG
    else:
        return LIMIT if report.get("failed") else DONE
    return DONE


def _cancelled(options: argparse.Namespace) -> int:
    print(f"footwork {options.verb}: cancelled{options.chosen.when_cancelled(options)}", file=sys.stderr)
    return BAD_INPUT

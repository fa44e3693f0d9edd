"""`compare-reports`: what got better and worse between two reports."""

from __future__ import annotations

import argparse

from ..core.errors import InputError
from ..core.transaction import Transaction
from .common import each, read_report, say
from .options import InputPath
from .verb import Report, Verb


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    from ..core.evaluation.compare import TOLERANCE

    parser.add_argument("old", type=InputPath, metavar="OLD.json", help="a report of evaluate or bake")
    parser.add_argument("new", type=InputPath, metavar="NEW.json", help="a later one")
    parser.add_argument(
        "--tolerance",
        type=float,
        default=TOLERANCE,
        metavar="SHARE",
        help=f"relative change that counts as none (default: {TOLERANCE:g})",
    )
    parser.add_argument(
        "--fail-if-worse", action="store_true", help="end with code 3 where a metric got worse"
    )


def _run(options: argparse.Namespace, outputs: Transaction) -> Report:
    """Two reports side by side."""
    from ..core.evaluation.compare import compare_reports, comparison_in_words

    old, new = each([options.old, options.new], read_report)
    if not 0.0 <= options.tolerance <= 10.0:
        raise InputError(f"--tolerance {options.tolerance:g}: give a share, as 0.05")
    comparison = compare_reports(old, new, options.tolerance)
    say(options, *comparison_in_words(comparison))
    if options.fail_if_worse and comparison["worse"]:
        comparison["failed"] = [
            f"{row['metric']} got worse" for row in comparison["rows"] if row["verdict"] == "worse"
        ]
    return comparison


COMPARE_REPORTS = Verb(
    "compare-reports",
    "say what got better and worse between two reports",
    _add_arguments,
    _run,
)

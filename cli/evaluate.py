"""`evaluate`: compare bakes with the truth."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..core.files import sha256_of
from ..core.settings import BakeSettings
from ..core.transaction import Transaction
from .answers import add_take_answers
from .common import choose_predictor, each, load_databases, load_takes, needing, read_report, run, say, tell
from .experiments import add_experiments
from .options import InputPath, OutputFolder, add_database, add_limits, add_settings, read_settings
from .report_folder import CERTAIN, write_folder
from .verb import Report, Verb

NO_BPY = "--in-blender measures in Blender: run it there, or install the Python module bpy"
_EPILOG = """
Each take is the user: virtual trackers are put on its body, the recording that they give is baked onto a rig of the
same body, and the result is compared with the take. Definitions of all metrics: docs/evaluation.md.

  footwork evaluate visitor.bvh --database walk.npz --in-blender -o report
  footwork evaluate v*.bvh --database walk.npz --experiment positional-error --experiment coverage -o report
  footwork evaluate v*.bvh --database walk.npz --fail-if "foot_skate_cm_s.mean > 2" --against baseline.json

Exit codes: 0 done, 2 bad usage or bad input, 3 a limit of --fail-if is passed, 1 a bug of ours.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    from ..core.evaluation.experiments import EXPERIMENTS

    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = _EPILOG
    parser.add_argument(
        "takes", type=InputPath, nargs="+", metavar="TAKE", help="takes that are in no database given"
    )
    add_take_answers(parser)
    parser.add_argument(
        "--experiment",
        action="append",
        default=[],
        choices=[*EXPERIMENTS, "all"],
        help="also make an experiment of the paper; may be repeated",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=OutputFolder.of(*CERTAIN),
        metavar="FOLDER",
        help="write report.html, report.json and the figures here (figures need matplotlib)",
    )
    add_limits(parser)
    parser.add_argument(
        "--against", type=InputPath, metavar="REPORT.json", help="compare with an earlier report"
    )
    parser.add_argument(
        "--in-blender", action="store_true", help="measure the action on an armature as Blender evaluates it"
    )
    parser.add_argument("--true-orientation", action="store_true", help="use the take's own body orientation")
    add_database(parser)
    _add_predictors(parser)
    add_settings(parser, BakeSettings)


def _add_predictors(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--predictor",
        type=InputPath,
        action="append",
        default=[],
        metavar="P.npz",
        help='body-orientation weights, or "headset" for none; may be repeated: the first is used, all are compared by '
        "the experiment orientation",
    )
    parser.add_argument(
        "--train-on",
        type=InputPath,
        nargs="+",
        default=[],
        metavar="TAKE",
        help="for the experiment orientation: train the paper's network with r = 1 and r = 50 on these takes first "
        "(needs torch; the weights are kept in the output folder)",
    )
    parser.add_argument(
        "--train-time",
        type=float,
        default=300.0,
        metavar="S",
        help="limit for each training (default: 300 s)",
    )


def _run(options: argparse.Namespace, outputs: Transaction) -> Report:
    """Bakes of recordings simulated from takes, compared with the takes themselves."""
    from ..core.evaluation.compare import compare_reports, comparison_in_words
    from ..core.evaluation.evaluate import evaluate_takes
    from ..core.evaluation.experiments import EXPERIMENTS
    from ..core.evaluation.limits import failures, parse_limit
    from ..core.measure.words import report_in_words
    from ..core.recording.body_estimate import HEADSET

    settings = read_settings(options, BakeSettings)
    limits = each(options.fail_if, parse_limit)
    old = read_report(options.against) if options.against else None
    names = list(EXPERIMENTS) if "all" in options.experiment else list(dict.fromkeys(options.experiment))
    show = blender_show() if options.in_blender else None
    folder = None if options.output is None else Path(options.output)
    databases = load_databases(options.database)
    takes = load_takes(options, options.takes, databases[0].fps)
    first = options.predictor[0] if options.predictor else None
    predict = None if options.true_orientation else choose_predictor(first)
    report = run(evaluate_takes(takes, databases, predict, settings, show))
    weights = [path for path in options.predictor if path != HEADSET]
    report["inputs"] += [{"kind": "predictor", "name": p, "sha256": sha256_of(p)} for p in weights]
    for entry in report["takes"]:
        say(options, entry["take"], *report_in_words(entry))
    figures = add_experiments(options, report, names, takes, databases, predict, settings, outputs)
    if old is not None:
        report["comparison"] = compare_reports(old, report)
        say(options, *comparison_in_words(report["comparison"]))
    if limits:
        report["limits"] = [limit.text for limit in limits]
        report["failed"] = failures(report["metrics"], limits)
    if folder is not None:
        write_folder(folder, report, figures, outputs)
    for line in (*report["warnings"], *(f"failed: {line}" for line in report.get("failed", []))):
        tell(f"footwork evaluate: {line}")
    return report


def blender_show() -> Any:
    """What bakes a result on an armature and reads it back as Blender evaluates it."""
    with needing("bpy", NO_BPY):
        from ..bridge.targets import show_bake
    return show_bake


EVALUATE = Verb(
    "evaluate",
    "compare bakes with the truth: each take is the user",
    _add_arguments,
    _run,
    maps_bones=True,
)

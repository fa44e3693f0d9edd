"""The verbs that judge: `evaluate` and `compare-reports`."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from ..core.errors import InputError
from ..core.evaluation.compare import TOLERANCE, compare_reports, comparison_in_words
from ..core.evaluation.experiments import EXPERIMENTS
from ..core.evaluation.limits import failures, parse_limit
from ..core.files import sha256_of, write_atomically
from ..core.settings import BakeSettings
from . import common as cli

NO_BPY = "--in-blender measures in Blender: run it there, or install the Python module bpy"
Report = dict[str, Any]

_EPILOG = """
Each take is the user: virtual trackers are put on its body, the recording that they give is baked onto a rig of the
same body, and the result is compared with the take. Definitions of all metrics: docs/evaluation.md.

  footwork evaluate visitor.bvh --database walk.npz --in-blender -o report
  footwork evaluate v*.bvh --database walk.npz --experiment positional-error --experiment coverage -o report
  footwork evaluate v*.bvh --database walk.npz --fail-if "foot_skate_cm_s.mean > 2" --against baseline.json

Exit codes: 0 done, 2 bad usage or bad input, 3 a limit of --fail-if is passed, 1 a bug of ours.
"""


def add_verbs(verb: Callable[..., argparse.ArgumentParser]) -> None:
    """Add the two verbs to the parser of the command line."""
    _add_evaluate(verb("evaluate", evaluate, "compare bakes with the truth: each take is the user"))
    _add_compare(verb("compare-reports", compare, "say what got better and worse between two reports"))


def _add_evaluate(sub: argparse.ArgumentParser) -> None:
    sub.formatter_class = argparse.RawDescriptionHelpFormatter
    sub.epilog = _EPILOG
    sub.add_argument("takes", nargs="+", metavar="TAKE", help="BVH takes that are in no database given")
    sub.add_argument(
        "--experiment",
        action="append",
        default=[],
        choices=[*EXPERIMENTS, "all"],
        help="also make an experiment of the paper; may be repeated",
    )
    sub.add_argument(
        "-o",
        "--output",
        metavar="FOLDER",
        help="write report.html, report.json and the figures here (figures need matplotlib)",
    )
    sub.add_argument(
        "--fail-if",
        action="append",
        default=[],
        metavar="CONDITION",
        help='end with code 3 where a metric is so, as in "foot_skate_cm_s.mean > 2"; may be repeated',
    )
    sub.add_argument("--against", metavar="REPORT.json", help="compare with an earlier report")
    sub.add_argument(
        "--in-blender", action="store_true", help="measure the action on an armature as Blender evaluates it"
    )
    sub.add_argument("--true-orientation", action="store_true", help="use the take's own body orientation")
    cli.add_database(sub)
    sub.add_argument(
        "--predictor",
        action="append",
        default=[],
        metavar="P.npz",
        help='body-orientation weights, or "headset" for none; may be repeated: the first is used, all are compared by '
        "the experiment orientation",
    )
    sub.add_argument(
        "--train-on",
        nargs="+",
        default=[],
        metavar="TAKE",
        help="for the experiment orientation: train the paper's network with r = 1 and r = 50 on these takes first "
        "(needs torch; the weights are kept in the output folder)",
    )
    sub.add_argument(
        "--train-time",
        type=float,
        default=300.0,
        metavar="S",
        help="limit for each training (default: 300 s)",
    )
    cli.add_settings(sub, BakeSettings)


def _add_compare(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("old", metavar="OLD.json", help="a report of evaluate or bake")
    sub.add_argument("new", metavar="NEW.json", help="a later one")
    sub.add_argument(
        "--tolerance",
        type=float,
        default=TOLERANCE,
        metavar="SHARE",
        help=f"relative change that counts as none (default: {TOLERANCE:g})",
    )
    sub.add_argument("--fail-if-worse", action="store_true", help="end with code 3 where a metric got worse")


def evaluate(options: argparse.Namespace) -> Report:
    """Bakes of recordings simulated from takes, compared with the takes themselves."""
    from ..core.evaluation.evaluate import evaluate_takes
    from ..core.pipeline import report_in_words
    from ..core.recording.orientation import HEADSET

    settings = cli.read_settings(options, BakeSettings)
    limits = cli.each(options.fail_if, parse_limit)
    old = read_report(options.against) if options.against else None
    names = list(EXPERIMENTS) if "all" in options.experiment else list(dict.fromkeys(options.experiment))
    show = blender_show() if options.in_blender else None
    folder = report_folder(options.output)
    databases = cli.load_databases(options.database)
    takes = cli.load_takes(options.takes, databases[0].fps)
    first = options.predictor[0] if options.predictor else None
    predict = None if options.true_orientation else cli.choose_predictor(first)
    report = cli.run(evaluate_takes(takes, databases, predict, settings, show))
    weights = [path for path in options.predictor if path != HEADSET]
    report["inputs"] += [{"kind": "predictor", "name": p, "sha256": sha256_of(p)} for p in weights]
    for entry in report["takes"]:
        cli.say(options, f"{entry['take']}\n{report_in_words(entry)}")
    figures = add_experiments(options, report, names, takes, databases, predict, settings, folder)
    if old is not None:
        report["comparison"] = compare_reports(old, report)
        cli.say(options, comparison_in_words(report["comparison"]))
    if limits:
        report["limits"] = [limit.text for limit in limits]
        report["failed"] = failures(report["metrics"], limits)
    if folder is not None:
        write_folder(folder, report, figures)
    for line in (*report["warnings"], *(f"failed: {line}" for line in report.get("failed", []))):
        print(f"footwork evaluate: {line}", file=sys.stderr)
    return report


def add_experiments(
    options: argparse.Namespace,
    report: Report,
    names: Sequence[str],
    takes: Sequence[Any],
    databases: Sequence[Any],
    predict: Callable[[Any], Any] | None,
    settings: BakeSettings,
    folder: Path | None,
) -> dict[str, list[Any]]:
    """Make experiments, add their tables to the report, and return their plots by name."""
    from ..core.evaluation.study import Study
    from ..core.evaluation.words import experiment_in_words

    predictors: dict[str, Any] = {}
    trained: dict[str, frozenset[str]] = {}
    if "orientation" in names:
        predictors, trained = compared_predictors(options, folder)
    study = Study(takes, databases, predict, settings, predictors, trained)
    plots: dict[str, list[Any]] = {}
    for name in names:
        try:
            experiment = cli.run(EXPERIMENTS[name](study))
        except InputError as error:
            if "all" not in options.experiment:
                raise
            report["warnings"].append(str(error))
            continue
        report["experiments"].append(experiment.report())
        plots[name] = list(experiment.plots)
        cli.say(options, experiment_in_words(report["experiments"][-1]))
    return plots


def compared_predictors(
    options: argparse.Namespace, folder: Path | None
) -> tuple[dict[str, Any], dict[str, frozenset[str]]]:
    """The predictors of the experiment orientation by label, and the takes that each was trained on."""
    from ..core.recording.orientation import HEADSET
    from ..nn.predictor import headset_forward, load_predictor, predict, shipped_predictors

    given = [path for path in options.predictor if path != HEADSET]
    loaded = list(zip([Path(p).stem for p in given], cli.each(given, load_predictor), strict=True))
    if options.train_on:
        loaded += train_paper_networks(options, folder)
    shipped = shipped_predictors()
    if not any(predictor.layout is None for _, predictor in loaded):
        loaded += [(name, p) for name, p in shipped.items() if p.layout is None]
    if not any(predictor.layout is not None for _, predictor in loaded):
        loaded += [(name, p) for name, p in shipped.items() if p.layout is not None]
    ways: dict[str, Any] = {HEADSET: headset_forward}
    trained: dict[str, frozenset[str]] = {}
    for name, predictor in loaded:
        label = f"ours, {name}"
        if predictor.layout is None:
            label = f"r = {predictor.provenance.get('settings', {}).get('iterations', '?')}"
        label = f"{label} ({name})" if label in ways else label
        ways[label] = lambda recording, chosen=predictor: predict(chosen, recording)
        trained[label] = frozenset(take["sha256"] for take in predictor.provenance.get("takes", []))
    return ways, trained


def train_paper_networks(options: argparse.Namespace, folder: Path | None) -> list[tuple[str, Any]]:
    """The paper's network trained with r = 1 and r = 50, to be compared."""
    import tempfile

    from ..nn.predictor import load_predictor
    from ..nn.settings import TrainSettings
    from ..nn.train.job import train_predictor

    takes = cli.load_takes(options.train_on)
    out: list[tuple[str, Any]] = []
    with tempfile.TemporaryDirectory() as temporary:
        for iterations in (1, 50):
            settings = TrainSettings(
                kind="paper", iterations=iterations, time_limit=options.train_time, keep_worse=True
            )
            target = (make(folder) if folder else Path(temporary)) / f"r{iterations}.npz"
            cli.run(train_predictor(takes, settings, target))
            out.append((target.stem, load_predictor(target)))
    return out


def blender_show() -> Any:
    """What bakes a result on an armature and reads it back as Blender evaluates it."""
    try:
        from ..bridge.shown import show_bake
    except ModuleNotFoundError as error:
        if error.name != "bpy":
            raise
        raise InputError(NO_BPY) from error
    return show_bake


def report_folder(path: str | None) -> Path | None:
    """The folder for the report, which is made when there is something to write."""
    if path is None:
        return None
    folder = Path(path)
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{path}: is a file; give a folder for the report")
    return folder


def make(folder: Path) -> Path:
    """The folder, made where it is missing."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made ({error.strerror}); choose another folder") from error
    return folder


def write_folder(folder: Path, report: Report, plots: dict[str, list[Any]]) -> None:
    """The page, the report and the figures; without matplotlib the page has tables alone."""
    from ..core.evaluation.page import page

    make(folder)
    figures: dict[str, list[tuple[str, bytes]]] = {}
    notes: list[str] = []
    try:
        figure = cli.drawing()
    except InputError as error:
        notes.append(str(error))
        print(f"footwork evaluate: {error}", file=sys.stderr)
    else:
        figures = {name: [(plot.title, figure.draw(plot)) for plot in some] for name, some in plots.items()}
        figures |= {entry["take"]: [("over time", figure.draw_series(entry))] for entry in report["takes"]}
    for name, drawn in figures.items():
        for i, (_, png) in enumerate(drawn):
            target = folder / f"{Path(name).stem}{f'-{i + 1}' if len(drawn) > 1 else ''}.png"
            write_atomically(target, lambda file, png=png: file.write(png))
    text = page(report, figures, notes)
    write_atomically(folder / "report.html", lambda file: file.write(text.encode()))
    cli.write_report(report, str(folder / "report.json"))
    print(f"{folder / 'report.html'} written", file=sys.stderr)


def read_report(path: str) -> Report:
    """A report of evaluate or bake; InputError where the file is none."""
    try:
        report = json.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error}); check its name") from error
    except ValueError as error:
        raise InputError(f"{path}: is no JSON ({error}); give a report of evaluate or bake") from error
    if not isinstance(report, dict) or not isinstance(report.get("metrics"), dict):
        raise InputError(f"{path}: has no metrics; give a report of evaluate or bake")
    return report


def compare(options: argparse.Namespace) -> Report:
    """Two reports side by side."""
    old, new = cli.each([options.old, options.new], read_report)
    if not 0.0 <= options.tolerance <= 10.0:
        raise InputError(f"--tolerance {options.tolerance:g}: give a share, as 0.05")
    comparison = compare_reports(old, new, options.tolerance)
    cli.say(options, comparison_in_words(comparison))
    if options.fail_if_worse and comparison["worse"]:
        comparison["failed"] = [
            f"{row['metric']} got worse" for row in comparison["rows"] if row["verdict"] == "worse"
        ]
    return comparison

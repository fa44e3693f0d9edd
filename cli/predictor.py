"""`train-predictor` and `evaluate-predictor`."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from ..core.transaction import Transaction
from ..nn.settings import CHECKPOINT, TrainSettings
from .answers import add_take_answers
from .common import drawing, each, load_takes, run, say
from .options import InputPath, OutputPath, add_output, add_settings, read_settings
from .verb import Report, Verb

LOST = {"none": (), "left": ("left",), "right": ("right",), "both": ("left", "right")}
"""What `--lost` says, as names of trackers."""


def _add_train(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "takes", type=InputPath, nargs="+", metavar="TAKE", help="takes: BVH, MVNX, FBX, glTF"
    )
    add_take_answers(parser)
    add_output(parser, "P.npz", "the weights to write", CHECKPOINT)
    add_settings(parser, TrainSettings)


def _train(options: argparse.Namespace, outputs: Transaction) -> Report:
    """A body-orientation predictor from takes."""
    from ..nn.train.job import train_predictor

    settings = read_settings(options, TrainSettings)
    takes = load_takes(options, options.takes)
    return run(train_predictor(takes, settings, Path(options.output), outputs=outputs))


def _when_cancelled(options: argparse.Namespace) -> str:
    from ..nn.train.checkpoint import checkpoint_path

    path = checkpoint_path(options.output)
    return f"; add --resume to go on from {path}" if path.is_file() else ""


def _add_evaluate(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("takes", type=InputPath, nargs="+", metavar="TAKE", help="takes, each the user once")
    add_take_answers(parser)
    parser.add_argument(
        "--predictor",
        type=InputPath,
        action="append",
        metavar="P.npz",
        help="weights; may be repeated (default: everything that ships)",
    )
    parser.add_argument(
        "--lost", choices=LOST, default="none", help="controllers that sleep all the time (default: none)"
    )
    parser.add_argument(
        "--plot",
        type=OutputPath.to(".png"),
        metavar="FILE.png",
        help="draw the errors: by minute, and how often they are small",
    )


def _evaluate(options: argparse.Namespace, outputs: Transaction) -> Report:
    """Orientation errors of predictors beside the headset's forward."""
    from ..nn.evaluate import errors_in_words, evaluate_predictors
    from ..nn.predictor import load_predictor, shipped_predictors

    figures = drawing() if options.plot else None
    if options.predictor:
        paths = list(dict.fromkeys(options.predictor))
        predictors = dict(zip(_names(paths), each(paths, load_predictor), strict=True))
    else:
        predictors = shipped_predictors()
    report = evaluate_predictors(load_takes(options, options.takes), predictors, LOST[options.lost])
    say(options, *errors_in_words(report))
    if figures is not None:
        outputs.write(options.plot, lambda file: file.write(figures.draw_predictors(report)))
    return report


def _names(paths: Sequence[str]) -> Sequence[str]:
    """What a report calls the predictors of files: as the files, with their folders where that is not enough."""
    from ..nn.evaluate import UNTRAINED

    stems = [Path(path).stem for path in paths]
    return stems if len({*stems, *UNTRAINED}) == len(stems) + len(UNTRAINED) else paths


TRAIN_PREDICTOR = Verb(
    "train-predictor",
    "train a body-orientation predictor on takes (needs torch)",
    _add_train,
    _train,
    maps_bones=True,
    when_cancelled=_when_cancelled,
)
EVALUATE_PREDICTOR = Verb(
    "evaluate-predictor",
    "orientation errors beside the headset's forward",
    _add_evaluate,
    _evaluate,
    maps_bones=True,
)

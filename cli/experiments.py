"""The paper's experiments for a report of `evaluate`."""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from ..core.errors import InputError
from ..core.settings import BakeSettings
from ..core.transaction import Transaction
from .common import each, load_takes, run, say
from .verb import Report


def add_experiments(
    options: argparse.Namespace,
    report: Report,
    names: Sequence[str],
    takes: Sequence[Any],
    databases: Sequence[Any],
    predict: Callable[[Any], Any] | None,
    settings: BakeSettings,
    outputs: Transaction,
) -> dict[str, list[Any]]:
    """Make experiments, add their tables to the report, and return their plots by name."""
    from ..core.evaluation.experiments import EXPERIMENTS
    from ..core.evaluation.study import Study
    from ..core.evaluation.words import experiment_in_words

    predictors: dict[str, Any] = {}
    trained: dict[str, frozenset[str]] = {}
    if "orientation" in names:
        predictors, trained = compared_predictors(options, outputs)
    study = Study(takes, databases, predict, settings, predictors, trained)
    plots: dict[str, list[Any]] = {}
    for name in names:
        try:
            experiment = run(EXPERIMENTS[name](study))
        except InputError as error:
            if "all" not in options.experiment:
                raise
            report["warnings"].append(str(error))
            continue
        report["experiments"].append(experiment.report())
        plots[name] = list(experiment.plots)
        say(options, *experiment_in_words(report["experiments"][-1]))
    return plots


def compared_predictors(
    options: argparse.Namespace, outputs: Transaction
) -> tuple[dict[str, Any], dict[str, frozenset[str]]]:
    """The predictors of the experiment orientation by label, and the takes that each was trained on."""
    from ..core.recording.body_estimate import HEADSET
    from ..nn.predictor import headset_forward, load_predictor, predict, shipped_predictors

    given = [path for path in options.predictor if path != HEADSET]
    loaded = list(zip([Path(p).stem for p in given], each(given, load_predictor), strict=True))
    if options.train_on:
        loaded += train_paper_networks(options, outputs)
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


def train_paper_networks(options: argparse.Namespace, outputs: Transaction) -> list[tuple[str, Any]]:
    """The paper's network trained with r = 1 and r = 50, to be compared."""
    from ..nn.predictor import load_predictor
    from ..nn.settings import TrainSettings
    from ..nn.train.job import train_predictor

    takes = load_takes(options, options.train_on)
    out: list[tuple[str, Any]] = []
    with tempfile.TemporaryDirectory() as temporary:
        for iterations in (1, 50):
            settings = TrainSettings(
                kind="paper", iterations=iterations, time_limit=options.train_time, keep_worse=True
            )
            target = Path(temporary) / f"r{iterations}.npz"
            run(train_predictor(takes, settings, target))
            out.append((target.stem, load_predictor(target)))
            if options.output is not None:
                weights = target.read_bytes()
                outputs.folder(options.output)
                outputs.write(
                    Path(options.output) / target.name, lambda file, weights=weights: file.write(weights)
                )
    return out

"""The paper's experiments on where the body faces (section 6.4) and on bent legs (section 5.5)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..database.motion_database import MotionDatabase
from ..database.virtual_root import virtual_root
from ..errors import InputError
from ..jobs import Job
from ..measure.measures import counted, summary, yaw_errors
from ..recording.body_estimate import HEADSET
from ..recording.simulate import simulate_recording
from ..settings import BakeSettings
from .study import (
    Cell,
    Experiment,
    Line,
    Plot,
    Relation,
    Runs,
    Study,
    averaging,
    in_order,
    modes,
    over_time,
    run_all,
)

Array = NDArray[np.floating[Any]]

_PAPER_DEG = {HEADSET: "14.5 ± 18.9", "r = 50": "5.4 ± 7.7", "r = 1": "15.0 ± 25.7"}
_BENT = 0.85
"""Headset heights over standing eye height below which legs count as bent."""


def orientation(study: Study) -> Job[Experiment]:
    """Errors of every predictor of a study per minute (paper, section 6.4)."""
    errors: dict[str, list[Array]] = {label: [] for label in study.predictors}
    fps = study.takes[0].motion.fps
    for i, take in enumerate(study.takes):
        recording = simulate_recording(take.motion, take.name)
        truth = virtual_root(take.motion)[1]
        for j, (label, predict) in enumerate(study.predictors.items()):
            yield (i + j / len(errors)) / len(study.takes), f"Orientation of {take.name}: {label}"
            errors[label].append(np.degrees(yaw_errors(predict(recording).yaws, truth)))
    rows: list[list[Cell]] = []
    means: dict[str, float] = {}
    for label, parts in errors.items():
        figures = summary(np.concatenate(parts))
        means[label] = figures["mean"]
        spread = [figures[key] for key in ("mean", "std", "p95", "max")]
        seen = [take.sha256 in study.trained_on.get(label, frozenset()) for take in study.takes]
        rows.append([label, *spread, f"{sum(seen)} of {len(seen)}", _PAPER_DEG.get(label)])
    step = min(60.0, averaging(sum(len(t.motion) for t in study.takes), fps) * 3.0)
    return Experiment(
        "orientation",
        "Body orientation",
        "Angle between the predicted and the true heading of the hips, on trackers simulated from the takes. The "
        "paper's figures are of its own user and game. A predictor that was trained on a user's take has an "
        "unfair advantage there; the table says on how many of the takes.",
        ["predictor", "mean, °", "std", "p95", "max", "takes seen in training", "paper, °"],
        rows,
        _orientation_relations(means),
        [
            Plot(
                f"Orientation error, averaged every {step:.0f} s",
                "minutes",
                "error, °",
                [
                    Line(label, *over_time(np.concatenate(parts), fps, step))
                    for label, parts in errors.items()
                ],
            )
        ],
        [
            f"no predictor with {label} was given: train the paper's network or give its weights"
            for label in ("r = 1", "r = 50")
            if label not in errors
        ],
    )


def _orientation_relations(means: Mapping[str, float]) -> list[Relation]:
    claims = [
        ("r = 50", HEADSET, "r = 50 errs less than the headset's forward"),
        ("r = 50", "r = 1", "r = 50 errs less than r = 1"),
    ]
    claims += [
        (label, "r = 50", f"{label} errs less than the paper's network")
        for label in means
        if label != HEADSET and not label.startswith("r = ")
    ]
    return [
        in_order([a, b], [means[a], means[b]], claim, "°")
        for a, b, claim in claims
        if a in means and b in means
    ]


def leg_bend(study: Study) -> Job[Experiment]:
    """Bent legs with databases for them, and with the standing one alone (paper, section 5.5)."""
    standing = _standing(study.databases)
    conditions: dict[str, tuple[Sequence[MotionDatabase], BakeSettings]] = {}
    for mode, settings in modes(study.settings).items():
        conditions[f"{mode}|all"] = (study.databases, settings)
        alone = replace(study.databases[standing], height_range=(0.0, np.inf))
        conditions[f"{mode}|standing"] = ([alone], settings)
    heights = [_height_ratios(study, i) for i in range(len(study.takes))]
    bent = [ratios < _BENT for ratios in heights]
    if not any(part.any() for part in bent):
        raise InputError(
            f"experiment leg-bend: no user's headset is ever below {_BENT:.0%} of eye height; give takes of people "
            "who crouch"
        )
    runs = yield from run_all(study, conditions)
    rows: list[list[Cell]] = []
    relations: list[Relation] = []
    for mode in modes(study.settings):
        knees: list[float] = []
        for which, name in (("all", "all, by height"), ("standing", study.databases[standing].name)):
            run = runs[f"{mode}|{which}"]
            low, high = _means(run, bent), _means(run, [~part for part in bent])
            played = np.concatenate([p.database for p in run.playbacks])
            switches = sum(int(np.count_nonzero(np.diff(p.database))) for p in run.playbacks)
            others = np.count_nonzero(played - standing) if which == "all" else 0
            share = others / len(played)
            rows.append([mode, name, *low.values(), *high.values(), share, switches])
            knees.append(low["knee_error_deg"])
        claim = f"databases of bent legs bring the knees of bent legs nearer to the truth, {mode}"
        relations.append(in_order(["all:", "standing alone:"], knees, claim, "°"))
    share = float(np.mean(np.concatenate(bent)))
    return Experiment(
        "leg-bend",
        "Bent legs",
        f'Users whose headset is below {_BENT:.0%} of eye height for {share:.0%} of the time ("bent"), with all '
        "databases, each for its range of heights, and with the standing one alone. The paper shows pictures and no "
        "figures.",
        [
            "condition",
            "databases",
            "knee error bent, °",
            "hips height bent, cm",
            "legs MPJPE bent, cm",
            "knee error upright, °",
            "hips height upright, cm",
            "legs MPJPE upright, cm",
            "played others",
            "switches",
        ],
        rows,
        relations,
        [_bend_plot(study, runs, heights)],
    )


def _standing(databases: Sequence[MotionDatabase]) -> int:
    """The database for a headset at eye height."""
    fitting = [i for i, d in enumerate(databases) if d.height_range[0] <= 1.0 < d.height_range[1]]
    if len(databases) < 2 or not fitting:
        raise InputError(
            "experiment leg-bend: give at least two databases, one of them for standing people (build the others "
            "with their own --height-range)"
        )
    return fitting[0]


def _height_ratios(study: Study, index: int) -> Array:
    take = study.takes[index]
    recording = simulate_recording(take.motion, take.name)
    return recording.positions[:, 0, 2] / recording.eye_height


def _means(run: Runs, where: Sequence[NDArray[np.bool_]]) -> dict[str, float]:
    names = ("knee_error_deg", "hips_height_error_cm", "lower_body_mpjpe_cm")
    out: dict[str, float] = {}
    for name in names:
        parts = [
            counted(values.own[name], flags).ravel() for values, flags in zip(run.values, where, strict=True)
        ]
        out[name] = summary(np.concatenate(parts))["mean"]
    return out


def _bend_plot(study: Study, runs: Mapping[str, Runs], heights: Sequence[Array]) -> Plot:
    """The hips' height error of the matched motion beside the headset's height, a fifth of a second each."""
    fps = study.takes[0].motion.fps
    lines = [Line("headset over eye height, %", *over_time(100.0 * np.concatenate(heights), fps, 0.2))]
    for which, label in (("all", "all databases"), ("standing", "standing alone")):
        errors = runs[f"as the paper|{which}"].joined("knee_error_deg")
        lines.append(Line(f"knee error, {label}, °", *over_time(errors, fps, 0.2)))
    return Plot("Bent legs, as the paper", "minutes", "", lines)

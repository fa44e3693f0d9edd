"""The paper's experiments by name: what is varied, what is measured, what the paper found (its section 6)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..jobs import Job
from .experiments_body import leg_bend, orientation
from .study import (
    Cell,
    Experiment,
    Line,
    Plot,
    Relation,
    Runs,
    Study,
    as_paper,
    averaging,
    in_order,
    modes,
    over_time,
    run_all,
)
from .subset import reduce_database

Array = NDArray[np.floating[Any]]

SHARES = (1.0, 0.25, 0.1)
ALPHAS = (0.3, 0.1)
BETAS = (1.0, 2.0, 4.6, 10.0, 20.0)
_PAPER_ERROR_CM = {1.0: 19.0, 0.25: 22.0, 0.1: 27.0}
_PAPER_POSES = {0.3: 6932, 0.1: 5715}
_CLOUD = 20_000
"""Points of a cloud that are drawn at most."""


def positional_error(study: Study) -> Job[Experiment]:
    """Root error with 100, 25 and 10 % of the databases, alpha 0.3 m (paper, section 6.2)."""
    cut = {share: [reduce_database(d, share) for d in study.databases] for share in SHARES}
    conditions = {
        f"{mode}|{share}": (cut[share], replace(settings, alpha=0.3))
        for mode, settings in modes(study.settings).items()
        for share in SHARES
    }
    runs = yield from run_all(study, conditions)
    rows: list[list[Cell]] = []
    relations: list[Relation] = []
    plots: list[Plot] = []
    for mode in modes(study.settings):
        mine = {share: runs[f"{mode}|{share}"] for share in SHARES}
        for share, run in mine.items():
            frames = sum(len(database) for database in cut[share])
            paper = _PAPER_ERROR_CM[share] if mode == "as the paper" else None
            rows.append([mode, f"{share:.0%}", frames, *_error_cells(run), paper])
        means = [run.mean("matched_root_error_cm") for run in mine.values()]
        labels = [f"{share:.0%}" for share in SHARES]
        relations.append(
            in_order(labels, means, f"error at 100 % < 25 % < 10 % of the databases, {mode}", "cm")
        )
        relations.append(_within(mine, 0.3, mode))
        plots.append(_error_plot(mine, mode))
    return Experiment(
        "positional-error",
        "Size of the database and positional error",
        "Distance of the virtual root to its target while the same users play with the whole of the databases and "
        "with parts of it; alpha is 0.3 m. The paper's figures are of its own databases and user.",
        [
            "condition",
            "database",
            "frames",
            "root error, cm",
            "p95",
            "max",
            "of the avatar, cm",
            "to true hips, cm",
            "skate, cm/s",
            "held at alpha",
            "poses used",
            "paper, cm",
        ],
        rows,
        relations,
        plots,
    )


def _error_cells(run: Runs) -> list[Cell]:
    matched = run.metrics["matched_root_error_cm"]
    return [
        matched["mean"],
        matched["p95"],
        matched["max"],
        run.mean("root_error_cm"),
        run.mean("hips_error_cm"),
        run.mean("foot_skate_cm_s"),
        run.mean("clamped_fraction"),
        run.metrics["poses_used"],
    ]


def _within(runs: Mapping[float, Runs], alpha: float, mode: str) -> Relation:
    most = max(run.metrics["matched_root_error_cm"]["max"] for run in runs.values())
    # alpha is metres on the avatar, the search's floats are the databases'
    return Relation(
        f"the matched root is never farther than alpha from its target, {mode}",
        most <= 100.0 * alpha * (1.0 + 1e-6),
        f"at most {most:.2f} cm of {100.0 * alpha:.0f}",
    )


def _error_plot(runs: Mapping[float, Runs], mode: str) -> Plot:
    lines: list[Line] = []
    step = 20.0
    for share, run in runs.items():
        errors, fps = run.joined("matched_root_error_cm"), run.values[0].fps
        step = averaging(len(errors), fps)
        lines.append(Line(f"{share:.0%}", *over_time(errors, fps, step)))
    return Plot(f"Positional error, {mode}, averaged every {step:.0f} s", "minutes", "root error, cm", lines)


def coverage(study: Study) -> Job[Experiment]:
    """Poses used with alpha 0.3 and 0.1 m (paper, section 6.3)."""
    conditions = {
        f"{mode}|{alpha}": (study.databases, replace(settings, alpha=alpha))
        for mode, settings in modes(study.settings).items()
        for alpha in ALPHAS
    }
    runs = yield from run_all(study, conditions)
    rows: list[list[Cell]] = []
    relations: list[Relation] = []
    for mode in modes(study.settings):
        for alpha in ALPHAS:
            run = runs[f"{mode}|{alpha}"]
            paper = _PAPER_POSES[alpha] if mode == "as the paper" else None
            jumps = run.metrics["pose_jump"]["mean"]
            rows.append([mode, alpha, *_error_cells(run), run.mean("transitions_per_s"), jumps, paper])
        wide, narrow = (runs[f"{mode}|{alpha}"] for alpha in ALPHAS)
        used = [float(run.metrics["poses_used"]) for run in (narrow, wide)]
        claim = f"alpha 0.3 uses more poses than alpha 0.1, {mode}"
        relations.append(in_order(["0.1 m:", "0.3 m:"], used, claim, "poses"))
        skate = [run.mean("foot_skate_cm_s") for run in (wide, narrow)]
        claim = f"alpha 0.1 makes feet skate more than alpha 0.3, {mode}"
        relations.append(in_order(["0.3 m:", "0.1 m:"], skate, claim, "cm/s"))
    return Experiment(
        "coverage",
        "Position accuracy and use of the database",
        "The same users with alpha 0.3 m and 0.1 m. The clouds show where the body is 0.33 s later, seen from above "
        "in its own frame, for all poses of the databases and for those that were used.",
        [
            "condition",
            "alpha, m",
            "root error, cm",
            "p95",
            "max",
            "of the avatar, cm",
            "to true hips, cm",
            "skate, cm/s",
            "held at alpha",
            "poses used",
            "transitions, 1/s",
            "pose jump",
            "paper, poses",
        ],
        rows,
        relations,
        [_cloud_plot(study, runs, mode) for mode in modes(study.settings)],
    )


def _cloud_plot(study: Study, runs: Mapping[str, Runs], mode: str) -> Plot:
    """The 0.33 s positions of all poses and of those used."""
    places = [
        d.features.values[:, :2] * d.features.deviation[:2] + d.features.mean[:2] for d in study.databases
    ]
    everything = np.concatenate(places)
    every = -(-len(everything) // _CLOUD)
    lines = [Line("database", *everything[::every].T)]
    for alpha in ALPHAS:
        run = runs[f"{mode}|{alpha}"]
        played = np.concatenate([values.own["poses_used"] for values in run.values])
        used = np.unique(played, axis=0).astype(np.intp)
        points = np.concatenate([place[used[used[:, 0] == i, 1]] for i, place in enumerate(places)])
        lines.append(Line(f"alpha {alpha:g} m: {len(used)} poses", *points.T))
    return Plot(f"Position in 0.33 s, {mode}", "to the right, m", "forward, m", lines, kind="points")


def responsiveness(study: Study) -> Job[Experiment]:
    """The causal trajectory's beta from sluggish to nervous (paper, section 5.3)."""
    settings = as_paper(study.settings)
    runs = yield from run_all(
        study, {f"{beta:g}": (study.databases, replace(settings, beta=beta)) for beta in BETAS}
    )
    rows: list[list[Cell]] = []
    for beta in BETAS:
        run = runs[f"{beta:g}"]
        rows.append(
            [
                beta,
                float(np.log(2.0) / beta),
                _lag(run),
                run.mean("matched_root_error_cm"),
                run.mean("yaw_error_deg"),
                run.mean("foot_skate_cm_s"),
                run.mean("transitions_per_s"),
                run.metrics["pose_jump"]["mean"],
                run.mean("clamped_fraction"),
            ]
        )
    slow, quick = rows[0], rows[-1]
    lags = [float(row[2] or 0.0) for row in (quick, slow)]
    yaws = [float(row[4] or 0.0) for row in (quick, slow)]
    names = [f"beta {BETAS[-1]:g}:", f"beta {BETAS[0]:g}:"]
    return Experiment(
        "responsiveness",
        "Responsiveness",
        "The causal trajectory as in the paper with its smoothing from slow to quick; the matched motion alone. Lag "
        "is the delay at which the velocity of the root fits that of the target best.",
        [
            "beta, 1/s",
            "half-life, s",
            "lag, s",
            "root error, cm",
            "yaw error, °",
            "skate, cm/s",
            "transitions, 1/s",
            "pose jump",
            "held at alpha",
        ],
        rows,
        [
            in_order(names, lags, "a higher beta follows with less lag", "s"),
            in_order(names, yaws, "a higher beta faces the predicted way more closely", "°"),
        ],
        [
            Plot(
                "Responsiveness",
                "beta, 1/s",
                "",
                [
                    Line(label, np.array(BETAS), np.array([float(row[column] or 0.0) for row in rows]))
                    for label, column in (("root error, cm", 3), ("yaw error, °", 4), ("skate, cm/s", 5))
                ],
            )
        ],
    )


def _lag(run: Runs) -> float:
    """Delay in seconds, up to one, that makes the root's velocity most like the target's."""
    fps = run.values[0].fps
    delays = np.arange(round(fps) + 1)
    likeness = np.zeros(len(delays))
    for playback in run.playbacks:
        ours = np.diff(playback.root_positions, axis=0)
        wanted = np.diff(playback.target_positions, axis=0)
        end = len(ours) - len(delays)
        if end > 0:
            likeness += [float(np.sum(ours[d : d + end] * wanted[:end])) for d in delays.tolist()]
    return float(np.argmax(likeness) / fps)


EXPERIMENTS: dict[str, Callable[[Study], Job[Experiment]]] = {
    "positional-error": positional_error,
    "coverage": coverage,
    "orientation": orientation,
    "responsiveness": responsiveness,
    "leg-bend": leg_bend,
}
"""By the names that the command line knows."""

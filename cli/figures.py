"""Figures of reports as PNG; importing this needs matplotlib."""

from __future__ import annotations

import io
from itertools import cycle
from typing import Any

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot
from matplotlib.figure import Figure

from ..core.evaluation.study import Plot
from ..core.recording.body_estimate import HEADSET
from ..nn.evaluate import HEURISTIC

COLOURS = ("#1b6ca8", "#d1495b", "#3a9d5d", "#e3a008", "#7a5195", "#555555")
_UNTRAINED = {HEADSET: "#8c8c8c", HEURISTIC: "#c3b59b"}
_OVER_TIME = (
    ("matched_root_error_cm", "root error of the matched motion, cm"),
    ("root_error_cm", "root error of the avatar, cm"),
    ("body_yaw_error_deg", "yaw error to the truth, °"),
    ("foot_skate_cm_s", "foot skate, cm/s"),
    ("hand_position_error_cm", "hand error, cm"),
    ("lower_body_mpjpe_cm", "lower body MPJPE, cm"),
)


def draw(plot: Plot) -> bytes:
    """A plot of an experiment."""
    if plot.kind == "points":
        return _clouds(plot)
    figure, axes = pyplot.subplots(figsize=(9.0, 4.0), layout="constrained")
    for line, colour in zip(plot.lines, COLOURS, strict=False):
        few = len(line.x) <= 40
        axes.plot(line.x, line.y, color=colour, label=line.label, marker="o" if few else None, markersize=3)
    axes.set(title=plot.title, xlabel=plot.x, ylabel=plot.y)
    axes.set_ylim(bottom=0.0)
    axes.grid(alpha=0.3)
    axes.legend(frameon=False)
    return _png(figure)


def _clouds(plot: Plot) -> bytes:
    """The first cloud in grey behind each of the others, side by side at one scale."""
    background, *clouds = plot.lines
    figure, row = pyplot.subplots(
        1, len(clouds), figsize=(4.6 * len(clouds), 5.2), sharex=True, sharey=True, squeeze=False,
        layout="constrained",
    )  # fmt: skip
    for axes, cloud, colour in zip(row[0], clouds, COLOURS, strict=False):
        axes.scatter(background.x, background.y, s=2, color="#cccccc", linewidths=0, label=background.label)
        axes.scatter(cloud.x, cloud.y, s=3, color=colour, linewidths=0, label=cloud.label)
        axes.set_title(f"{plot.title}\n{cloud.label}", fontsize=10)
        axes.set(xlabel=plot.x, ylabel=plot.y)
        axes.set_aspect("equal")
        axes.grid(alpha=0.3)
    return _png(figure)


def draw_series(entry: dict[str, Any]) -> bytes:
    """A take's metrics over time, transitions as ticks below."""
    series = entry["series"]
    shown = [(name, label) for name, label in _OVER_TIME if name in series]
    figure, column = pyplot.subplots(
        len(shown),
        1,
        figsize=(9.0, 1.25 * len(shown) + 0.6),
        sharex=True,
        squeeze=False,
        layout="constrained",
    )
    for axes, (name, label), colour in zip(column[:, 0], shown, COLOURS, strict=False):
        values = np.array([np.nan if value is None else value for value in series[name]], dtype=np.float64)
        seconds = (np.arange(len(values)) + 0.5) * series["step_s"]
        axes.fill_between(seconds, 0.0, np.nan_to_num(values), color=colour, alpha=0.25, linewidth=0)
        axes.plot(seconds, values, color=colour, linewidth=1.0)
        axes.set_title(label, fontsize=9, loc="left")
        axes.set_ylim(bottom=0.0)
        axes.grid(alpha=0.3)
    column[-1, 0].set_xlabel("seconds")
    return _png(figure)


def draw_predictors(report: dict[str, Any]) -> bytes:
    """Errors of predictors, from a report of `evaluate_predictors`: over time, and how often they are small."""
    rows = report["predictors"]
    labels = {name: f"{name}: mean {row['mean']:.1f}°" for name, row in rows.items()}
    columns = max(1, min(3, 138 // (max(map(len, labels.values())) + 8)))
    height = 4.4 + 0.22 * -(-len(rows) // columns)
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(11.0, height), layout="constrained")
    minutes = sum(take["seconds"] for take in report["takes"]) / 60.0
    colours = cycle(COLOURS[:5])
    for name, row in rows.items():
        colour = _UNTRAINED[name] if name in _UNTRAINED else next(colours)
        style = {"color": colour, "linewidth": 1.5 if name in _UNTRAINED else 2.0}
        left.plot(*_minutes(row, minutes), marker="o", markersize=4, label=labels[name], **style)
        errors, shares = row["percentiles"], np.arange(101.0)
        right.plot(errors, shares, **style)
        right.plot(row["mean"], np.interp(row["mean"], errors, shares), "o", color=colour, markersize=7)
    many = f"the {len(report['takes'])} takes, one after the other"
    left.set(title="Error in each minute", ylabel="mean error, degrees", xlim=(0.0, minutes))
    left.set_xlabel(f"minutes of {many if len(report['takes']) > 1 else 'the take'}")
    left.set_ylim(bottom=0.0)
    right.set(title="Share of frames with less error", ylabel="frames, %", ylim=(0.0, 100.0))
    right.set_xlabel("error, degrees (dots: means)")
    # the few worst frames would press all else to the left
    right.set_xlim(0.0, max(1.0, *(row["percentiles"][98] for row in rows.values())))
    for axes in (left, right):
        axes.grid(alpha=0.3)
    figure.legend(loc="outside lower center", ncols=columns, frameon=False)
    return _png(figure)


def _minutes(row: dict[str, Any], minutes: float) -> tuple[Any, Any]:
    """Middles and mean errors of a predictor's minutes; a last one of a few seconds would say little."""
    edges = np.minimum(np.arange(len(row["per_minute"]) + 1.0), minutes)
    told = np.diff(edges) >= min(0.25, minutes)
    return ((edges[:-1] + edges[1:]) / 2.0)[told], np.array(row["per_minute"])[told]


def _png(figure: Figure) -> bytes:
    out = io.BytesIO()
    # no date and no version inside: the same report gives the same bytes
    figure.savefig(out, format="png", dpi=110, metadata={"Software": None})
    pyplot.close(figure)
    return out.getvalue()

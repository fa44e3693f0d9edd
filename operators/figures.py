"""A bake's report in the few figures that tell whether it is good, and these over time."""

from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
from bpy.props import IntProperty
from numpy.typing import NDArray

from ..core.json_text import parse_json, to_json
from ..core.measure.catalogue import METRICS
from ..core.measure.metric import Metric, get
from ..core.measure.words import NONE, rating
from ..properties.scene import FOOTWORK_PG_scene, footwork_of
from .base import FootworkOperator

IN_SHORT = ("nsm_skate_cm_s", "shin_jerk_m_s3", "hand_position_error_cm")
"""The metrics of the status bar."""


@dataclass(frozen=True, slots=True)
class Row:
    """One figure over time."""

    label: str
    unit: str
    limit: float | None
    values: NDArray[np.floating[Any]]
    """Mean of each step; NaN where nothing was to be measured."""

    def at(self, seconds: float, step_s: float) -> float:
        """The value at a time, NaN where there is none."""
        index = int(seconds // step_s)
        return float(self.values[index]) if 0 <= index < len(self.values) else np.nan


@dataclass(frozen=True, slots=True)
class OverTime:
    """The figures of a bake over time."""

    frame_start: int
    fps: float
    seconds: float
    step_s: float
    rows: tuple[Row, ...]


def over_time(report: dict, frame_start: int, fps: float) -> str:
    """What the scene keeps for the graph, as JSON; frames are those of the action."""
    series = report["series"]
    kept = {metric.name: series[metric.name] for metric in shown_in("graph") if metric.name in series}
    seconds = report["timing_s"]["recorded"]
    return to_json(
        {
            "frame_start": frame_start,
            "fps": fps,
            "seconds": seconds,
            "step_s": series["step_s"],
            "series": kept,
        }
    )


def read_over_time(text: str) -> OverTime | None:
    """What `over_time` wrote; None where it is something else, for a .blend may come from anywhere."""
    try:
        kept = parse_json(text.encode(errors="replace"))
        rows = tuple(
            Row(metric.heading, metric.unit, metric.limit, np.array(kept["series"][metric.name], np.float64))
            for metric in shown_in("graph")
            if metric.name in kept["series"]
        )
        frame, fps, seconds, step_s = (
            float(kept[key]) for key in ("frame_start", "fps", "seconds", "step_s")
        )
    except (ValueError, KeyError, TypeError, OverflowError):
        return None
    if min(fps, seconds, step_s) <= 0.0 or any(row.values.ndim != 1 or len(row.values) == 0 for row in rows):
        return None
    return OverTime(int(frame), fps, seconds, step_s, rows)


def show(footwork: FOOTWORK_PG_scene, report: dict, title: str, fps: float) -> None:
    """Fill the Quality panel; `fps` is the action's rate."""
    footwork.over_time = over_time(report, footwork.frame_start, fps)
    metrics = report["metrics"]
    footwork.figures.clear()
    footwork.figures_of = title
    for metric in shown_in("panel"):
        row = footwork.figures.add()
        row.name, row.text = metric.heading, metric.says
        value = get(metrics, f"{metric.name}.mean" if metric.kind == "distribution" else metric.name)
        row.value = NONE if value is None else metric.text(value)
        figure, seconds = metrics.get(metric.name), report["series"].get(metric.name, ())
        if isinstance(figure, dict) and value is not None:
            worst = max((second for second in seconds if second is not None), default=value)
            row.detail = (
                f"95 % within {figure['p95']:.1f}, at most {figure['max']:.1f}, "
                f"worst second {worst:.1f} {metric.unit}"
            )
        row.good = rating(metric, metrics, seconds)
    for label, value, text in _speed(report):
        row = footwork.figures.add()
        row.name, row.value, row.text = label, value, text
    footwork.warnings = "\n".join(report["warnings"])


def in_short(report: dict) -> str:
    """One line of figures for the status bar."""
    metrics = report["metrics"]
    return ", ".join(
        f"{METRICS[name].heading.lower()} {METRICS[name].text(value)}"
        for name in IN_SHORT
        if (value := get(metrics, f"{name}.mean")) is not None
    )


def shown_in(table: str) -> list[Metric]:
    """The metrics of "panel" or "graph"."""
    return [metric for metric in METRICS.values() if table in metric.tables]


def _speed(report: dict):
    """How quickly the bake was made."""
    timing = report.get("timing_s", {})
    if timing:
        spent = max(sum(value for key, value in timing.items() if key != "recorded"), 1e-3)
        recorded = timing.get("recorded", 0.0)
        text = f"Computed in {spent:.1f} s, without reading files and writing keys"
        yield "Speed", f"{recorded / spent:.0f}x real time", text


class FOOTWORK_OT_explain_figure(FootworkOperator, bpy.types.Operator):
    """Say what the figure means"""

    bl_idname = "footwork.explain_figure"
    bl_label = "Explain"
    bl_options = {"INTERNAL"}

    index: IntProperty(name="Line", description="Line of the Quality panel", options={"SKIP_SAVE"})

    @classmethod
    def description(cls, context, properties):
        return explanation(footwork_of(context.scene), properties.index)

    def work(self, context: bpy.types.Context) -> None:
        self.tell("INFO", explanation(footwork_of(context.scene), self.index))


def explanation(footwork: FOOTWORK_PG_scene, index: int) -> str:
    """Meaning and spread of a line of the Quality panel."""
    if not 0 <= index < len(footwork.figures):
        return ""
    row = footwork.figures[index]
    return row.text + (f": {row.detail}" if row.detail else "")


CLASSES = (FOOTWORK_OT_explain_figure,)

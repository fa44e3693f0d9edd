"""A bake's report in the few figures that tell whether it is good, and these over time."""

import json
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
from bpy.props import IntProperty
from numpy.typing import NDArray

from ..properties.scene import FOOTWORK_PG_scene, footwork_of
from .base import FootworkOperator

FIGURES = (
    ("root_error_cm", "Body to user", "cm", 15.0, "Distance of the avatar's root from the user's body"),
    (
        "yaw_error_deg",
        "Body direction",
        "°",
        12.0,
        "Angle between the avatar's and the predicted body direction",
    ),
    ("foot_skate_cm_s", "Foot skate", "cm/s", 3.0, "Sliding of toes that should stand still"),
    ("head_position_error_cm", "Head", "cm", 1.0, "Distance of the head from where the headset wants it"),
    (
        "hand_position_error_cm",
        "Hands",
        "cm",
        1.0,
        "Distance of the hands from where the controllers want them",
    ),
    ("penetration_cm", "Below the floor", "cm", 0.5, "Depth of toes below the floor"),
)
"""Key in the report, label, unit, the mean up to which it counts as good, meaning."""
GRAPHED = ("root_error_cm", "yaw_error_deg", "foot_skate_cm_s")
"""The figures that are shown over time."""


@dataclass(frozen=True, slots=True)
class Row:
    """One figure over time."""

    label: str
    unit: str
    limit: float
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
    kept = {key: series[key] for key in GRAPHED if key in series}
    seconds = report["timing_s"]["recorded"]
    return json.dumps(
        {
            "frame_start": frame_start,
            "fps": fps,
            "seconds": seconds,
            "step_s": series["step_s"],
            "series": kept,
        }
    )


def read_over_time(text: str) -> OverTime:
    """What `over_time` wrote."""
    kept = json.loads(text)
    rows = tuple(
        Row(label, unit, limit, np.array(kept["series"][key], dtype=np.float64))
        for key, label, unit, limit, _ in FIGURES
        if key in kept["series"]
    )
    return OverTime(kept["frame_start"], kept["fps"], kept["seconds"], kept["step_s"], rows)


def show(footwork: FOOTWORK_PG_scene, report: dict, title: str, fps: float) -> None:
    """Fill the Quality panel; `fps` is the action's rate."""
    footwork.over_time = over_time(report, footwork.frame_start, fps)
    metrics = report["metrics"]
    footwork.figures.clear()
    footwork.figures_of = title
    for key, label, unit, limit, text in FIGURES:
        figure = metrics.get(key)
        if figure is None:
            continue
        row = footwork.figures.add()
        row.name, row.text = label, text
        row.value = f"{figure['mean']:.1f} {unit}"
        row.detail = f"95 % within {figure['p95']:.1f}, at most {figure['max']:.1f} {unit}"
        row.good = "GOOD" if figure["mean"] <= limit else "POOR"
    for label, value, text in _scalars(report):
        row = footwork.figures.add()
        row.name, row.value, row.text = label, value, text
    footwork.warnings = "\n".join(report["warnings"])


def in_short(report: dict) -> str:
    """One line of figures for the status bar."""
    metrics, parts = report["metrics"], []
    for key, label, unit, _, _ in FIGURES[:3]:
        if key in metrics:
            parts.append(f"{label.lower()} {metrics[key]['mean']:.1f} {unit}")
    return ", ".join(parts)


def _scalars(report: dict):
    metrics = report["metrics"]
    if "transitions_per_s" in metrics:
        yield "Transitions", f"{metrics['transitions_per_s']:.1f} per s", "Changes of place in the databases"
    if "poses_used" in metrics:
        yield "Poses used", f"{metrics['poses_used']}", "Different poses of the databases that were played"
    if "clamped_fraction" in metrics:
        text = "Share of frames that were held at the position accuracy"
        yield "Held at accuracy", f"{metrics['clamped_fraction']:.0%}", text
    if "unreachable_fraction" in metrics:
        text = "Share of frames in which a hand could not reach its controller"
        yield "Out of reach", f"{metrics['unreachable_fraction']:.0%}", text
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
        self.report({"INFO"}, explanation(footwork_of(context.scene), self.index))


def explanation(footwork: FOOTWORK_PG_scene, index: int) -> str:
    """Meaning and spread of a line of the Quality panel."""
    if not 0 <= index < len(footwork.figures):
        return ""
    row = footwork.figures[index]
    return row.text + (f": {row.detail}" if row.detail else "")


CLASSES = (FOOTWORK_OT_explain_figure,)

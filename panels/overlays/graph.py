"""The last bake's figures over time, drawn at the foot of the 3D viewport."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import blf
import bpy
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader
from numpy.typing import NDArray

from ...operators.figures import OverTime, read_over_time
from ...properties.scene import footwork_of

Array = NDArray[np.floating[Any]]
Box = tuple[float, float, float, float]
"""Left, bottom, right, top in pixels."""

WIDEST, NARROWEST = 620.0, 260.0
STRIP, LABEL, GAP, MARGIN, AXIS = 46.0, 15.0, 4.0, 10.0, 16.0
TEXT_SIZE = 11.0
"""All in pixels at a resolution scale of 1."""
COLOURS = ((0.35, 0.66, 1.0), (1.0, 0.71, 0.26), (0.47, 0.87, 0.47), (0.9, 0.5, 0.8))
BACK, INK, FAINT, HEAD = (0.08, 0.08, 0.08, 0.78), (0.9, 0.9, 0.9, 1.0), (1, 1, 1, 0.25), (1, 1, 1, 0.85)


@dataclass(frozen=True, slots=True)
class Text:
    """Words at a place; `right` ends them there."""

    words: str
    x: float
    y: float
    right: bool = False


@dataclass(frozen=True, slots=True)
class Drawing:
    """What is drawn, in pixels and in this order: areas as triangles, lines as pairs of points, text."""

    areas: list[tuple[Array, tuple[float, ...]]]
    lines: list[tuple[Array, tuple[float, ...]]]
    texts: list[Text]


def draw(context: bpy.types.Context) -> None:
    """Draw the figures of the scene's last bake; nothing where there was none."""
    over_time = footwork_of(context.scene).over_time
    if not over_time:
        return
    scale = context.preferences.system.ui_scale
    room = free_room(context.area, context.region)
    data = read(over_time)
    if data is None:
        return
    drawing = make_drawing(data, room, scale, context.scene.frame_current_final)
    if drawing is not None:
        paint(drawing, scale)


read = lru_cache(maxsize=4)(read_over_time)


def free_room(area: bpy.types.Area, region: bpy.types.Region) -> Box:
    """The part of a viewport's main region that no toolbar or sidebar lies over."""
    left, right = 0, region.width
    for other in area.regions:
        inside = other.width > 1 and region.x <= other.x < region.x + region.width
        if inside and other.type == "TOOLS":
            left = max(left, other.x + other.width - region.x)
        elif inside and other.type == "UI":
            right = min(right, other.x - region.x)
    return (float(left), 0.0, float(right), float(region.height))


def make_drawing(data: OverTime, room: Box, scale: float, frame: float) -> Drawing | None:
    """Lay the graph out at the foot of `room`, in its middle; None where there is too little room."""
    wide = min(room[2] - room[0] - 2 * MARGIN * scale, WIDEST * scale)
    tall = (len(data.rows) * (STRIP + GAP) + AXIS + GAP) * scale
    if not data.rows or wide < NARROWEST * scale or tall > 0.5 * (room[3] - room[1]):
        return None
    left = 0.5 * (room[0] + room[2] - wide)
    bottom = room[1] + MARGIN * scale
    drawing = Drawing([(_rectangle((left, bottom, left + wide, bottom + tall)), BACK)], [], [])
    pad = GAP * scale
    top = bottom + tall - pad
    at = (frame - data.frame_start) / data.fps
    for number, _ in enumerate(data.rows):
        box = (left + pad, top - STRIP * scale, left + wide - pad, top)
        _strip(drawing, data, number, box, scale, at)
        top -= (STRIP + GAP) * scale
    _axis(drawing, data, (left + pad, bottom, left + wide - pad, top + GAP * scale), scale)
    if 0.0 <= at <= data.seconds:
        x = left + pad + (wide - 2 * pad) * at / data.seconds
        drawing.lines.append((np.array([[x, bottom + AXIS * scale], [x, bottom + tall - pad]]), HEAD))
    return drawing


def _strip(drawing: Drawing, data: OverTime, number: int, box: Box, scale: float, at: float) -> None:
    """One figure: its curve, the value up to which it counts as good, and what it is at the current frame."""
    row, colour = data.rows[number], COLOURS[number % len(COLOURS)]
    known = row.values[~np.isnan(row.values)]
    box = (box[0], box[1], box[2], box[3] - LABEL * scale)
    limit = 0.0 if row.limit is None else row.limit
    highest = max(1.15 * limit, float(known.max()) if len(known) else 0.0) or 1.0
    for points in curves(row.values, data.step_s, data.seconds, box, highest):
        drawing.areas.append((_below(points, box[1]), (*colour, 0.3)))
        drawing.lines.append((np.repeat(points, 2, axis=0)[1:-1], (*colour, 1.0)))
    if row.limit is not None:
        y = box[1] + (box[3] - box[1]) * limit / highest
        drawing.lines.append((np.array([[box[0], y], [box[2], y]]), FAINT))
    drawing.lines.append((np.array([[box[0], box[1]], [box[2], box[1]]]), FAINT))
    line = box[3] + 4 * scale
    value = row.at(at, data.step_s)
    now = "" if np.isnan(value) else f" {value:.1f} {row.unit}"
    drawing.texts.append(Text(f"{row.label}{now}", box[0], line))
    good = "" if row.limit is None else f"good up to {limit:g}, "
    drawing.texts.append(Text(f"{good}shown up to {highest:.0f}", box[2], line, right=True))


def _axis(drawing: Drawing, data: OverTime, box: Box, scale: float) -> None:
    """Seconds of the recording below the strips."""
    step = next(s for s in (1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1e9) if data.seconds / s <= 8)
    for time in np.arange(0.0, data.seconds, step):
        x = box[0] + (box[2] - box[0]) * time / data.seconds
        drawing.lines.append((np.array([[x, box[3] - 4 * scale], [x, box[3]]]), FAINT))
        drawing.texts.append(Text(f"{time:.0f} s", x + 3 * scale, box[1] + 4 * scale))


def curves(values: Array, step_s: float, seconds: float, box: Box, highest: float) -> list[Array]:
    """Points `(N, 2)` of each stretch without a gap: the mean of a step stands in its middle."""
    edges = np.minimum(np.arange(len(values) + 1) * step_s, seconds)
    middles = 0.5 * (edges[1:] + edges[:-1])
    known = np.concatenate([[False], ~np.isnan(values), [False]])
    changes = np.flatnonzero(known[1:] != known[:-1])
    out: list[Array] = []
    for first, last in zip(changes[::2], changes[1::2], strict=True):
        times = np.concatenate([edges[first : first + 1], middles[first:last], edges[last : last + 1]])
        heights = np.concatenate([values[first : first + 1], values[first:last], values[last - 1 : last]])
        x = box[0] + (box[2] - box[0]) * times / seconds
        out.append(np.stack([x, box[1] + (box[3] - box[1]) * heights / highest], axis=-1))
    return out


def _below(points: Array, bottom: float) -> Array:
    """The area between a curve and the foot of its box, as triangles `(3 M, 2)`."""
    feet = np.stack([points[:, 0], np.full(len(points), bottom)], axis=-1)
    a, b, c, d = points[:-1], points[1:], feet[:-1], feet[1:]
    return np.stack([a, b, c, b, d, c], axis=1).reshape(-1, 2)


def _rectangle(box: Box) -> Array:
    left, bottom, right, top = box
    return np.array(
        [[left, bottom], [right, bottom], [right, top], [left, bottom], [right, top], [left, top]]
    )


def paint(drawing: Drawing, scale: float) -> None:
    """Draw in the current viewport, whose unit is the pixel."""
    flat = gpu.shader.from_builtin("UNIFORM_COLOR")
    thick = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    gpu.state.blend_set("ALPHA")
    for points, colour in drawing.areas:
        batch = batch_for_shader(flat, "TRIS", {"pos": _places(points)})
        flat.uniform_float("color", colour)
        batch.draw(flat)
    for points, colour in drawing.lines:
        batch = batch_for_shader(thick, "LINES", {"pos": _places(points)})
        thick.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
        thick.uniform_float("lineWidth", 1.2 * scale)
        thick.uniform_float("color", colour)
        batch.draw(thick)
    gpu.state.blend_set("NONE")
    blf.size(0, TEXT_SIZE * scale)
    blf.color(0, *INK)
    for text in drawing.texts:
        width = blf.dimensions(0, text.words)[0] if text.right else 0.0
        blf.position(0, text.x - width, text.y, 0.0)
        blf.draw(0, text.words)


def _places(points: Array) -> Any:
    """Points as the gpu module takes them, whose stubs know no arrays."""
    return np.column_stack([points, np.zeros(len(points))]).astype(np.float32)

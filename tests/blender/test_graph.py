"""The graph of the last bake's figures at the foot of the viewport."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import bpy
import helpers
import numpy as np
import pytest
from footwork.operators import figures
from footwork.panels.overlays import graph

ROOM = (60.0, 0.0, 860.0, 700.0)
REPORT = {
    "series": {
        "step_s": 1.0,
        "root_error_cm": [5.0, 10.0, 30.0, 12.5],
        "yaw_error_deg": [1.0, 2.0, 3.0, 4.0],
        "nsm_skate_cm_s": [0.5, None, None, 6.0],
        "penetration_cm": [0.0, 0.0, 0.0, 0.0],
    },
    "timing_s": {"recorded": 3.5},
}


@pytest.fixture
def data() -> figures.OverTime:
    return figures.read_over_time(figures.over_time(REPORT, 101, 24.0))


def test_what_the_scene_keeps_comes_back(data) -> None:
    assert (data.frame_start, data.fps, data.seconds, data.step_s) == (101, 24.0, 3.5, 1.0)
    assert [(row.label, row.unit) for row in data.rows] == [
        ("Foot skate", "cm/s"),
        ("Body to its target", "cm"),
        ("Turn to its prediction", "°"),
    ]
    skate, root, _ = data.rows
    assert root.at(2.3, 1.0) == 30.0 and math.isnan(skate.at(1.0, 1.0)) and math.isnan(root.at(-0.1, 1.0))
    assert math.isnan(root.at(9.0, 1.0))


def test_curves_stand_in_the_middle_of_their_steps_and_leave_gaps() -> None:
    values = np.array([1.0, np.nan, 2.0, 4.0])
    first, second = graph.curves(values, 1.0, 3.5, (0.0, 10.0, 350.0, 50.0), 4.0)
    assert first.tolist() == [[0, 20], [50, 20], [100, 20]]
    # the last step is half as long
    assert second.tolist() == [[200, 30], [250, 30], [325, 50], [350, 50]]


def test_the_drawing_stays_in_its_room_and_says_what_it_shows(data) -> None:
    for scale in (1.0, 2.0):
        drawing = graph.make_drawing(data, ROOM, scale, 125)
        points = np.concatenate([points for points, _ in drawing.areas + drawing.lines])
        assert points.min(axis=0).tolist() >= list(ROOM[:2]) and (points.max(axis=0) <= ROOM[2:]).all()
        words = [text.words for text in drawing.texts]
        # frame 125 is second 1, where no foot stood
        assert {
            "Body to its target 10.0 cm",
            "Foot skate",
            "good up to 15, shown up to 30",
            "0 s",
            "3 s",
        } <= {*words}


def test_a_figure_without_a_limit_has_no_line_for_it(data) -> None:
    rows = [replace(row, limit=None, values=0.0 * row.values) for row in data.rows]
    bare = graph.make_drawing(replace(data, rows=tuple(rows)), ROOM, 1.0, 125)
    faint = [
        len([1 for _, colour in made.lines if colour == graph.FAINT])
        for made in (graph.make_drawing(data, ROOM, 1.0, 125), bare)
    ]
    assert faint[0] - faint[1] == len(data.rows)
    assert [text.words for text in bare.texts if text.right] == ["shown up to 1"] * len(data.rows)


def test_the_line_at_the_current_frame_goes_along(data) -> None:
    def places(frame: float) -> list[float]:
        drawing = graph.make_drawing(data, ROOM, 1.0, frame)
        return [points[0, 0] for points, colour in drawing.lines if colour == graph.HEAD]

    (start,), (end,) = places(101), places(101 + 3.5 * 24)
    (middle,) = places(101 + 1.75 * 24)
    assert middle == pytest.approx(0.5 * (start + end)) and end - start > 500
    assert places(100) == [] and places(500) == []


def test_nothing_is_drawn_without_room(data) -> None:
    assert graph.make_drawing(data, (0, 0, 250, 700), 1.0, 1) is None
    assert graph.make_drawing(data, (0, 0, 800, 200), 1.0, 1) is None


def test_an_hour_is_drawn_with_few_numbers() -> None:
    report = {"series": {"step_s": 1.0, "root_error_cm": [1.0] * 3600}, "timing_s": {"recorded": 3600.0}}
    hour = figures.read_over_time(figures.over_time(report, 1, 60.0))
    drawing = graph.make_drawing(hour, ROOM, 1.0, 1)
    assert 3 <= sum(text.words.endswith(" s") for text in drawing.texts) <= 9


def test_toolbar_and_sidebar_are_left_free() -> None:
    from types import SimpleNamespace as Region

    main = Region(type="WINDOW", x=10, y=0, width=1000, height=600)
    tools = Region(type="TOOLS", x=10, y=0, width=50, height=600)
    sidebar = Region(type="UI", x=750, y=0, width=260, height=600)
    beside = Region(type="UI", x=1010, y=0, width=260, height=600)
    hidden = Region(type="TOOLS", x=10, y=0, width=1, height=1)
    assert graph.free_room(Region(regions=[tools, main, sidebar]), main) == (50, 0, 740, 600)
    assert graph.free_room(Region(regions=[hidden, main, beside]), main) == (0, 0, 1000, 600)


def test_it_is_painted(data) -> None:
    wide, high = 800, 300
    drawing = graph.make_drawing(data, (0, 0, wide, 2 * high), 1.0, 125)
    pixels = helpers.drawn(wide, high, lambda: graph.paint(drawing, 1.0))
    for colour in graph.COLOURS[:3]:
        assert (np.abs(pixels[..., :3] - colour).max(axis=-1) < 0.1).sum() > 100, colour
    assert pixels[200:, :, :3].max() == 0.0


def test_it_can_be_switched_off_and_is_saved(empty, tmp_path) -> None:
    assert empty.footwork.overlays.graph and empty.footwork.over_time == ""
    empty.footwork.over_time = figures.over_time(REPORT, 1, 60.0)
    empty.footwork.overlays.graph = False
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "kept.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "kept.blend"))
    assert not bpy.context.scene.footwork.overlays.graph
    kept = json.loads(bpy.context.scene.footwork.over_time)
    assert kept["series"].keys() == {"root_error_cm", "yaw_error_deg", "nsm_skate_cm_s"}


@pytest.mark.parametrize(
    "text", ["{", "[" * 9000, "[]", "3", '{"series": 3}', '{"series": {}, "frame_start": 1e999}', "\udcff"]
)
def test_what_is_no_figure_over_time_is_not_drawn(text: str) -> None:
    assert figures.read_over_time(text) is None


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("fps", 0.0),
        ("step_s", -1.0),
        ("seconds", None),
        ("frame_start", []),
        ("series", {"root_error_cm": [[1.0]]}),
    ],
)
def test_figures_over_time_that_cannot_be_are_not_drawn(key: str, value: object) -> None:
    kept = json.loads(figures.over_time(REPORT, 101, 24.0))
    assert figures.read_over_time(json.dumps({**kept, key: value})) is None

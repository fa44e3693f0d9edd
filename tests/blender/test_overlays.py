"""The registry of overlays: an entry is all that an overlay needs."""

from __future__ import annotations

from types import SimpleNamespace

import bpy
import helpers
import numpy as np
import pytest
from footwork import panels
from footwork.panels import overlays
from footwork.panels.overlays import Overlay
from footwork.panels.overlays.graph import Drawing, paint
from test_panels import draw as draw_panel

GREEN = (0.2, 0.9, 0.3, 1.0)


def viewport(scene, wanted: bool = True) -> SimpleNamespace:
    """The context of a viewport that shows overlays, or does not."""
    overlay = SimpleNamespace(show_overlays=wanted)
    return SimpleNamespace(scene=scene, space_data=SimpleNamespace(overlay=overlay))


@pytest.fixture
def toy(empty, monkeypatch):
    """An overlay that is added through the registry alone; gives the contexts that it was drawn with."""
    drawn = []
    entry = Overlay("toy", "Toy Train", "Show a toy train in the viewport", False, drawn.append)
    with monkeypatch.context() as patch:
        patch.setattr(overlays, "OVERLAYS", (*overlays.OVERLAYS, entry))
        overlays.unregister()
        overlays.register()
        yield drawn
        overlays.unregister()
    overlays.register()


def test_an_entry_gives_a_toggle(empty, toy, tmp_path) -> None:
    rna = empty.footwork.overlays.bl_rna.properties["toy"]
    assert (rna.name, rna.description, rna.default) == (
        "Toy Train",
        "Show a toy train in the viewport",
        False,
    )
    # also where nothing was baked yet, since an overlay may show something else
    layout = draw_panel(panels.quality.FOOTWORK_PT_quality)
    assert layout.properties == [overlay.name for overlay in overlays.OVERLAYS]
    assert layout.properties[-1] == "toy" and "Toy Train" in layout.texts
    empty.footwork.overlays.toy = True
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "kept.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "kept.blend"))
    assert bpy.context.scene.footwork.overlays.toy


def test_an_entry_is_drawn_where_it_is_switched_on(empty, toy) -> None:
    for overlay in overlays.OVERLAYS:
        setattr(empty.footwork.overlays, overlay.name, False)
    context = viewport(empty)
    overlays.draw(context)
    assert toy == []
    empty.footwork.overlays.toy = True
    overlays.draw(viewport(empty, wanted=False))
    assert toy == []
    overlays.draw(context)
    assert toy == [context]


def test_an_entry_paints(empty, monkeypatch) -> None:
    triangle = np.array([[10.0, 10.0], [50.0, 10.0], [10.0, 30.0]])
    entry = Overlay("graph", "", "", True, lambda context: paint(Drawing([(triangle, GREEN)], [], []), 1.0))
    monkeypatch.setattr(overlays, "OVERLAYS", (entry,))
    pixels = helpers.drawn(60, 40, lambda: overlays.draw(viewport(empty)))
    painted = np.abs(pixels - GREEN).max(axis=-1) < 0.01
    assert painted[12, 15] and not painted[28, 45] and painted.sum() == pytest.approx(400, abs=25)


def test_without_an_entry_there_is_no_toggle_left(empty) -> None:
    toggles = [prop.identifier for prop in empty.footwork.overlays.bl_rna.properties]
    assert toggles == ["rna_type", "name", *(overlay.name for overlay in overlays.OVERLAYS)]
    assert "graph" in toggles and "toy" not in toggles

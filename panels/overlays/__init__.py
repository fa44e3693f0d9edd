"""What is drawn over the 3D viewport: an entry in OVERLAYS is an overlay with its toggle in the Quality panel."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import bpy
from bpy.props import BoolProperty, PointerProperty

from ...properties.scene import OVERLAYS_NAME, FOOTWORK_PG_scene, footwork_of
from . import graph


@dataclass(frozen=True, slots=True)
class Overlay:
    """One overlay, and the toggle that a scene keeps for it."""

    name: str
    """Name of the toggle, a property of `scene.footwork.overlays`; never changed once files hold it."""
    label: str
    tooltip: str
    default: bool
    draw: Callable[[bpy.types.Context], None]
    """Draws in a viewport's main region, in pixels from its lower left corner; nothing where it has nothing to show."""
    icon: Any = "OVERLAY"
    """Name of one of Blender's icons."""


OVERLAYS = (
    Overlay(
        "graph",
        "Graph in Viewport",
        "Show body to user, body direction and foot skate over time at the foot of the viewport; "
        "the line across is the value up to which they count as good",
        True,
        graph.draw,
        "GRAPH",
    ),
)
"""Every overlay, in the order of drawing."""

_registered: list[type[bpy.types.PropertyGroup]] = []
_handlers: list[object] = []


def register() -> None:
    """Add the toggles to scenes, and draw in every 3D viewport what is switched on."""
    toggles = {
        overlay.name: BoolProperty(name=overlay.label, description=overlay.tooltip, default=overlay.default)
        for overlay in OVERLAYS
    }
    body = {"__annotations__": toggles, "__doc__": "Which overlays a scene shows."}
    group = type("FOOTWORK_PG_overlays", (bpy.types.PropertyGroup,), body)
    bpy.utils.register_class(group)
    _registered.append(group)
    setattr(FOOTWORK_PG_scene, OVERLAYS_NAME, PointerProperty(type=group))
    _handlers.append(bpy.types.SpaceView3D.draw_handler_add(_draw_here, (), "WINDOW", "POST_PIXEL"))


def unregister() -> None:
    """Draw no more, and take the toggles away again."""
    bpy.types.SpaceView3D.draw_handler_remove(_handlers.pop(), "WINDOW")
    delattr(FOOTWORK_PG_scene, OVERLAYS_NAME)
    bpy.utils.unregister_class(_registered.pop())


def toggles_of(scene: bpy.types.Scene) -> bpy.types.PropertyGroup:
    """A scene's toggles, a property under the name of each overlay."""
    return getattr(footwork_of(scene), OVERLAYS_NAME)


def draw(context: bpy.types.Context) -> None:
    """Draw in the context's viewport every overlay that its scene and the viewport want."""
    if not context.space_data.overlay.show_overlays:
        return
    toggles = toggles_of(context.scene)
    for overlay in OVERLAYS:
        if getattr(toggles, overlay.name):
            overlay.draw(context)


def _draw_here() -> None:
    draw(bpy.context)

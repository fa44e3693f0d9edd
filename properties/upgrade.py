"""Settings that an older Footwork saved, brought up to this one: one step for each version, in a list.

A step moves values of properties that are gone to those that took their place. Give a new meaning a new name: a step
must change nothing where nothing old is stored, because a scene has no version before it is saved.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import bpy
from bpy.app.handlers import persistent

from .preferences import preferences_of
from .scene import NAME, OVERLAYS_NAME, FOOTWORK_PG_scene, footwork_of
from .settings_groups import FOOTWORK_PG_bake_settings


def feet_of(locked: Any) -> str:
    """The foot plan that the switch `foot_lock` stood for."""
    return "planted" if locked else "matched"


def to_scene_1(footwork: FOOTWORK_PG_scene) -> None:
    """The graph became one of the overlays, and whether feet are locked a choice of foot plans."""
    move(footwork, "show_graph", getattr(footwork, OVERLAYS_NAME), "graph", bool)
    bake = footwork.bake
    move(bake, "foot_lock", bake, "feet", feet_of)


SCENE_STEPS: tuple[Callable[[Any], None], ...] = (to_scene_1,)
"""The step at index N brings a scene's settings from version N to N + 1."""
PREFERENCES_STEPS: tuple[Callable[[Any], None], ...] = ()
"""The same for the add-on's preferences."""


OLD_BAKE_SETTINGS: dict[str, Callable[[Any, Any], None]] = {
    "foot_lock": lambda bake, locked: setattr(bake, "feet", feet_of(locked)),
}
"""Bake settings of former names, which users' own presets and scripts set: what setting one does now. Blender would
take the value of an unknown name without a word and forget it."""


def move(source: Any, old: str, target: Any, new: str, convert: Callable[[Any], Any]) -> None:
    """Give `new` what `old` held, unless it has a value already; nothing where `old` was at its default.

    The value comes raw: a number for a bool or an enum.
    """
    values = stored(source)
    if values is None or old not in values:
        return
    value = values[old]
    del values[old]
    if not target.is_property_set(new):
        setattr(target, new, convert(value))


def stored(group: Any) -> Any:
    """The raw values by name that Blender keeps of a group, also those of properties that are gone.

    They are the group's custom properties up to 4.5; from 5.0 on they have a place of their own, None while empty.
    """
    return group.bl_system_properties_get() if bpy.app.version >= (5, 0, 0) else group


def upgrade(settings: Any, steps: Sequence[Callable[[Any], None]]) -> None:
    """Take the steps that these settings, which have a `version`, lack."""
    for step in steps[settings.version :]:
        step(settings)
    if settings.version < len(steps):
        settings.version = len(steps)


@persistent
def upgrade_all(*_: object) -> None:
    """Bring every scene of the open file, and the preferences, up to date."""
    for scene in bpy.data.scenes:
        if scene.is_property_set(NAME):
            upgrade(footwork_of(scene), SCENE_STEPS)
    preferences = preferences_of(bpy.context)
    if preferences is not None:
        upgrade(preferences, PREFERENCES_STEPS)


def _handlers() -> list[list[Callable[..., None]]]:
    """When scenes may come that are not up to date; 4.2 does not tell of appended ones before they are saved."""
    handlers = bpy.app.handlers
    imported = [handlers.blend_import_post] if hasattr(handlers, "blend_import_post") else []
    return [handlers.load_post, handlers.save_pre, *imported]


def register() -> None:
    """Upgrade what is opened or appended from now on, and what is open as soon as Blender gives access to it."""
    for name, set_it in OLD_BAKE_SETTINGS.items():
        setattr(FOOTWORK_PG_bake_settings, name, property(fset=set_it))
    for handler in _handlers():
        handler.append(upgrade_all)
    bpy.app.timers.register(upgrade_all, first_interval=0.0)


def unregister() -> None:
    """Upgrade no more."""
    if bpy.app.timers.is_registered(upgrade_all):
        bpy.app.timers.unregister(upgrade_all)
    for handler in _handlers():
        handler.remove(upgrade_all)
    for name in OLD_BAKE_SETTINGS:
        delattr(FOOTWORK_PG_bake_settings, name)

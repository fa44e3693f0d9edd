"""Blender operators, one module a job."""

from pathlib import Path

import bpy

from . import (
    bake,
    clear,
    contacts,
    databases,
    figures,
    job_operator,
    mapping,
    predictor,
    presets,
    recording,
    rig,
    takes,
    try_it,
)

SHIPPED_PRESETS = str(Path(__file__).parents[1])
"""Folder whose `presets` Blender looks through too."""
CLASSES = (
    job_operator.FOOTWORK_OT_cancel_job,
    *takes.CLASSES,
    *contacts.CLASSES,
    *databases.CLASSES,
    *predictor.CLASSES,
    *recording.CLASSES,
    *mapping.CLASSES,
    *rig.CLASSES,
    *bake.CLASSES,
    *try_it.CLASSES,
    *clear.CLASSES,
    *figures.CLASSES,
    *presets.CLASSES,
)


def register() -> None:
    """Add the operators and file handlers to Blender."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.utils.register_preset_path(SHIPPED_PRESETS)
    bpy.app.handlers.load_pre.append(job_operator.end_before_load)
    for handlers, function in clear.HANDLERS:
        handlers.append(function)


def unregister() -> None:
    """Take them away again, and end the job that runs."""
    job_operator.end()
    bpy.app.handlers.load_pre.remove(job_operator.end_before_load)
    for handlers, function in clear.HANDLERS:
        handlers.remove(function)
    bpy.utils.unregister_preset_path(SHIPPED_PRESETS)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)

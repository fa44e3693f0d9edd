"""Blender operators, one module a job."""

import bpy

from . import bake, databases, figures, job_operator, predictor, recording, rig, takes

CLASSES = (
    job_operator.FOOTWORK_OT_cancel_job,
    *takes.CLASSES,
    *databases.CLASSES,
    *predictor.CLASSES,
    *recording.CLASSES,
    *rig.CLASSES,
    *bake.CLASSES,
    *figures.CLASSES,
)


def register() -> None:
    """Add the operators and file handlers to Blender."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    """Take them away again."""
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)

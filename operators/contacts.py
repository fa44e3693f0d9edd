"""Foot contacts of a take: those of a build, and those that were edited on the armature that shows it."""

import bpy
import numpy as np
from numpy.typing import NDArray

from ..bridge import contacts as keyed
from ..bridge.settings import read_settings
from ..core.body.edit import resample
from ..core.database.contact_edits import (
    ContactEdit,
    check_contact_edits,
    edit_contacts,
    find_contact_edits,
    parse_contact_edit,
)
from ..core.database.contacts import detect_contacts, resample_contacts
from ..core.mocap.take import Take
from ..core.settings import DatabaseSettings
from ..properties.rows import FOOTWORK_PG_take
from ..properties.scene import FOOTWORK_PG_scene, footwork_of
from . import paths
from .rows import RowOperator, answers_of, listed, read_take


def edits_of_row(row: FOOTWORK_PG_take) -> list[ContactEdit]:
    """What a row of the list of takes says under Contacts."""
    path = bpy.path.abspath(row.path)
    return [parse_contact_edit(f"{path}:{text}") for text in listed(row.contacts)]


def contacts_to_show(
    take: Take, footwork: FOOTWORK_PG_scene, fps: float, edits: list[ContactEdit]
) -> NDArray[np.bool_]:
    """Contacts `(T, 2)` of a take at `fps`: as detected with the scene's settings, with `edits` over them."""
    settings = read_settings(footwork.database_settings, DatabaseSettings)
    check_contact_edits([take], edits)
    detected = detect_contacts(resample(take.motion, settings.fps), settings)
    return resample_contacts(edit_contacts(detected, edits, settings.fps), settings.fps, fps)


class FOOTWORK_OT_use_edited_contacts(RowOperator, bpy.types.Operator):
    """Take the foot contacts of the selected take from the keys of contact_L and contact_R on its armature"""

    bl_idname = "footwork.use_edited_contacts"
    bl_label = "Use Edited Contacts"
    bl_options = {"REGISTER", "UNDO"}
    what = "take"

    @classmethod
    def refusal(cls, context: bpy.types.Context) -> str:
        row = cls.active(context)
        if row is None:
            return super().refusal(context)
        if paths.absolute(keyed.shown_take(context.object)) != paths.absolute(row.path):
            return f"Select the armature that Show Take in Scene made of {row.name}"
        return ""

    def work(self, context: bpy.types.Context) -> None:
        row, obj = self.active(context), context.object
        assert obj is not None
        take, fps = read_take(bpy.path.abspath(row.path), answers_of(row)), keyed.shown_rate(obj)
        detected = contacts_to_show(take, footwork_of(context.scene), fps, [])
        edits = find_contact_edits(take.name, keyed.read_contacts(obj, len(detected)), detected, fps)
        row.contacts = ", ".join(edit.within_take for edit in edits)
        found = "all contacts are as detected"
        if edits:
            found = f"{len(edits)} stretch{'es' * (len(edits) > 1)} not as detected; build the database to use them"
        self.tell("INFO", f"{take.name}: {found}")


CLASSES = (FOOTWORK_OT_use_edited_contacts,)

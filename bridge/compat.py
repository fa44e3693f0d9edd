"""The one place that knows how Blender's animation API differs between 4.2 and 5.2."""

from __future__ import annotations

import bpy


def _interpolation(name: str) -> int:
    prop = bpy.types.Keyframe.bl_rna.properties["interpolation"]
    assert isinstance(prop, bpy.types.EnumProperty)
    return prop.enum_items[name].value


LINEAR = _interpolation("LINEAR")
"""Number of linear interpolation, for `foreach_set`."""
CONSTANT = _interpolation("CONSTANT")
"""Number of constant interpolation, likewise."""


def ensure_fcurve(
    action: bpy.types.Action, owner: bpy.types.Object, path: str, index: int, group: str
) -> bpy.types.FCurve:
    """The action's F-curve of one property of `owner`, made where it is missing.

    The action must be the one assigned to `owner`; where actions have slots (4.4 on) the owner's is made and assigned.
    """
    if bpy.app.version >= (5, 0, 0):
        return action.fcurve_ensure_for_datablock(owner, path, index=index, group_name=group)
    if bpy.app.version >= (4, 4, 0):
        curve = action.fcurve_ensure_for_datablock(owner, path, index=index)
        if curve.group is None:
            strip = action.layers[0].strips[0]
            assert isinstance(strip, bpy.types.ActionKeyframeStrip)
            bag = strip.channelbag(owner.animation_data.action_slot)
            curve.group = bag.groups.get(group) or bag.groups.new(group)
        return curve
    # the stubs are of a Blender whose actions have no curves of their own any more
    curves = action.fcurves  # pyright: ignore[reportAttributeAccessIssue]
    return curves.find(path, index=index) or curves.new(path, index=index, action_group=group)


def assign_action(owner: bpy.types.Object, action: bpy.types.Action | None, slot: str = "") -> None:
    """Make `action` the owner's, with its slot where actions have slots, so that it plays.

    Args:
        owner: what is animated.
        action: None for none.
        slot: identifier of the slot, where it is not the first that fits.
    """
    data = owner.animation_data_create()
    data.action = action
    if action is None or bpy.app.version < (4, 4, 0):
        return
    named = next((s for s in data.action_suitable_slots if s.identifier == slot), None)
    if named is not None:
        data.action_slot = named
    elif data.action_slot is None and len(data.action_suitable_slots):
        data.action_slot = data.action_suitable_slots[0]


def slot_of(owner: bpy.types.Object) -> str:
    """Identifier of the slot of the owner's action; "" for none, or where actions have no slots."""
    slot = getattr(owner.animation_data, "action_slot", None)
    return "" if slot is None else slot.identifier


def fcurves_of(owner: bpy.types.Object, action: bpy.types.Action | None = None) -> list[bpy.types.FCurve]:
    """The F-curves that animate `owner` through its action, or all those of another action."""
    data = owner.animation_data
    found = action or (None if data is None else data.action)
    if found is None:
        return []
    if bpy.app.version < (4, 4, 0):
        return list(found.fcurves)  # pyright: ignore[reportAttributeAccessIssue]
    return [
        curve
        for layer in found.layers
        for strip in layer.strips
        if isinstance(strip, bpy.types.ActionKeyframeStrip)
        for bag in strip.channelbags
        if action is not None or bag.slot_handle == data.action_slot_handle
        for curve in bag.fcurves
    ]

"""Foot contacts as keys on the armature of a take: seen, edited, used by the build."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from footwork.bridge import compat
from footwork.core.database.sidecar import load_database
from helpers import add_takes

SIDES = "LR"


@pytest.fixture
def walk(empty, demo):
    """The walk in the list of takes."""
    add_takes(demo, "walk.bvh")
    return empty.footwork.takes[0]


def show(path: str) -> bpy.types.Object:
    assert bpy.ops.footwork.import_take("EXEC_DEFAULT", filepath=path) == {"FINISHED"}
    return bpy.context.object


def curve_of(obj: bpy.types.Object, side: str) -> bpy.types.FCurve:
    return next(c for c in compat.fcurves_of(obj) if c.data_path == f'["contact_{side}"]')


def evaluated(obj: bpy.types.Object, frames: int) -> np.ndarray:
    """Contacts `(T, 2)` as the depsgraph has them, from the scene's first frame on."""
    shown = np.empty((frames, 2), dtype=bool)
    for frame in range(frames):
        bpy.context.scene.frame_set(bpy.context.scene.footwork.frame_start + frame)
        now = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
        shown[frame] = [now[f"contact_{side}"] for side in SIDES]
    return shown


def build(folder, name: str) -> np.ndarray:
    """Contacts of a database that the panel's settings give."""
    path = folder / f"{name}.npz"
    assert bpy.ops.footwork.build_database(filepath=str(path)) == {"FINISHED"}
    return load_database(path).poses.contacts


def contact_start(contacts: np.ndarray, column: int) -> int:
    """The first frame of a contact that begins after two seconds."""
    return 121 + int(np.flatnonzero(contacts[121:, column] & ~contacts[120:-1, column])[0])


def test_a_shown_take_has_the_contacts_of_its_database(empty, walk, tmp_path) -> None:
    built = build(tmp_path, "plain")
    empty.footwork.frame_start = 11
    obj = show(walk.path)
    np.testing.assert_array_equal(evaluated(obj, len(built)), built)
    for column, side in enumerate(SIDES):
        curve = curve_of(obj, side)
        assert {key.interpolation for key in curve.keyframe_points} == {"CONSTANT"}
        # a key at the start and one wherever the foot comes down or leaves
        assert len(curve.keyframe_points) == 1 + np.count_nonzero(np.diff(built[:, column]))
        assert curve.keyframe_points[0].co[0] == 11 and curve.group.name == "Contacts"
        assert "foot is on the ground" in obj.id_properties_ui(f"contact_{side}").as_dict()["description"]
    # at the top of the Dope Sheet
    assert [curve.data_path for curve in compat.fcurves_of(obj)[:2]] == ['["contact_L"]', '["contact_R"]']
    # a stricter detection shows other contacts
    empty.footwork.database_settings.contact_speed = 0.02
    assert not np.array_equal(evaluated(show(walk.path), len(built)), built)


def test_edited_keys_reach_the_database(empty, walk, tmp_path) -> None:
    empty.footwork.database_settings.mirror = True
    plain = build(tmp_path, "plain")
    half = len(plain) // 2
    obj = show(walk.path)
    assert bpy.ops.footwork.use_edited_contacts() == {"FINISHED"} and walk.contacts == ""

    # the left foot comes down a tenth of a second earlier
    left = contact_start(plain[:half], 0)
    (key,) = [key for key in curve_of(obj, "L").keyframe_points if round(key.co[0]) == 1 + left]
    key.co[0] -= 6
    curve_of(obj, "L").update()
    # the right foot is lifted for half a second of standing at the end, keyed as a user does
    for frame, state in ((half - 60, False), (half - 30, True)):
        obj["contact_R"] = state
        obj.keyframe_insert('["contact_R"]', frame=1 + frame)
    assert plain[half - 61 : half, 1].all()
    expected = plain[:half].copy()
    expected[left - 6 : left, 0] = True
    expected[half - 60 : half - 30, 1] = False
    np.testing.assert_array_equal(evaluated(obj, half), expected)

    actions, objects = len(bpy.data.actions), len(bpy.data.objects)
    assert bpy.ops.footwork.use_edited_contacts() == {"FINISHED"}
    assert (len(bpy.data.actions), len(bpy.data.objects)) == (actions, objects)
    first, second = walk.contacts.split(", ")
    assert first.startswith(f"L:planted:{round((left - 6) / 60, 3):g}-")
    assert second == f"R:lifted:{(half - 60) / 60:g}-{(half - 30) / 60:g}"
    edited = build(tmp_path, "edited")
    np.testing.assert_array_equal(edited, np.concatenate([expected, expected[:, ::-1]]))

    # shown again, with the edits; used again, they stay
    text = walk.contacts
    again = show(walk.path)
    np.testing.assert_array_equal(evaluated(again, half), expected)
    assert bpy.ops.footwork.use_edited_contacts() == {"FINISHED"} and walk.contacts == text
    # and back to what is detected
    walk.contacts = ""
    show(walk.path)
    assert bpy.ops.footwork.use_edited_contacts() == {"FINISHED"} and walk.contacts == ""
    np.testing.assert_array_equal(build(tmp_path, "back"), plain)


def test_a_scene_of_another_rate(empty, walk, tmp_path) -> None:
    empty.render.fps, empty.footwork.frame_start = 24, 101
    plain = build(tmp_path, "plain")
    obj = show(walk.path)
    assert bpy.ops.footwork.use_edited_contacts() == {"FINISHED"} and walk.contacts == ""
    # the left foot stays in the air between 4 and 5 seconds
    for frame in range(96, 121):
        obj["contact_L"] = frame == 120 and bool(plain[300, 0])
        obj.keyframe_insert('["contact_L"]', frame=101 + frame)
    empty.render.fps = 60  # keys stay at their frames
    assert bpy.ops.footwork.use_edited_contacts() == {"FINISHED"}
    edited = build(tmp_path, "edited")
    assert plain[240:300, 0].any() and not edited[240:300, 0].any()
    np.testing.assert_array_equal(edited[:, 1], plain[:, 1])
    # at the ends of what was changed, the scene's frames are as near as it gets
    assert np.count_nonzero(np.delete(edited[:, 0] != plain[:, 0], slice(240, 300))) <= 4


def test_contacts_typed_by_hand(empty, walk, tmp_path) -> None:
    plain = build(tmp_path, "plain")
    walk.contacts = "L:lifted:0.5-1, R:planted:4-5 ,"
    edited = build(tmp_path, "edited")
    expected = plain.copy()
    expected[30:60, 0], expected[240:300, 1] = False, True
    np.testing.assert_array_equal(edited, expected)
    before = len(bpy.data.objects)
    for text, says in (
        ("left:planted:1-2", "the foot is 'left'; write L or R"),
        ("L:planted:1-2, L:lifted:1.5-3", "says the opposite from 1.5 s on"),
        ("L:planted:900-", "the take ends at"),
    ):
        walk.contacts = text
        for operator, options in (
            (bpy.ops.footwork.build_database, {"filepath": str(tmp_path / "no.npz")}),
            (bpy.ops.footwork.import_take, {"filepath": walk.path}),
        ):
            with pytest.raises(RuntimeError, match=says):
                operator(**options)
    assert not (tmp_path / "no.npz").exists() and len(bpy.data.objects) == before


def test_the_button_says_what_it_needs(empty, walk, demo) -> None:
    with pytest.raises(RuntimeError, match="Select the armature that Show Take in Scene made of walk"):
        bpy.ops.footwork.use_edited_contacts()
    # a take that is not in the list is shown all the same
    obj = show(str(demo / "turn.bvh"))
    assert len(curve_of(obj, "L").keyframe_points) > 2
    with pytest.raises(RuntimeError, match="made of walk"):
        bpy.ops.footwork.use_edited_contacts()
    obj = show(walk.path)
    obj.animation_data_clear()
    with pytest.raises(RuntimeError, match="contact_L has no keys; show the take in the scene again"):
        bpy.ops.footwork.use_edited_contacts()
    bpy.ops.footwork.clear_takes()
    with pytest.raises(RuntimeError, match="There is no take in the list"):
        bpy.ops.footwork.use_edited_contacts()


def test_the_armature_knows_its_take_after_saving(empty, walk, demo, tmp_path) -> None:
    """The list's path is absolute then, the armature's relative to the .blend."""
    file = str(tmp_path / "shot.blend")
    bpy.ops.wm.save_as_mainfile(filepath=file)
    name = show(str(demo / "walk.bvh")).name
    add_takes(demo, "walk.bvh")
    bpy.ops.wm.save_mainfile()
    bpy.ops.wm.open_mainfile(filepath=file)
    bpy.context.view_layer.objects.active = bpy.data.objects[name]
    assert len(bpy.context.scene.footwork.takes) == 1
    assert bpy.ops.footwork.use_edited_contacts() == {"FINISHED"}

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from footwork.core.database.build import build_database
from footwork.core.database.clips import Exclusion
from footwork.core.database.contact_edits import (
    ContactEdit,
    check_contact_edits,
    edit_contacts,
    find_contact_edits,
    parse_contact_edit,
)
from footwork.core.errors import InputError
from footwork.core.jobs import run
from footwork.core.mocap.demo import demo_motion
from footwork.core.settings import DatabaseSettings
from hypothesis import given
from hypothesis import strategies as st


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("walk:L:planted:1.2-1.65", ContactEdit("walk", "L", True, 1.2, 1.65)),
        ("walk:R:lifted:2.25-10", ContactEdit("walk", "R", False, 2.25, 10.0)),
        ("walk:R:lifted:-3", ContactEdit("walk", "R", False, 0.0, 3.0)),
        ("walk:R:lifted:3601.017-", ContactEdit("walk", "R", False, 3601.017, math.inf)),
        (r"C:\takes\a-1.bvh: L : planted : 0 - 2 ", ContactEdit(r"C:\takes\a-1.bvh", "L", True, 0.0, 2.0)),
    ],
)
def test_parse(text: str, expected: ContactEdit) -> None:
    assert parse_contact_edit(text) == expected
    assert parse_contact_edit(str(expected)) == expected


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "TAKE:FOOT:STATE:FROM-TO"),
        ("walk", "TAKE:FOOT:STATE:FROM-TO"),
        ("L:planted:1-2", "TAKE:FOOT:STATE:FROM-TO"),
        ("walk:L:planted", "TAKE:FOOT:STATE:FROM-TO"),
        ("walk:L:planted:a-b", "TAKE:FOOT:STATE:FROM-TO"),
        ("walk:L:planted:1", "TAKE:FOOT:STATE:FROM-TO"),
        ("walk:L:planted:.-1", "TAKE:FOOT:STATE:FROM-TO"),
        ("walk:left:planted:1-2", "the foot is 'left'; write L or R"),
        ("walk:L:up:1-2", "the foot is 'up'; write planted or lifted"),
        ("walk:L:planted:2-1", "1 s is not after 2 s"),
        ("walk:L:planted:1-1", "1 s is not after 1 s"),
    ],
)
def test_parse_faults(text: str, says: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_contact_edit(text)
    assert says in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("texts", "says"),
    [
        (["walk:L:planted:0-1"], "no such take; there are turn"),
        (["turn:L:planted:14-15"], r"the take ends at 14\.00 s"),
        (["turn:L:planted:13-15"], r"the take ends at 14\.00 s"),
        (["turn:L:planted:1-3", "turn.bvh:L:lifted:2-4"], r"L:lifted:2-4' says the opposite from 2 s on"),
        (["turn:R:lifted:5-", "turn:R:planted:-6"], r"R:planted:0-6' says the opposite from 5 s on"),
    ],
)
def test_edits_are_checked_against_the_takes(as_take, texts: list[str], says: str) -> None:
    take = as_take(demo_motion("turn"), "turn")
    edits = [parse_contact_edit(text) for text in texts]
    with pytest.raises(InputError, match=says) as caught:
        check_contact_edits([take], edits)
    assert "\n" not in str(caught.value)


def test_edits_that_do_not_contradict(as_take) -> None:
    take = as_take(demo_motion("turn"), "turn")
    texts = [
        "L:planted:1-3",
        "L:planted:2-4",
        "L:lifted:4-5",
        "R:lifted:1-3",
        "R:planted:13-14",
        "L:lifted:9-",
    ]
    check_contact_edits([take], [parse_contact_edit(f"turn:{text}") for text in texts])


def flags(*rows: str) -> np.ndarray:
    """Contacts `(T, 2)` from a line for each foot, `#` for on the ground."""
    return np.array([[letter == "#" for letter in row] for row in rows]).T


def test_contacts_are_as_edited() -> None:
    detected = flags("##....####", "....####..")
    edits = [
        parse_contact_edit(f"a:{text}") for text in ("L:planted:0.3-0.5", "L:lifted:0.8-", "R:lifted:0-0.6")
    ]
    expected = flags("##.##.##..", "......##..")
    np.testing.assert_array_equal(edit_contacts(detected, edits, 10.0), expected)
    # of a part of the take, the same frames
    np.testing.assert_array_equal(edit_contacts(detected[4:9], edits, 10.0, first=4), expected[4:9])
    # and at twice the rate over twice the frames
    twice = edit_contacts(np.repeat(detected, 2, axis=0), edits, 20.0)
    np.testing.assert_array_equal(twice, np.repeat(expected, 2, axis=0))
    np.testing.assert_array_equal(detected, flags("##....####", "....####.."))


def test_what_was_changed_is_found_contact_by_contact() -> None:
    detected = flags("##....####", "....####..")
    wanted = flags("##...#####", "....#.##..")
    assert [edit.within_take for edit in find_contact_edits("a", wanted, detected, 10.0)] == [
        "L:planted:0.5-",
        "R:lifted:0.5-0.6",
    ]
    # a contact that is gone is part of one longer time in the air
    (gone,) = find_contact_edits("a", flags("##....####", ".........."), detected, 10.0)
    assert gone == ContactEdit("a", "R", False, 0.0, math.inf)
    assert find_contact_edits("a", detected, detected, 10.0) == []


CONTACTS = st.lists(st.tuples(st.booleans(), st.booleans()), min_size=1, max_size=60)


@given(CONTACTS, st.data(), st.sampled_from([24.0, 30000 / 1001, 60.0, 120.0, 240.0]))
def test_found_edits_make_what_was_wanted(wanted: list[tuple[bool, bool]], data, fps: float) -> None:
    goal = np.array(wanted)
    detected = np.array(data.draw(st.lists(st.tuples(st.booleans(), st.booleans()), min_size=len(goal))))
    detected = detected[: len(goal)]
    edits = find_contact_edits("a", goal, detected, fps)
    texts = [parse_contact_edit(str(edit)) for edit in edits]
    np.testing.assert_array_equal(edit_contacts(detected, texts, fps), goal)


def still(glide, seconds: float, fps: float = 60.0):
    """A body that stands: both feet are in contact all the time."""
    frames = round(seconds * fps)
    return glide(np.zeros((frames, 2)), np.zeros(frames), fps)


def test_a_database_has_the_contacts_as_edited(as_take, glide) -> None:
    """Through other rates, cuts and the mirror; nothing else of the database changes."""
    settings = DatabaseSettings(mirror=True)
    takes = [as_take(still(glide, 4.0), "a"), as_take(still(glide, 5.0, 30.0), "b")]
    texts = ["a:L:lifted:1.2-1.65", "b.bvh:R:lifted:3-", "b:L:lifted:0.5-2"]
    options = {"name": "x", "exclude": [Exclusion("b", 1.0, 2.5)]}
    plain = run(build_database(takes, settings, **options))
    edits = [parse_contact_edit(text) for text in texts]
    edited = run(build_database(takes, settings, **options, contact_edits=edits))
    # clips: a, b from 2.5 s to its last frame at 4.967 s, and the images of both; b to 1 s is too short
    (a, b) = [clip for clip in edited.clips if not clip.mirrored]
    assert (a.start, a.stop, b.start, b.stop) == (0, 240, 240, 240 + 149)
    expected = np.ones((389, 2), dtype=bool)
    expected[72:99, 0] = False
    expected[240 + 30 : 389, 1] = False
    np.testing.assert_array_equal(edited.poses.contacts, np.concatenate([expected, expected[:, ::-1]]))
    assert plain.poses.contacts.all()
    np.testing.assert_array_equal(edited.features.values, plain.features.values)
    np.testing.assert_array_equal(edited.poses.rotations, plain.poses.rotations)
    assert json.loads(edited.provenance["contacts"]) == texts
    assert json.loads(plain.provenance["contacts"]) == []


def test_feet_are_planted_where_nothing_was_detected(as_take, glide) -> None:
    # at 1 m/s no toe is slow
    slide = np.column_stack([np.zeros(180), np.arange(180) / 60.0])
    take = as_take(glide(slide, np.zeros(180)))
    edits = [parse_contact_edit("takes/walk.bvh:R:planted:0.5-1")]
    database = run(build_database([take], DatabaseSettings(), name="x", contact_edits=edits))
    np.testing.assert_array_equal(np.flatnonzero(database.poses.contacts[:, 1]), np.arange(30, 60))
    assert not database.poses.contacts[:, 0].any()
    assert json.loads(database.provenance["contacts"]) == ["walk.bvh:R:planted:0.5-1"]


def test_a_bad_edit_stops_the_build(as_take, glide) -> None:
    take = as_take(still(glide, 3.0), "a")
    with pytest.raises(InputError, match="no such take"):
        run(
            build_database(
                [take],
                DatabaseSettings(),
                name="x",
                contact_edits=[parse_contact_edit("walk:L:planted:0-1")],
            )
        )

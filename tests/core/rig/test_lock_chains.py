"""Chains of locks that all ask for time: what one step takes must not be given back by the next."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from footwork.core.rig.locks import Lock, give_time
from hypothesis import given, settings
from hypothesis import strategies as st

FPS = 60.0
SHORTEST = 6
"""Frames: 0.1 s."""


def needed(a: Lock, b: Lock) -> float:
    """Seconds of a step that the motion's foot does not make: 0.3 and 0.45 for each metre."""
    return 0.3 + 0.45 * float(np.linalg.norm(b.point - a.point))


def assert_given(before: list[Lock], after: list[Lock]) -> None:
    assert len(after) == len(before)
    for old, new in zip(before, after, strict=True):
        np.testing.assert_array_equal(new.point, old.point)
        assert old.first <= new.first <= new.last <= old.last
        least = min(SHORTEST, old.last - old.first + 1)
        assert new.last - new.first + 1 >= least
    for a, b in pairwise(after):
        spent = all(lock.last - lock.first + 1 <= SHORTEST for lock in (a, b))
        assert (b.first - a.last) / FPS >= needed(a, b) - 1e-9 or spent
        assert b.stands == 1.0


def test_the_second_step_keeps_what_the_first_one_took() -> None:
    places = np.array([[0.0, 0.0, 0.0], [0.3, 0.1, 0.0], [0.2, -0.3, 0.0], [0.6, -0.2, 0.0]])
    spans = [(0, 80), (92, 180), (190, 260), (273, 360)]
    locks = [Lock(first, last, place) for (first, last), place in zip(spans, places, strict=True)]
    given_time = give_time(np.zeros((361, 3)), locks, np.ones(361, np.bool_), FPS)
    assert_given(locks, given_time)
    # a lock in the middle gives on both sides
    for old, new in zip(locks[1:-1], given_time[1:-1], strict=True):
        assert new.first > old.first and new.last < old.last
    assert given_time[0].first == 0 and given_time[-1].last == 360
    # both sides of a gap give the same where both have it
    for (a, b), (c, d) in zip(pairwise(locks), pairwise(given_time), strict=True):
        assert abs((a.last - c.last) - (d.first - b.first)) <= 1


@given(st.data())
@settings(max_examples=60, deadline=None)
def test_every_gap_of_any_chain_has_its_time_or_its_locks_are_spent(data: st.DataObject) -> None:
    count = data.draw(st.integers(2, 6))
    lengths = data.draw(st.lists(st.integers(1, 70), min_size=count, max_size=count))
    gaps = data.draw(st.lists(st.integers(2, 30), min_size=count, max_size=count))
    place = st.floats(-0.4, 0.4)
    locks: list[Lock] = []
    start = 0
    for length, gap in zip(lengths, gaps, strict=True):
        point = np.array([data.draw(place), data.draw(place), 0.0])
        locks.append(Lock(start, start + length - 1, point))
        start += length + gap
    assert_given(locks, give_time(np.zeros((start, 3)), locks, np.ones(start, np.bool_), FPS))


def test_a_step_the_motion_makes_after_one_it_does_not() -> None:
    """Contacts are those of each gap, not of the first one."""
    contacts = np.ones(300, np.bool_)
    contacts[180:215] = False
    points = np.array([[0.0, 0.0, 0.0], [0.2, 0.0, 0.0], [0.9, 0.1, 0.0]])
    path = np.zeros((300, 3))
    path[:, 0] = np.interp(np.arange(300), [180, 215], [0.2, 0.9])
    locks = [Lock(0, 90, points[0]), Lock(100, 179, points[1]), Lock(215, 299, points[2])]
    found = give_time(path, locks, contacts, FPS)
    assert [lock.own for lock in found] == [False, True, False]
    assert (found[1].first - found[0].last) / FPS >= needed(found[0], found[1])
    assert (found[1].last, found[2].first) == (179, 215)

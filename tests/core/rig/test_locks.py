"""Where feet are locked and how they come from lock to lock, on toes whose paths are written down."""

from __future__ import annotations

import numpy as np
import pytest
from footwork.core.rig.locks import Lock, _time, clear, give_time, make_locks, offsets, tilt

FPS, HALFLIFE, UNLOCK = 60.0, 0.1, 0.2
X = np.array([1.0, 0.0, 0.0])


def flags(frames: int, *spans: tuple[int, int]) -> np.ndarray:
    out = np.zeros(frames, np.bool_)
    for first, stop in spans:
        out[first:stop] = True
    return out


def along(values: np.ndarray) -> np.ndarray:
    return values[:, None] * X


def test_points_are_those_of_the_least_squares() -> None:
    rng = np.random.default_rng(3)
    spans = np.array([[0, 40], [61, 100], [110, 190], [215, 240]])
    contacts = flags(240, *spans)
    # between the third and the fourth the motion's foot stands
    contacts[190:215] = True
    path = 0.02 * rng.normal(size=(240, 3))
    found = make_locks(path, spans, contacts, 0.03, 10.0, FPS)
    rows, right = [], []
    for i, (first, stop) in enumerate(spans):
        weight = np.sqrt((stop - first) / FPS)
        rows.append(weight * np.eye(4)[i])
        right.append(weight * path[first:stop, :2].mean(axis=0))
    stiff = [0.5 * min(0.25 * FPS / 22, 1.0) ** 4, 0.5, 4.0]
    for i in range(3):
        way = path[spans[i + 1, 0]] - path[spans[i, 1] - 1] if i < 2 else np.zeros(3)
        rows.append(np.sqrt(stiff[i]) * (np.eye(4)[i + 1] - np.eye(4)[i]))
        right.append(np.sqrt(stiff[i]) * way[:2])
    wanted = np.linalg.lstsq(np.array(rows), np.array(right), rcond=None)[0]
    points = np.stack([lock.point for lock in found])
    np.testing.assert_allclose(points[:, :2], wanted, atol=1e-9)
    np.testing.assert_array_equal(points[:, 2], 0.03)


def test_points_stay_within_the_unlock_distance() -> None:
    # mostly at one end of what a plant can hold: the mean is too far from the other end
    place = np.interp(np.arange(300), [0, 250, 260, 300], [0.0, 0.0, 0.39, 0.39])
    (lock,) = make_locks(along(place), np.array([[0, 300]]), np.ones(300, np.bool_), 0.0, UNLOCK, FPS)
    assert np.abs(place - lock.point[0]).max() <= UNLOCK
    assert lock.point[0] < 0.2


def test_a_step_of_ours_has_the_time_that_its_length_asks_for() -> None:
    there = np.array([0.4, 0.0, 0.0])
    locks = [Lock(0, 99, np.zeros(3)), Lock(115, 300, there)]
    before, lock = give_time(np.zeros((301, 3)), locks, np.ones(301, np.bool_), FPS)
    assert lock.own and lock.stands == 1.0
    assert (lock.first - before.last) / FPS >= 0.3 + 0.45 * 0.4
    assert before.last < 99 and lock.first > 115
    # a plant that is short already gives nothing
    short = [Lock(92, 97, np.zeros(3)), Lock(115, 300, there)]
    before, lock = give_time(np.zeros((301, 3)), short, np.ones(301, np.bool_), FPS)
    assert before.last == 97 and (lock.first - before.last) / FPS >= 0.3 + 0.45 * 0.4


def test_a_quick_slide_of_the_motion_becomes_a_step() -> None:
    place = np.interp(np.arange(200), [100, 107], [0.0, 0.4])
    contacts = flags(200, (0, 100), (107, 200))
    locks = [Lock(0, 99, np.zeros(3)), Lock(107, 199, 0.4 * X)]
    before, lock = give_time(along(place), locks, contacts, FPS)
    assert (lock.first - before.last) / FPS >= 0.29
    toe = along(place) + offsets(along(place), [before, lock], HALFLIFE, FPS)
    speed, bend = (np.abs(np.diff(toe[:, 0], n=n)).max() * FPS**n for n in (1, 2))
    assert speed < 0.6 * 0.4 * FPS / 7 and bend < 40.0


def test_a_stride_keeps_its_time() -> None:
    place = np.interp(np.arange(200), [90, 120], [0.0, 1.2])
    contacts = flags(200, (0, 90), (121, 200))
    locks = [Lock(0, 89, np.zeros(3)), Lock(121, 199, 1.25 * X)]
    before, lock = give_time(along(place), locks, contacts, FPS)
    assert (before.last, lock.first, lock.own) == (89, 121, False)


def test_a_held_toe_is_at_its_lock_and_a_long_way_is_the_motions() -> None:
    rng = np.random.default_rng(1)
    path = np.cumsum(0.002 * rng.normal(size=(400, 3)), axis=0)
    locks = [Lock(50, 100, 0.1 * X), Lock(300, 350, -0.1 * X)]
    toe = path + offsets(path, locks, HALFLIFE, FPS)
    for lock in locks:
        np.testing.assert_allclose(toe[lock.first : lock.last + 1] - lock.point, 0.0, atol=1e-12)
    np.testing.assert_array_equal(toe[150:250], path[150:250])


def test_a_steep_landing_does_not_press_the_foot_down_before() -> None:
    # down from 0.3 m at 1.5 m/s, to a lock at the height where it ends
    frames = np.arange(200)
    path = np.zeros((200, 3))
    path[:, 2] = np.interp(frames, [40, 110, 122], [0.0, 0.3, 0.0])
    locks = [Lock(0, 40, np.zeros(3)), Lock(122, 199, np.zeros(3))]
    away = offsets(path, locks, HALFLIFE, FPS)
    assert np.abs(away[:, 2]).max() < 0.08
    assert np.abs(away[55:105, 2]).max() < 1e-3


def test_a_step_of_ours_goes_straight_whatever_the_motion_does() -> None:
    rng = np.random.default_rng(2)
    path = 0.05 * rng.normal(size=(200, 3))
    locks = [Lock(0, 79, np.zeros(3)), Lock(104, 199, 0.2 * X, 1.0)]
    toe = path + offsets(path, locks, HALFLIFE, FPS)
    np.testing.assert_allclose(toe[:, 1:], 0.0, atol=1e-12)
    # the least jerk from rest to rest
    t = (np.arange(79, 105) - 79) / 25.0
    np.testing.assert_allclose(toe[79:105, 0], 0.2 * (10 * t**3 - 15 * t**4 + 6 * t**5), atol=1e-12)


def test_clearance_keeps_what_is_high_and_lifts_what_is_low() -> None:
    locks = [Lock(0, 9, np.zeros(3)), Lock(50, 60, np.zeros(3))]
    held = np.zeros(61, np.bool_)
    held[:10] = held[50:] = True
    np.testing.assert_allclose(clear(np.where(held, 0.0, 0.1), locks, FPS)[20:40], 0.1, atol=2e-3)
    low = clear(np.where(held, 0.0, -0.03), locks, FPS)
    assert (low >= 0.0).all() and low[30] > 0.015 and (low[held] == 0.0).all()


def test_steps_of_ours_are_higher_the_longer_and_lift_the_heel() -> None:
    def pair(way: float, stands: float) -> list[Lock]:
        return [Lock(0, 9, np.zeros(3)), Lock(35, 60, way * X, stands)]

    heights = [clear(np.zeros(61), pair(way, 1.0), FPS).max() for way in (0.05, 0.2, 0.4)]
    assert 0.03 < heights[0] < heights[1] < heights[2] < 0.1
    assert clear(np.zeros(61), pair(0.4, 0.0), FPS).max() < 0.025
    angle = np.degrees(tilt(pair(0.3, 1.0), 61))
    assert 15.0 < angle.max() < 20.0 and angle.argmax() < 22
    assert (angle[:10] == 0.0).all() and (angle[35:] == 0.0).all()
    assert (tilt(pair(0.3, 0.4), 61) == 0.0).all()


def test_the_beginning_and_the_end_of_a_recording_may_be_in_the_air() -> None:
    path = np.zeros((30, 3))
    for locks in ([], [Lock(10, 20, 0.1 * X)], [Lock(0, 29, X)], [Lock(0, 5, X), Lock(25, 29, X)]):
        assert np.isfinite(offsets(path, locks, HALFLIFE, FPS)).all()
        assert np.isfinite(clear(path[:, 2], locks, FPS)).all()


@pytest.mark.parametrize("way", [0.9, 1.7, 3.0])
def test_a_step_of_the_motion_has_time_to_be_bent_softly(way: float) -> None:
    # the motion's own way is none of the change
    path = np.zeros((60, 3))
    path[40:] = [0.3, -0.2, 0.0]
    change = way * np.array([0.6, -0.8, 0.0])
    start = np.array([1.0, 2.0, 0.03])
    time = _time(path, Lock(0, 20, start), Lock(40, 59, start + path[40] + change))
    # 3 t^2 - 2 t^3 brakes as hard as it sets off
    t = np.linspace(0.0, time, 20001)
    place = way * (3.0 * (t / time) ** 2 - 2.0 * (t / time) ** 3)
    assert np.abs(np.diff(place, 2)).max() / (t[1] ** 2) == pytest.approx(30.0, rel=1e-3)

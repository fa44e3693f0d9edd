"""When feet stand: single plants, and contacts that are divided by steps, on paths whose answer is known."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from footwork.core.rig.footsteps import _Contact, plan_plants
from hypothesis import given
from hypothesis import strategies as st

UNLOCK, FPS = 0.2, 60.0


def plan(
    left: np.ndarray,
    contacts: np.ndarray | None = None,
    right: np.ndarray | None = None,
    right_contacts: np.ndarray | None = None,
    load: np.ndarray | None = None,
    fps: float = FPS,
    unlock: float = UNLOCK,
) -> list[np.ndarray]:
    """Plants of both feet; the right one stands still by default."""
    frames = len(left)
    right = np.zeros((frames, 3)) if right is None else right
    always = np.ones(frames, np.bool_)
    flags = np.stack([always if c is None else c for c in (contacts, right_contacts)], axis=1)
    load = np.full(frames, 0.5) if load is None else load
    return plan_plants([left, right], flags, np.stack([load, 1.0 - load], axis=1), unlock, fps)


def drift(frames: int, way: float) -> np.ndarray:
    """Straight over the ground at even speed."""
    return np.linspace(0.0, way, frames)[:, None] * np.array([0.6, 0.8, 0.0])


def gaps(plants: np.ndarray) -> np.ndarray:
    return plants[1:, 0] - plants[:-1, 1]


def test_a_contact_within_reach_is_one_plant() -> None:
    flags = np.zeros(200, np.bool_)
    flags[20:150] = True
    left, right = plan(drift(200, 0.5), flags)
    assert left.tolist() == [[20, 150]]
    assert right.tolist() == [[0, 200]]


def test_short_gaps_and_short_contacts_change_nothing() -> None:
    flags = np.zeros(120, np.bool_)
    flags[20:60] = True
    flags[40:43] = False
    flags[100:103] = True
    assert plan(np.zeros((120, 3)), flags)[0].tolist() == [[20, 60]]


def test_no_contact_no_plant() -> None:
    none = np.zeros(50, np.bool_)
    assert all(plants.shape == (0, 2) for plants in plan(np.zeros((50, 3)), none, right_contacts=none))


@pytest.mark.parametrize(("way", "plants"), [(0.39, 1), (0.6, 2), (0.75, 2), (1.1, 3)])
def test_as_few_steps_as_possible(way: float, plants: int) -> None:
    # a plant holds a toe over twice the unlock distance; what the toe goes while it steps is nobody's
    found = plan(drift(600, way))[0]
    assert len(found) == plants
    assert found[0, 0] == 0 and found[-1, 1] == 600
    assert ((gaps(found) >= 0.35 * FPS) & (gaps(found) <= 0.5 * FPS)).all()


def test_a_step_comes_between_two_places_of_a_toe() -> None:
    place = np.interp(np.arange(600), [250, 280], [0.0, 0.5])
    found = plan(place[:, None] * np.array([1.0, 0.0, 0.0]))[0]
    assert len(found) == 2
    assert abs(found[0, 1] - 254) < 10 and abs(found[1, 0] - 276) < 10


def test_a_step_waits_for_the_other_foot_to_stand() -> None:
    path = drift(600, 0.5)
    for first in (200, 260, 320):
        stands = np.ones(600, np.bool_)
        stands[first : first + 60] = False
        (left, right) = plan(path, right_contacts=stands)
        assert len(left) == 2
        # over the whole step the other foot is planted
        assert ((right[:, 0] <= left[0, 1]) & (right[:, 1] >= left[1, 0])).any()


def test_both_feet_step_one_after_the_other() -> None:
    path = drift(600, 0.5)
    left, right = plan(path, right=path + np.array([0.2, 0.0, 0.0]))
    assert len(left) == len(right) == 2
    assert left[1, 0] <= right[0, 1] or right[1, 0] <= left[0, 1]


def test_a_step_is_made_while_the_other_foot_bears_the_weight() -> None:
    load = np.ones(600)
    load[330:390] = 0.0
    left, _ = plan(drift(600, 0.5), load=load)
    assert left[0, 1] >= 330 and left[1, 0] <= 390


def test_beside_a_step_of_the_motion_the_foot_comes_late_rather_than_twice() -> None:
    # the toe still slides to its place for 0.1 s after its contact begins
    place = np.interp(np.arange(300), [0, 106], [0.0, 0.9])
    flags = np.zeros(300, np.bool_)
    flags[:50] = flags[100:] = True
    place[:50] = place[100] - 0.9
    slide = np.interp(np.arange(300), [100, 106], [-0.5, 0.0])
    left, _ = plan((np.where(np.arange(300) < 50, place, slide))[:, None] * np.array([1.0, 0.0, 0.0]), flags)
    assert len(left) == 2
    assert 100 < left[1, 0] <= 109 and left[1, 1] == 300


def test_nothing_is_near_enough_for_no_distance() -> None:
    assert len(plan(drift(300, 0.3), unlock=0.0)[0]) == 0


def test_a_long_contact_is_planned_in_time_in_proportion() -> None:
    frames = 400 * 60
    time = np.arange(frames) / 60.0
    path = np.stack([0.15 * np.sin(time / 9.0), 0.3 * np.sin(time / 40.0), 0.0 * time], axis=-1)
    found = plan(path)[0]
    assert ((found[:, 1] - found[:, 0]) <= 120.0 * FPS).all()
    assert (found[1:, 0] - found[:-1, 1]).max() <= 0.8 * FPS


@given(
    seed=st.integers(0, 2**32 - 1),
    fps=st.sampled_from([10.0, 24.0, 30.0, 60.0, 120.0]),
    frames=st.integers(1, 400),
    speed=st.floats(0.0, 1.0),
)
def test_plants_hold_what_they_may_and_steps_have_their_time(
    seed: int, fps: float, frames: int, speed: float
) -> None:
    rng = np.random.default_rng(seed)
    paths = np.cumsum(rng.normal(scale=speed / np.sqrt(fps), size=(2, frames, 3)), axis=1)
    # no flicker: nothing is shorter than 0.2 s
    block = round(0.2 * fps)
    flags = np.repeat(rng.random((frames // block + 1, 2)) < 0.8, block, axis=0)[:frames]
    load = rng.random(frames)
    arguments = [*paths], flags, np.stack([load, 1.0 - load], axis=1), UNLOCK, fps
    found = plan_plants(*arguments)
    for side, plants in enumerate(found):
        for first, stop in plants:
            held = paths[side, first:stop]
            assert np.linalg.norm(np.ptp(held, axis=0)) <= 2.0 * UNLOCK + 1e-9
            assert stop - first >= max(2, round(0.1 * fps))
            assert flags[first:stop, side].all()
        for (_, leave), (arrive, _) in pairwise(plants):
            if flags[leave:arrive, side].all():
                assert arrive - leave >= 0.35 * fps - 1.0
    again = plan_plants(*arguments)
    assert all((a == b).all() for a, b in zip(found, again, strict=True))


def cheapest(
    path: np.ndarray, alone: np.ndarray, load: np.ndarray, fps: float, at_start: bool, at_end: bool
) -> tuple[float, list[list[int]]]:
    """The best of all plans, each written out and its costs added up."""
    stride = max(1, round(0.05 * fps))
    marks = [*range(0, len(path), stride), len(path)]
    shortest, step = max(2, round(0.1 * fps)), round(0.35 * fps)
    quickest = -(-step // stride)

    def late(frames: int) -> float:
        return (frames / (0.15 * fps)) ** 2

    plants = {}
    for i, first in enumerate(marks):
        for j in range(i + 1, len(marks)):
            held = path[first : marks[j]]
            if marks[j] - first >= shortest and np.linalg.norm(np.ptp(held, axis=0)) / 2.0 <= UNLOCK:
                away = (held - held.mean(axis=0))[:, :2]
                plants[i, j] = np.sum(away**2) / UNLOCK**2 / fps

    def onward(i: int, cost: float, plan: list[list[int]]) -> None:
        nonlocal best
        for j in range(i + 1, len(marks)):
            if (i, j) not in plants:
                continue
            so_far, here = cost + plants[i, j], [*plan, [marks[i], marks[j]]]
            end = late(len(path) - marks[j]) + 4.0 * (at_end and marks[j] < len(path))
            best = min(best, (so_far + end, here))
            for k in range(j + quickest, min(j + 2 * quickest + 1, len(marks))):
                air = slice(marks[j], marks[k])
                bad = 4.0 * alone[air].mean() + load[air].mean()
                onward(k, so_far + 4.0 + late(marks[k] - marks[j] - step) + bad, here)

    best: tuple[float, list[list[int]]] = (np.inf, [])
    for i, first in enumerate(marks):
        onward(i, late(first) + 4.0 * (at_start and i > 0), [])
    return best


@pytest.mark.parametrize(("fps", "most"), [(10.0, 26), (40.0, 60)])
@pytest.mark.parametrize(("at_start", "at_end"), [(False, False), (True, False), (False, True), (True, True)])
def test_no_plan_is_better(fps: float, most: int, at_start: bool, at_end: bool) -> None:
    rng = np.random.default_rng(8)
    counts = set()
    for _ in range(25):
        frames = int(rng.integers(most // 2, most))
        time = np.arange(frames) / frames
        # it drifts, and wanders; sometimes a jump near an end
        path = time[:, None] * rng.normal(scale=0.4, size=3) * [1.0, 1.0, 0.1]
        path += np.cumsum(rng.normal(scale=0.1 / fps, size=(frames, 3)), axis=0)
        path[frames - int(rng.integers(0, 4)) :, :2] += rng.normal(scale=0.15, size=2)
        path[: int(rng.integers(0, 4)), :2] += rng.normal(scale=0.15, size=2)
        alone = np.repeat(rng.random(frames // 5 + 1) < 0.3, 5)[:frames]
        load = rng.random(frames)
        _, wanted = cheapest(path, alone, load, fps, at_start, at_end)
        found = _Contact(path, alone, load, UNLOCK, fps).divide(at_start, at_end)
        assert found.tolist() == wanted
        counts.add(len(wanted))
    assert {1, 2} <= counts


def test_lateness_goes_with_the_square() -> None:
    contact = _Contact(drift(60, 0.5), np.zeros(60, np.bool_), np.zeros(60), UNLOCK, FPS)
    costs = contact._lateness(np.array([0, 9, 18, 27]))
    np.testing.assert_allclose(costs, [0.0, 1.0, 4.0, 9.0])

"""One timeline for trackers with clocks of their own, jitter and pauses: against numpy's and scipy's interpolation."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from footwork.core.errors import InputError
from footwork.core.recording.interpolation import blend_positions, blend_rotations, neighbours
from footwork.core.recording.raw import Track
from footwork.core.recording.timeline import Samples, check_pauses, even_out, fill_pauses, join, pause_limit
from scipy.spatial.transform import Rotation, Slerp


def scipy_of(q: np.ndarray) -> Rotation:
    return Rotation.from_quat(np.roll(q, -1, axis=-1))


def track(times: np.ndarray, valid: np.ndarray | None = None, seed: int = 0) -> Track:
    count = len(times)
    positions = np.random.default_rng(seed).normal(size=(count, 3))
    turns = np.roll(Rotation.random(count, random_state=seed).as_quat(), 1, axis=-1).reshape(count, 4)
    return Track(times, positions, turns, np.ones(count, np.bool_) if valid is None else valid)


@pytest.mark.parametrize("count", [2, 3, 40])
def test_values_between_samples_are_scipys_and_held_outside(count: int) -> None:
    rng = np.random.default_rng(count)
    times = np.cumsum(rng.uniform(0.1, 1.0, count))
    at = np.r_[times[0] - 3.0, times, times[-1] + 3.0, rng.uniform(times[0], times[-1], 30)]
    positions = rng.normal(size=(count, 2, 3))
    rotations = np.roll(Rotation.random(2 * count, random_state=1).as_quat(), 1, axis=-1).reshape(count, 2, 4)
    before, share = neighbours(times, at)
    assert (
        (before >= 0).all() and (before <= count - 2).all() and (share >= 0.0).all() and (share <= 1.0).all()
    )
    places, turns = blend_positions(positions, before, share), blend_rotations(rotations, before, share)
    single = blend_positions(positions[:, 1], before, share), blend_rotations(rotations[:, 1], before, share)
    for k in range(2):
        for axis in range(3):
            np.testing.assert_allclose(
                places[:, k, axis], np.interp(at, times, positions[:, k, axis]), atol=1e-12
            )
        expected = Slerp(times, scipy_of(rotations[:, k]))(np.clip(at, times[0], times[-1]))
        assert (expected * scipy_of(turns[:, k]).inv()).magnitude().max() < 1e-7
    np.testing.assert_allclose(single[0], places[:, 1], atol=1e-12)
    np.testing.assert_allclose(single[1], turns[:, 1], atol=1e-12)


@pytest.mark.parametrize(("fps", "limit"), [(64.0, 0.1), (40.0, 0.1), (32.0, 0.125), (4.0, 1.0)])
def test_pauses_are_four_steps_long_and_a_tenth_of_a_second(fps: float, limit: float) -> None:
    times = np.arange(20) / fps
    times[15:] += 5.0
    assert pause_limit(times) == pytest.approx(limit)


def test_a_controller_at_the_headsets_times_is_taken_as_it_is() -> None:
    times = 7.0 + np.arange(9) / 4.0
    head, left, right = (track(times, seed=i) for i in range(3))
    right = replace(right, valid=np.arange(9) % 2 == 0)
    joined = join((head, left, right))
    np.testing.assert_array_equal(joined.times, times - 7.0)
    for i, given in enumerate((head, left, right)):
        np.testing.assert_array_equal(joined.positions[:, i], given.positions)
        np.testing.assert_array_equal(joined.rotations[:, i], given.rotations)
        np.testing.assert_array_equal(joined.valid[:, i], given.valid)


def test_a_controller_with_its_own_clock_is_read_between_its_samples() -> None:
    head = track(np.arange(33) / 4.0)
    own = track(0.125 + np.arange(31) / 4.0, seed=1)
    joined = join((head, own, head))
    for axis in range(3):
        expected = np.interp(head.times, own.times, own.positions[:, axis])
        np.testing.assert_allclose(joined.positions[:, 1, axis], expected, atol=1e-12)
    inside = slice(1, 31)
    expected = Slerp(own.times, scipy_of(own.rotations))(head.times[inside])
    assert (expected * scipy_of(joined.rotations[inside, 1]).inv()).magnitude().max() < 1e-7
    # held for as long as a pause at either end
    assert joined.valid.all()


@pytest.mark.parametrize(("first", "last"), [(1.0, 7.0), (1.25, 6.5), (0.0, 8.0), (3.0, 3.25)])
def test_a_controller_is_valid_as_far_as_a_pause_past_its_ends(first: float, last: float) -> None:
    head = track(np.arange(33) / 4.0)
    own = track(np.arange(first, last + 0.1, 0.25), seed=1)
    joined = join((head, head, own))
    # four steps of a quarter of a second
    expected = (head.times >= first - 1.0) & (head.times <= last + 1.0)
    np.testing.assert_array_equal(joined.valid[:, 2], expected)
    assert joined.valid[:, :2].all()


@pytest.mark.parametrize(("gap", "bridged"), [(0.25, True), (1.0, True), (1.25, False)])
def test_between_samples_of_a_controller_farther_apart_than_a_pause_there_is_nothing(
    gap: float, bridged: bool
) -> None:
    head = track(np.arange(81) / 8.0)
    own = track(np.r_[np.arange(13) / 4.0, 3.0 + gap + np.arange(20) / 4.0], seed=1)
    joined = join((head, own, head))
    inside = (head.times > 3.0) & (head.times < 3.0 + gap)
    covered = head.times <= own.times[-1] + 1.0
    # its own samples are good on both sides of the gap
    np.testing.assert_array_equal(joined.valid[:, 1], covered & (bridged | ~inside))


def test_a_lost_sample_spoils_what_lies_between_it_and_its_neighbours_alone() -> None:
    head = track(np.arange(33) / 8.0)
    own = track(np.arange(17) / 4.0, valid=np.arange(17) != 6, seed=1)
    joined = join((head, own, head))
    np.testing.assert_array_equal(np.flatnonzero(~joined.valid[:, 1]), [11, 12, 13])
    # also where only the last of its samples is lost, or the first
    for lost, expected in ((0, [0, 1]), (16, [31, 32])):
        own = track(np.arange(17) / 4.0, valid=np.arange(17) != lost, seed=1)
        np.testing.assert_array_equal(np.flatnonzero(~join((head, own, head)).valid[:, 1]), expected)


@pytest.mark.parametrize("count", [0, 1])
def test_a_controller_of_less_than_two_samples_is_not_there(count: int) -> None:
    head = track(np.arange(9) / 4.0)
    joined = join((head, head, track(np.full(count, 0.5), seed=1)))
    assert joined.valid[:, :2].all() and not joined.valid[:, 2].any()
    np.testing.assert_array_equal(joined.positions[:, 2], np.zeros((9, 3)))
    np.testing.assert_array_equal(joined.rotations[:, 2], np.tile([1.0, 0, 0, 0], (9, 1)))


def alternating(samples: Samples, share: float) -> np.ndarray:
    """Times early and late in turn by a share of the step."""
    step = samples.times[1]
    return samples.times + share * step * (-1.0) ** np.arange(1, len(samples.times) + 1)


def mean_around(times: np.ndarray, breaks: list[int]) -> np.ndarray:
    """Each time as the mean of up to ten on either side in its run; runs begin at 0 and at `breaks`."""
    out = np.empty_like(times)
    bounds = [0, *breaks, len(times)]
    for first, end in pairwise(bounds):
        for i in range(first, end):
            half = min(i - first, end - 1 - i, 10)
            out[i] = times[i - half : i + half + 1].mean()
    return out


@pytest.mark.parametrize(
    ("count", "share", "evened"), [(41, 0.2, False), (42, 0.2, True), (401, 0.07, False), (401, 0.08, True)]
)
def test_times_that_jitter_by_15_percent_are_evened_out(
    wander, count: int, share: float, evened: bool
) -> None:
    even = wander(count)
    given = replace(even, times=alternating(even, share))
    result, line = even_out(given)
    if not evened:
        assert result is given and line == ""
        return
    # early and late by a share: steps that are longer and shorter by twice that
    assert line == f"timestamps jitter by {2.0 * share * 1000 / 64:.1f} ms: taken as evenly spaced"
    expected = mean_around(given.times, [])
    np.testing.assert_allclose(result.times, expected - expected[0], atol=1e-12)
    assert result.times[0] == 0.0
    np.testing.assert_array_equal(result.positions, even.positions)


def test_pauses_stay_where_times_are_evened_out(wander) -> None:
    even = wander(150)
    times = alternating(even, 0.15)
    times[50:] += 2.0
    times[61:] += 1.0
    result, line = even_out(replace(even, times=times))
    assert line
    expected = mean_around(times, [50, 61])
    np.testing.assert_allclose(result.times, expected - expected[0], atol=1e-9)


def test_evenly_taken_samples_keep_their_times(wander) -> None:
    given = wander(100)
    result, line = even_out(given)
    assert result is given and line == ""


def test_untracked_samples_do_not_tell_whether_times_jitter(wander) -> None:
    even = wander(120)
    positions = even.positions.copy()
    positions[:, 2] = np.random.default_rng(0).normal(size=(120, 3))
    times = alternating(even, 0.2)
    wild = replace(even, times=times, positions=positions)
    assert even_out(wild)[1] == ""
    lost = even.valid.copy()
    lost[:, 2] = False
    assert "jitter" in even_out(replace(wild, valid=lost))[1]
    # with nothing tracked no movement is rougher than another
    assert "jitter" in even_out(replace(wild, valid=np.zeros_like(lost)))[1]


def paused(samples: Samples, pauses: dict[int, float]) -> Samples:
    """With pauses of some seconds before some samples."""
    times = samples.times.copy()
    for at, seconds in pauses.items():
        times[at:] += seconds
    return replace(samples, times=times)


@pytest.mark.parametrize(
    ("fps", "more", "count"), [(64.0, 5, 0), (64.0, 6, 6), (64.0, 64, 64), (16.0, 3, 0), (16.0, 4, 4)]
)
def test_a_pause_is_filled_at_the_usual_rate(wander, fps: float, more: int, count: int) -> None:
    even = wander(100, fps)
    given = paused(even, {40: more / fps})
    result, line = fill_pauses(given)
    if not count:
        assert result is given and line == ""
        return
    assert len(result.times) == 100 + count
    np.testing.assert_allclose(result.times, np.arange(100 + count) / fps, atol=1e-12)
    kept = np.r_[0:40, 40 + count : 100 + count]
    np.testing.assert_array_equal(result.positions[kept], even.positions)
    np.testing.assert_array_equal(result.rotations[kept], even.rotations)
    np.testing.assert_array_equal(result.valid[kept], even.valid)
    filled = slice(40, 40 + count)
    assert not result.valid[filled].any()
    np.testing.assert_array_equal(result.positions[filled], np.zeros((count, 3, 3)))
    np.testing.assert_array_equal(result.rotations[filled], np.tile([1.0, 0, 0, 0], (count, 3, 1)))
    assert line == f"1 pause of {(more + 1) / fps:.2f} s bridged, the longest at {39 / fps:.2f} s"


def test_several_pauses_of_any_length_are_filled(wander) -> None:
    given = paused(wander(100), {20: 0.509, 50: 2.0, 51: 0.25})
    result, line = fill_pauses(given)
    steps = np.diff(result.times)
    assert steps.min() > 0.9 / 64 and steps.max() < 1.1 / 64
    assert set(given.times) <= set(result.times)
    np.testing.assert_array_equal(result.times[result.valid.all(axis=1)], given.times)
    assert (
        line
        == f"3 pauses of {0.509 + 2.0 + 0.25 + 3 / 64:.2f} s bridged, the longest at {given.times[49]:.2f} s"
    )


def test_ten_minutes_are_the_longest_pause(wander) -> None:
    even = wander(12, 2.0)
    result, _ = fill_pauses(paused(even, {5: 599.5}))
    assert len(result.times) == 12 + 1199
    with pytest.raises(InputError, match=r"^f: time jumps by 600.5 s after 2\.00 s; cut it there$"):
        check_pauses(paused(even, {5: 600.0, 9: 100.0}).times, "f")

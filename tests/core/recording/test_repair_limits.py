"""What counts as frozen, as a jump, as a pose, and how gaps are bridged: just within the limits and just past them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from footwork.core.errors import InputError
from footwork.core.maths import quat
from footwork.core.recording.happenings import in_words
from footwork.core.recording.repair import Repaired, repair
from footwork.core.recording.timeline import Samples
from scipy.spatial.transform import Rotation, Slerp

FPS = 64.0
NAMES = ("headset", "left controller", "right controller")


@pytest.fixture
def repaired(as_raw) -> Callable[..., Repaired]:
    return lambda samples, **more: repair(as_raw(samples, **more), "f")


def lost(result: Repaired, tracker: int) -> list[int]:
    return np.flatnonzero(~result.samples.valid[:, tracker]).tolist()


@pytest.mark.parametrize("tracker", [0, 1, 2])
@pytest.mark.parametrize(("steps", "frozen"), [(31, False), (32, True), (50, True)])
def test_half_a_second_without_any_movement_is_frozen(
    wander, repaired, tracker: int, steps: int, frozen: bool
) -> None:
    given = wander(200)
    given.positions[100 : 101 + steps, tracker] = given.positions[100, tracker]
    result = repaired(given)
    # the sample before it stood still was tracked
    assert lost(result, tracker) == (list(range(101, 101 + steps)) if frozen else [])
    seconds = f"{steps / FPS:.2f} s frozen, asleep or out of sight"
    assert result.repairs == ((f"{NAMES[tracker]}: {seconds}",) if frozen else ())
    for other in {0, 1, 2} - {tracker}:
        assert lost(result, other) == []
    # at the beginning nothing tells that it was ever tracked, at the end it is like anywhere
    given = wander(200)
    given.positions[: 1 + steps, tracker] = given.positions[0, tracker]
    assert lost(repaired(given), tracker) == (list(range(1 + steps)) if frozen else [])
    given = wander(200)
    given.positions[199 - steps :, tracker] = given.positions[199, tracker]
    assert lost(repaired(given), tracker) == (list(range(200 - steps, 200)) if frozen else [])


@pytest.mark.parametrize("mover", [0, 2])
@pytest.mark.parametrize(("moved", "frozen"), [(0.0009, False), (0.0011, True)])
def test_a_tracker_is_frozen_while_another_moves_by_a_millimetre(
    wander, repaired, mover: int, moved: float, frozen: bool
) -> None:
    given = wander(65)
    given.positions[:] = given.positions[0]
    given.positions[:, mover, 1] += np.linspace(0.0, moved, 65)
    result = repaired(given)
    assert lost(result, 1) == (list(range(65)) if frozen else [])
    assert lost(result, mover) == []


def test_the_movement_of_what_is_not_tracked_does_not_count(wander, repaired) -> None:
    given = wander(65)
    given.positions[:] = given.positions[0]
    given.positions[30:40, 2, 0] += np.linspace(0.0, 0.2, 10)
    given.valid[30:40, 2] = False
    result = repaired(given)
    assert lost(result, 1) == [] and lost(result, 2) == list(range(30, 40))
    given.valid[:, 2] = False
    assert lost(repaired(given), 1) == []


@pytest.mark.parametrize("at", [1, 64])
def test_the_first_and_the_last_step_count_as_movement(wander, repaired, at: int) -> None:
    given = wander(65)
    tremor = np.random.default_rng(0).normal(scale=1e-5, size=(65, 3))
    given.positions[:] = given.positions[0]
    given.positions[:, 2] += tremor
    assert lost(repaired(given), 1) == []
    given.positions[at:, 2] += 0.002
    result = repaired(given)
    assert lost(result, 1) == list(range(65)) and lost(result, 2) == []


def test_nothing_tells_that_the_only_tracked_one_is_frozen(wander, repaired) -> None:
    given = wander(200)
    given.positions[100:151, 1] = given.positions[100, 1]
    given.valid[100:151, [0, 2]] = False
    assert lost(repaired(given), 1) == []


def test_two_stretches_of_standing_still_are_told_together(wander, repaired) -> None:
    given = wander(300)
    for first in (50, 150):
        given.positions[first : first + 41, 2] = given.positions[first, 2]
    result = repaired(given)
    assert lost(result, 2) == [*range(51, 91), *range(151, 191)]
    assert result.repairs == (f"right controller: {80 / FPS:.2f} s frozen, asleep or out of sight",)
    (happening,) = result.happenings
    assert (happening.kind, happening.tracker) == ("lost", 2)
    # until the next tracked sample
    np.testing.assert_allclose([happening.starts, happening.stops], np.array([[51, 151], [91, 191]]) / FPS)


def test_a_sample_that_was_lost_ends_standing_still(wander, repaired) -> None:
    given = wander(200)
    given.positions[100:140, 1] = given.positions[100, 1]
    given.valid[120, 1] = False
    assert lost(repaired(given), 1) == [120]


def test_what_a_believed_file_says_is_only_doubted(wander, repaired) -> None:
    given = wander(500)
    given.positions[100:461, 1] = given.positions[100, 1]
    result = repaired(given, states_validity=True)
    assert lost(result, 1) == [] and result.repairs == ()
    (happening,) = result.happenings
    assert (happening.kind, happening.tracker) == ("still", 1)
    np.testing.assert_allclose([happening.starts, happening.stops], [[101 / FPS], [461 / FPS]])


def test_lost_at_the_end_lasts_a_step_longer_than_the_last_sample(wander, repaired) -> None:
    given = wander(100)
    given.valid[90:, 2] = False
    (happening,) = repaired(given).happenings
    np.testing.assert_allclose([happening.starts, happening.stops], [[90 / FPS], [100 / FPS]])
    assert in_words([happening], 99 / FPS) == (
        f"right controller not tracked for {10 / FPS:.1f} of {99 / FPS:.1f} s",
    )


def shifted(samples: Samples, tracker: int, first: int, last: int, metres: float) -> Samples:
    """Trackers hold still but for one that is elsewhere for some samples; tremor keeps them from being frozen."""
    tremor = np.random.default_rng(0).normal(scale=1e-5, size=samples.positions.shape)
    positions = samples.positions[:1] + tremor
    positions[first:last, tracker] += metres * np.array([0.48, -0.6, 0.64])
    return replace(samples, positions=positions)


@pytest.mark.parametrize(("tracker", "speed"), [(0, 10.0), (1, 40.0), (2, 40.0)])
@pytest.mark.parametrize(("share", "jumps"), [(0.99, False), (1.01, True)])
def test_jumps_are_faster_than_people(
    wander, repaired, tracker: int, speed: float, share: float, jumps: bool
) -> None:
    given = shifted(wander(200), tracker, 100, 200, share * speed / FPS)
    result = repaired(given)
    found = [(item.kind, item.tracker) for item in result.happenings if item.kind == "jump"]
    assert found == ([("jump", tracker)] if jumps else [])
    if jumps:
        (jump, *_) = result.happenings
        np.testing.assert_allclose([jump.starts, jump.stops], [[99 / FPS], [99 / FPS]])
    # a hand was lost for 0.15 s before
    assert lost(result, tracker) == (list(range(90, 100)) if jumps and tracker else [])
    assert result.repairs == ()


@pytest.mark.parametrize("tracker", [0, 1, 2])
@pytest.mark.parametrize(("samples", "glitch"), [(1, True), (30, True), (31, False)])
def test_a_glitch_is_over_within_half_a_second(
    wander, repaired, tracker: int, samples: int, glitch: bool
) -> None:
    given = shifted(wander(200), tracker, 100, 100 + samples, 2.0)
    result = repaired(given)
    jumps = [item for item in result.happenings if item.kind == "jump"]
    if glitch:
        assert lost(result, tracker) == list(range(100, 100 + samples)) and not jumps
        assert result.repairs == (f"{NAMES[tracker]}: {samples / FPS:.2f} s off its path",)
    else:
        assert len(jumps) == 1 and result.repairs == ()
        np.testing.assert_allclose(jumps[0].starts, [99 / FPS, (99 + samples) / FPS])


@pytest.mark.parametrize(("rest", "glitch"), [(0.9, True), (1.1, False)])
def test_a_glitch_comes_back_at_least_halfway(wander, repaired, rest: float, glitch: bool) -> None:
    given = shifted(wander(200), 2, 100, 110, 2.0)
    given = replace(given, positions=given.positions.copy())
    given.positions[110:, 2] += rest * np.array([0.48, -0.6, 0.64])
    jumps = [item for item in repaired(given).happenings if item.kind == "jump"]
    assert bool(jumps) != glitch


def test_several_glitches_and_a_jump_for_good(wander, repaired) -> None:
    given = shifted(wander(400), 1, 50, 52, 3.0)
    for first, last in ((150, 170), (300, 301), (350, 400)):
        given.positions[first:last, 1] += np.array([0.0, 3.0, 0.0])
    result = repaired(given)
    (jump,) = [item for item in result.happenings if item.kind == "jump"]
    np.testing.assert_allclose(jump.starts, [349 / FPS])
    assert lost(result, 1) == [50, 51, *range(150, 170), 300, *range(340, 350)]
    assert result.repairs == (f"left controller: {23 / FPS:.2f} s off its path",)


def test_movement_while_not_tracked_is_no_jump_if_there_was_time_for_it(wander, repaired) -> None:
    for gap, jumps in ((2, True), (6, False)):
        given = shifted(wander(200), 1, 100, 200, 2.0)
        given.valid[100 - gap : 100, 1] = False
        kinds = [item.kind for item in repaired(given).happenings]
        assert ("jump" in kinds) == jumps


def turned(q: np.ndarray) -> Rotation:
    return Rotation.from_quat(np.roll(q, -1, axis=-1))


@pytest.mark.parametrize("tracker", [0, 1, 2])
def test_gaps_are_bridged_by_lines_and_arcs_for_hands_from_the_headset(
    wander, repaired, tracker: int
) -> None:
    given = wander(120)
    gone = [*range(5), *range(30, 45), 60, *range(100, 120)]
    given.valid[gone, tracker] = False
    truth = given.positions.copy()
    given.positions[gone, tracker] = 99.0
    given.rotations[gone, tracker] = [0.5, 0.5, 0.5, 0.5]
    result = repaired(given).samples
    assert lost(Repaired(result, (), ()), tracker) == gone
    known = np.setdiff1d(np.arange(120), gone)
    base = truth[:, 0] if tracker else np.zeros((120, 3))
    for axis in range(3):
        relative = np.interp(given.times, given.times[known], (truth[:, tracker] - base)[known, axis])
        np.testing.assert_allclose(result.positions[:, tracker, axis], base[:, axis] + relative, atol=1e-12)
    slerp = Slerp(given.times[known], turned(given.rotations[known, tracker]))
    expected = slerp(np.clip(given.times, given.times[known[0]], given.times[known[-1]]))
    assert (expected * turned(result.rotations[:, tracker]).inv()).magnitude().max() < 1e-7
    assert (np.sum(result.rotations[1:] * result.rotations[:-1], axis=-1) > 0.0).all()
    others = [i for i in range(3) if i != tracker]
    np.testing.assert_array_equal(result.positions[:, others], truth[:, others])


@pytest.mark.parametrize("seen", [0, 40, 79])
def test_a_hand_seen_once_goes_with_the_headset(wander, repaired, seen: int) -> None:
    given = wander(80)
    given.valid[:, 2] = np.arange(80) == seen
    away = given.positions[seen, 2] - given.positions[seen, 0]
    rotation = given.rotations[seen, 2].copy()
    result = repaired(given).samples
    np.testing.assert_allclose(result.positions[:, 2], given.positions[:, 0] + away, atol=1e-12)
    np.testing.assert_allclose(np.abs(result.rotations[:, 2] @ rotation), 1.0, atol=1e-12)


def test_hands_that_were_never_seen_hang_at_the_hips(wander, repaired) -> None:
    given = wander(80)
    yaws = np.linspace(-2.0, 2.0, 80)
    given.rotations[:, 0] = quat.from_yaw(yaws)
    given.valid[:, 1:] = False
    result = repaired(given).samples
    facing = Rotation.from_euler("z", yaws[:, None])
    for i, side in ((1, -0.22), (2, 0.22)):
        expected = given.positions[:, 0] + facing.apply([side, 0.10, -0.75])
        np.testing.assert_allclose(result.positions[:, i], expected, atol=1e-12)
        assert (turned(result.rotations[:, i]) * facing.inv()).magnitude().max() < 1e-7


NAN = float("nan")


@pytest.mark.parametrize(
    ("position", "rotation", "fine"),
    [
        ((0.0, 0.0, 1e-9), (1.0, 0.0, 0.0, 0.0), True),
        ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), False),
        ((0.3, 0.2, 1.0), (0.0, 0.0, 0.0, 0.0), False),
        ((0.3, 0.2, 1.0), (0.0, 0.06, 0.0, -0.079), False),
        ((0.3, 0.2, 1.0), (0.0, 0.06, 0.0, -0.081), True),
        ((0.3, 0.2, 1.0), (7.0, 0.0, 2.0, 5.0), True),
        ((0.3, NAN, 1.0), (1.0, 0.0, 0.0, 0.0), False),
        ((0.3, 0.2, 1.0), (1.0, NAN, 0.0, 0.0), False),
        ((float("inf"), 0.2, 1.0), (1.0, 0.0, 0.0, 0.0), False),
        ((0.3, 0.2, -1.0e4), (1.0, 0.0, 0.0, 0.0), False),
        ((0.3, 0.2, 1.0), (1.0, 0.0, 0.0, 2e4), False),
    ],
)
@pytest.mark.parametrize("tracker", [0, 2])
def test_what_is_a_pose_and_what_is_none(
    wander, repaired, position: tuple[float, ...], rotation: tuple[float, ...], fine: bool, tracker: int
) -> None:
    given = wander(60)
    given.positions[:, tracker] += position - given.positions[20, tracker]
    given.positions[20, tracker], given.rotations[20, tracker] = position, rotation
    given.positions[np.isnan(given.positions) | (np.abs(given.positions) > 1e3)] = 0.25
    given.positions[20, tracker] = position
    result = repaired(given)
    assert lost(result, tracker) == ([] if fine else [20])
    assert result.repairs == (() if fine else (f"{NAMES[tracker]}: 1 sample without a pose",))
    assert np.isfinite(result.samples.positions).all()
    np.testing.assert_allclose(np.linalg.norm(result.samples.rotations, axis=-1), 1.0, atol=1e-12)


def test_samples_are_counted_for_each_tracker_or_for_all(wander, repaired) -> None:
    given = wander(60)
    given.positions[10:12] = 0.0
    assert repaired(given).repairs == ("all trackers: 2 samples without a pose",)
    given.positions[20, 2] = 0.0
    assert repaired(given).repairs == (
        "headset: 2 samples without a pose",
        "left controller: 2 samples without a pose",
        "right controller: 3 samples without a pose",
    )
    # those that the file itself calls lost are not repaired
    given = wander(60)
    given.positions[10, 1], given.valid[10, 1] = 0.0, False
    assert repaired(given).repairs == ()


def test_times_that_are_none_or_repeat_are_dropped_for_each_tracker(wander, as_raw) -> None:
    raw = as_raw(wander(60))
    raw.tracks[0].times[10] = np.nan
    raw.tracks[0].times[20] = raw.tracks[0].times[19]
    raw.tracks[2].times[5] = raw.tracks[2].times[2]
    result = repair(raw, "f")
    assert result.repairs[:2] == (
        "headset: 2 samples at repeated or earlier times dropped",
        "right controller: 1 sample at repeated or earlier times dropped",
    )
    assert len(result.samples.times) == 58


@pytest.mark.parametrize(("fps", "fine"), [(2.0, True), (1.9, False), (4096.0, True), (5100.0, False)])
def test_rates_of_recorders(wander, repaired, fps: float, fine: bool) -> None:
    given = wander(30, fps)
    # slow enough for any rate
    given = replace(given, positions=given.positions[:1] + 1e-4 * np.arange(30)[:, None, None])
    if fine:
        np.testing.assert_allclose(repaired(given).samples.times, given.times)
        return
    with pytest.raises(InputError, match="samples per second; are its times in another unit") as raised:
        repaired(given)
    assert float(str(raised.value).split()[1]) == pytest.approx(fps)


@pytest.mark.parametrize(("count", "words"), [(0, "0 samples"), (1, "1 sample"), (2, "")])
def test_a_headset_needs_two_samples(wander, repaired, count: int, words: str) -> None:
    given = wander(2)
    given.valid[count:, 0] = False
    if words:
        with pytest.raises(InputError, match=f"^f: {words} of the headset can be used; record it again$"):
            repaired(given)
        return
    result = repaired(given)
    np.testing.assert_array_equal(result.samples.times, given.times)
    np.testing.assert_array_equal(result.samples.positions, given.positions)

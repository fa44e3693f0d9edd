"""Repair: faults put into clean recordings, found, told and bridged near the truth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.errors import InputError
from footwork.core.maths import quat
from footwork.core.mocap.demo import demo_motion
from footwork.core.recording.eye_height import (
    calibrate,
    headset_standing_height,
    looking_ahead,
    put_down,
)
from footwork.core.recording.happenings import in_words
from footwork.core.recording.mounts import grip_mounts
from footwork.core.recording.raw import RawRecording, Track
from footwork.core.recording.recording import Recording
from footwork.core.recording.repair import Repaired, repair
from footwork.core.recording.simulate import simulate_recording
from footwork.core.recording.timeline import Samples


def doubts(result: Repaired) -> tuple[str, ...]:
    return in_words(result.happenings, float(result.samples.times[-1]))


@pytest.fixture(scope="module")
def clean() -> Recording:
    recording = simulate_recording(demo_motion("visit", 5), "visit")
    # the demo's hands can stand perfectly still, which no held controller does
    tremor = np.random.default_rng(6).normal(scale=1e-5, size=recording.positions.shape)
    return replace(recording, positions=recording.positions + tremor)


def tracks_of(recording: Recording) -> list[Track]:
    return [
        Track(
            recording.times.copy(),
            recording.positions[:, i].copy(),
            recording.rotations[:, i].copy(),
            recording.valid[:, i].copy(),
        )
        for i in range(3)
    ]


def raw(tracks: list[Track]) -> RawRecording:
    head, left, right = tracks
    return RawRecording((head, left, right), {"format": "test"})


def test_a_clean_recording_is_not_touched(clean: Recording) -> None:
    result = repair(raw(tracks_of(clean)), "f")
    assert result.repairs == doubts(result) == ()
    np.testing.assert_array_equal(result.samples.times, clean.times)
    np.testing.assert_array_equal(result.samples.positions, clean.positions)
    np.testing.assert_allclose(result.samples.rotations, clean.rotations, atol=1e-15)
    assert result.samples.valid.all()


def test_repeated_and_earlier_times_are_dropped(clean: Recording) -> None:
    order = np.r_[0:100, 99, 97, 98, 100 : len(clean)]
    tracks = [
        Track(t.times[order], t.positions[order], t.rotations[order], t.valid[order])
        for t in tracks_of(clean)
    ]
    result = repair(raw(tracks), "f")
    np.testing.assert_array_equal(result.samples.times, clean.times)
    np.testing.assert_array_equal(result.samples.positions, clean.positions)
    assert result.repairs == ("all trackers: 3 samples at repeated or earlier times dropped",)


@pytest.mark.parametrize("what", ["zero quaternion", "nan", "zeros", "not valid"])
def test_poses_that_are_none_are_bridged(clean: Recording, what: str) -> None:
    tracks = tracks_of(clean)
    lost = np.r_[50:58, 200]
    if what == "zero quaternion":
        tracks[1].rotations[lost] = 0.0
    elif what == "nan":
        tracks[1].positions[lost, 1] = np.nan
    elif what == "zeros":
        tracks[1].positions[lost] = 0.0
    else:
        tracks[1].valid[lost] = False
    result = repair(raw(tracks), "f")
    np.testing.assert_array_equal(np.flatnonzero(~result.samples.valid[:, 1]), lost)
    assert result.samples.valid[:, [0, 2]].all()
    away = np.linalg.norm(result.samples.positions - clean.positions, axis=-1)
    assert away[lost, 1].max() < 0.03
    kept = np.setdiff1d(np.arange(len(clean)), lost)
    assert away[kept].max() == 0.0
    assert result.repairs == (() if what == "not valid" else ("left controller: 9 samples without a pose",))


def test_bridges_are_straight_and_on_great_arcs() -> None:
    times = np.arange(40) / 60.0
    still = np.tile([0.0, 0.0, 1.6], (40, 1))
    moving = np.stack([0.02 * np.arange(40), np.zeros(40), np.ones(40)], axis=-1)
    turning = quat.from_axis("Z", 0.05 * np.arange(40))
    valid = np.ones(40, dtype=bool)
    lost = valid.copy()
    lost[10:30] = False
    garbage = np.where(lost[:, None], moving, 7.0)
    wobble = still + 1e-3 * np.sin(np.arange(40))[:, None]
    head = Track(times, wobble, np.tile(quat.IDENTITY, (40, 1)), valid)
    hand = Track(times, garbage, np.where(lost[:, None], turning, [0.0, 1.0, 0.0, 0.0]), lost)
    samples = repair(raw([head, hand, hand]), "f").samples
    np.testing.assert_allclose(samples.positions[:, 1] - wobble, moving - wobble, atol=2.1e-3)
    dots = np.abs(np.sum(samples.rotations[:, 1] * turning, axis=-1))
    np.testing.assert_allclose(dots, 1.0, atol=1e-12)


def test_lost_hands_go_along_with_the_headset() -> None:
    times = np.arange(300) / 60.0
    walk = np.stack([np.zeros(300), times, np.full(300, 1.6)], axis=-1)
    identity = np.tile(quat.IDENTITY, (300, 1))
    valid = np.ones(300, dtype=bool)
    seen = times < 1.0
    hand = walk + np.array([0.2, 0.3, -0.5])
    samples = repair(
        raw([
            Track(times, walk, identity, valid),
            Track(times, np.where(seen[:, None], hand, 0.0), identity, seen),
            Track(times, np.zeros((300, 3)), identity, ~valid),
        ]),
        "f",
    ).samples  # fmt: skip
    np.testing.assert_allclose(samples.positions[:, 1], hand, atol=1e-12)
    hanging = samples.positions[:, 2] - walk
    assert (hanging[:, 0] > 0.1).all() and (np.abs(hanging[:, 2] + 0.75) < 0.1).all()


def test_a_sleeping_controller_is_not_tracked(clean: Recording) -> None:
    tracks = tracks_of(clean)
    asleep = slice(300, 500)
    tracks[2].positions[asleep] = tracks[2].positions[299]
    result = repair(raw(tracks), "f")
    np.testing.assert_array_equal(np.flatnonzero(~result.samples.valid[:, 2]), np.arange(300, 500))
    assert any("right controller" in line and "frozen" in line for line in result.repairs)
    assert any("right controller not tracked for 3.3" in line for line in doubts(result))


def test_a_file_that_states_validity_is_believed_and_doubted(clean: Recording) -> None:
    tracks = tracks_of(clean)
    tracks[2].positions[300:700] = tracks[2].positions[299]
    result = repair(replace(raw(tracks), states_validity=True), "f")
    assert result.samples.valid[300:680].all()
    assert result.repairs == ()
    assert any("right controller stands exactly still for 6.7 s" in line for line in doubts(result))


def test_a_controller_asleep_from_the_beginning_was_never_tracked(clean: Recording) -> None:
    tracks = tracks_of(clean)
    tracks[1].positions[:] = [0.3, 0.4, 0.5]
    result = repair(raw(tracks), "f")
    assert not result.samples.valid[:, 1].any()
    assert any("left controller never tracked" in line for line in doubts(result))


def test_a_whole_person_standing_still_is_tracked() -> None:
    times = np.arange(200) / 60.0
    tracks = [
        Track(times, np.full((200, 3), 1.0 + i), np.tile(quat.IDENTITY, (200, 1)), np.ones(200, bool))
        for i in range(3)
    ]
    assert repair(raw(tracks), "f").samples.valid.all()


@pytest.mark.parametrize("tracker", [0, 1])
def test_a_glitch_that_comes_back_is_bridged(clean: Recording, tracker: int) -> None:
    tracks = tracks_of(clean)
    tracks[tracker].positions[400:405] += [2.0, 0.0, 0.0]
    result = repair(raw(tracks), "f")
    np.testing.assert_array_equal(np.flatnonzero(~result.samples.valid[:, tracker]), np.arange(400, 405))
    assert np.linalg.norm(result.samples.positions - clean.positions, axis=-1).max() < 0.02
    assert any("off its path" in line for line in result.repairs)
    assert not doubts(result)


def test_jumps_for_good_are_doubted(clean: Recording) -> None:
    tracks = tracks_of(clean)
    for track in tracks:
        track.positions[600:] += [0.0, 3.0, 0.0]
    result = repair(raw(tracks), "f")
    assert any(line.startswith("headset jumps once, first at 9.98 s: recentred") for line in doubts(result))
    assert any(line.startswith("left controller jumps once") for line in doubts(result))
    assert result.samples.valid[:, 0].all()
    drifting = np.flatnonzero(~result.samples.valid[:, 1])
    assert drifting[-1] == 599 and 8 <= len(drifting) <= 10


def test_pauses_are_filled_with_untracked_samples(clean: Recording) -> None:
    keep = np.r_[0:200, 260 : len(clean)]
    tracks = [
        Track(t.times[keep], t.positions[keep], t.rotations[keep], t.valid[keep]) for t in tracks_of(clean)
    ]
    result = repair(raw(tracks), "f")
    np.testing.assert_allclose(result.samples.times, clean.times, atol=1e-9)
    np.testing.assert_array_equal(np.flatnonzero(~result.samples.valid.all(axis=1)), np.arange(200, 260))
    assert result.repairs == ("1 pause of 1.02 s bridged, the longest at 3.32 s",)


def test_absurd_pauses_are_an_error(clean: Recording) -> None:
    tracks = tracks_of(clean)
    for track in tracks:
        track.times[100:] += 5000.0
    with pytest.raises(InputError, match=r"time jumps by 5000 s after 1\.65 s"):
        repair(raw(tracks), "f")


@pytest.mark.parametrize("factor", [1000.0, 1e-4])
def test_times_in_another_unit_are_an_error(clean: Recording, factor: float) -> None:
    tracks = [replace(track, times=track.times * factor) for track in tracks_of(clean)]
    with pytest.raises(InputError, match="another unit"):
        repair(raw(tracks), "f")


def test_a_recording_without_a_headset_is_an_error(clean: Recording) -> None:
    tracks = tracks_of(clean)
    tracks[0].valid[1:] = False
    with pytest.raises(InputError, match="1 sample of the headset"):
        repair(raw(tracks), "f")


def test_jittering_stamps_of_even_samples_are_evened_out(clean: Recording) -> None:
    rng = np.random.default_rng(3)
    tracks = tracks_of(clean)
    stamps = clean.times + rng.uniform(-0.006, 0.006, len(clean))
    tracks = [replace(track, times=stamps) for track in tracks]
    result = repair(raw(tracks), "f")
    times = result.samples.times - result.samples.times.mean() + clean.times.mean()
    assert np.abs(times[20:-20] - clean.times[20:-20]).max() < 0.003
    assert (np.diff(result.samples.times) > 0.0).all()
    assert any("jitter" in line for line in result.repairs)


def test_samples_really_taken_unevenly_keep_their_times(clean: Recording) -> None:
    rng = np.random.default_rng(3)
    keep = np.cumsum(rng.integers(1, 4, len(clean) // 3))
    tracks = [
        Track(t.times[keep], t.positions[keep], t.rotations[keep], t.valid[keep]) for t in tracks_of(clean)
    ]
    result = repair(raw(tracks), "f")
    assert not any("jitter" in line for line in result.repairs)
    np.testing.assert_allclose(result.samples.times, clean.times[keep] - clean.times[keep[0]], atol=1e-12)


def standing(heights: np.ndarray) -> Samples:
    count = len(heights)
    rng = np.random.default_rng(0)
    positions = np.zeros((count, 3, 3))
    positions[:, 0, 2] = heights + 0.004 * np.sin(np.arange(count) / 20) + 1e-4 * rng.normal(size=count)
    rotations = np.tile(quat.IDENTITY, (count, 3, 1))
    return Samples(np.arange(count) / 60.0, positions, rotations, np.ones((count, 3), bool))


@pytest.mark.parametrize(
    ("stretches", "expected"),
    [
        ([(1.62, 10.0)], 1.62),
        ([(1.62, 10.0), (1.70, 1.0)], 1.62),
        ([(1.62, 4.0), (1.0, 14.0)], 1.62),
        ([(1.62, 6.0), (0.8, 3.0), (1.62, 6.0)], 1.62),
    ],
)
def test_headset_standing_height(stretches: list[tuple[float, float]], expected: float) -> None:
    heights = np.concatenate([np.full(int(60 * seconds), height) for height, seconds in stretches])
    assert headset_standing_height(standing(heights)) == pytest.approx(expected, abs=0.012)


def test_calibration_says_where_it_comes_from() -> None:
    samples = standing(np.full(600, 1.6))
    assert calibrate(samples, 1.7, 1.5, True).eye_height == 1.7
    assert calibrate(samples, None, 1.5, True).eye_height == 1.5
    assert calibrate(samples, None, None, True).eye_height == pytest.approx(1.6, abs=0.01)
    assert calibrate(samples, 1.7, None, False).lift == pytest.approx(0.1, abs=0.01)
    assert any("check unit and floor" in line for line in calibrate(samples, 1.2, None, True).doubts)
    child = calibrate(standing(np.full(600, 0.5)), None, None, True)
    assert any("implausible" in line for line in child.doubts)


def test_a_headset_taken_off() -> None:
    samples = standing(np.r_[np.full(600, 1.6), np.full(300, 0.9)])
    samples.positions[600:, 0, 2] = 0.9
    assert put_down(samples) == 10.0
    assert put_down(standing(np.full(600, 1.6))) is None


def test_looking_down_makes_nobody_smaller() -> None:
    upright = standing(np.full(600, 1.6))
    bowed = replace(upright, rotations=upright.rotations.copy(), positions=upright.positions.copy())
    pitch = np.radians(-40.0)
    bowed.rotations[:, 0] = quat.from_axis("X", pitch)
    # closed form: the headset sits 8 cm ahead of and 9 cm above the joint that turns
    bowed.positions[:, 0, 1] += 0.08 * np.cos(pitch) - 0.09 * np.sin(pitch) - 0.08
    bowed.positions[:, 0, 2] += 0.08 * np.sin(pitch) + 0.09 * np.cos(pitch) - 0.09
    mounts = grip_mounts(head=(0.0, 0.08, 0.09), reach=0.1, pitch=0.0)
    assert headset_standing_height(looking_ahead(bowed, mounts)) == pytest.approx(1.6, abs=0.001)

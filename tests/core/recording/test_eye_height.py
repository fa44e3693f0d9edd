"""Eye height: what is believed first, what is doubted, when a headset was put down."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.maths import quat
from footwork.core.recording.eye_height import calibrate, headset_standing_height, looking_ahead, put_down
from footwork.core.recording.mounts import DEVICE_MOUNTS
from footwork.core.recording.timeline import Samples
from scipy.spatial.transform import Rotation


def at_heights(heights: np.ndarray, fps: float = 64.0) -> Samples:
    """A headset at given heights over one place; hands somewhere."""
    count = len(heights)
    positions = np.tile([0.3, -0.2, 1.0], (count, 3, 1))
    positions[:, 0, 2] = heights
    return Samples(
        np.arange(count) / fps,
        positions,
        np.tile(quat.IDENTITY, (count, 3, 1)),
        np.ones((count, 3), np.bool_),
    )


STANDING = at_heights(np.full(128, 1.6))


@pytest.mark.parametrize(
    ("given", "stated", "on_floor", "height", "source", "lift"),
    [
        (1.7, 1.5, True, 1.7, "given", 0.0),
        (1.7, 1.5, False, 1.7, "given", 0.1),
        (1.7, None, True, 1.7, "given", 0.0),
        (None, 1.5, True, 1.5, "stated in the file", 0.0),
        (None, 1.5, False, 1.5, "stated in the file", -0.1),
        (None, None, True, 1.6, "standing height of the headset", 0.0),
        (None, None, False, 1.65, "assumed", 0.05),
    ],
)
def test_who_is_asked_comes_before_the_file_and_that_before_the_headset(
    given: float | None, stated: float | None, on_floor: bool, height: float, source: str, lift: float
) -> None:
    found = calibrate(STANDING, given, stated, on_floor)
    assert found.eye_height == pytest.approx(height) and found.source == source
    assert found.lift == pytest.approx(lift, abs=1e-12)
    relative = "heights are relative to the start: eye height 1.65 m assumed; give the wearer's"
    assert found.doubts == ((relative,) if source == "assumed" else ())


@pytest.mark.parametrize(
    ("given", "doubted"), [(1.46, False), (1.45, True), (1.77, False), (1.78, True), (1.6, False)]
)
def test_a_headset_that_stands_a_tenth_off_is_doubted_if_there_is_a_floor(
    given: float, doubted: bool
) -> None:
    line = f"headset stands at 1.60 m, not near {given:.2f} m: check unit and floor"
    assert calibrate(STANDING, given, None, True).doubts == ((line,) if doubted else ())
    assert calibrate(STANDING, None, given, True).doubts == ((line,) if doubted else ())
    assert calibrate(STANDING, given, None, False).doubts == ()


@pytest.mark.parametrize(
    ("height", "doubted"), [(0.99, True), (1.0, False), (2.1, False), (2.11, True), (0.4, True), (2.9, True)]
)
def test_implausible_eye_heights_are_doubted(height: float, doubted: bool) -> None:
    line = f"eye height of {height:.2f} m is implausible; give the wearer's, check unit and floor"
    for on_floor in (True, False):
        found = calibrate(at_heights(np.full(128, height)), height, None, on_floor)
        assert found.doubts == ((line,) if doubted else ())


def test_both_doubts_are_told() -> None:
    first, second = calibrate(STANDING, 0.5, None, True).doubts
    assert "not near 0.50 m" in first and "0.50 m is implausible" in second


def test_a_head_that_looks_ahead_is_where_the_headset_was(tumble) -> None:
    count = 40
    turns = tumble(count, 64.0, count=3, seed=2)
    joint = np.random.default_rng(1).normal(size=(count, 3))
    mounts = replace(DEVICE_MOUNTS, turns=tumble(3, 1.0, seed=5)[:, 0])
    body = Rotation.from_quat(np.roll(turns[:, 0], -1, axis=-1))
    device = body * Rotation.from_quat(np.roll(mounts.turns[0], -1))
    rotations = turns.copy()
    rotations[:, 0] = np.roll(device.as_quat(), 1, axis=-1)
    positions = np.random.default_rng(2).normal(size=(count, 3, 3))
    positions[:, 0] = joint + body.apply(mounts.offsets[0])
    samples = Samples(np.arange(count) / 64.0, positions, rotations, np.ones((count, 3), np.bool_))
    before = positions.copy()
    found = looking_ahead(samples, mounts)
    # straight over the joint: the part of the offset that tells the height
    np.testing.assert_allclose(found.positions[:, 0], joint + np.array([0.0, 0.0, 0.09]), atol=1e-12)
    np.testing.assert_array_equal(found.positions[:, 1:], before[:, 1:])
    np.testing.assert_array_equal(samples.positions, before)
    np.testing.assert_array_equal(found.rotations, rotations)


@pytest.mark.parametrize(("speed", "height"), [(0.29, 1.8), (0.31, 1.6)])
def test_speeds_are_measured_in_true_time(speed: float, height: float) -> None:
    """As many samples of standing and of gliding, which were taken at a quarter of the rate."""
    times = np.r_[np.arange(256) / 64.0, 4.0 + np.arange(257) / 16.0]
    positions = np.zeros((513, 3, 3))
    positions[:, 0, 2] = np.where(times < 4.0, 1.6, 1.8)
    positions[256:, 0, :2] = (times[256:, None] - 4.0) * speed * np.array([0.6, -0.8])
    samples = Samples(times, positions, np.tile(quat.IDENTITY, (513, 3, 1)), np.ones((513, 3), np.bool_))
    assert headset_standing_height(samples) == pytest.approx(height)


def test_samples_without_the_headset_do_not_count() -> None:
    samples = at_heights(np.r_[np.full(200, 1.6), np.full(200, 2.0)])
    samples.valid[200:, 0] = False
    assert headset_standing_height(samples) == pytest.approx(1.6)
    samples.valid[:, 1:] = False
    assert headset_standing_height(samples) == pytest.approx(1.6)


def worn_then_lying(worn: float, lying: float, height: float, tremor: float = 0.0) -> Samples:
    """Seconds on a head that sways by centimetres, then seconds at a height with a tremor of some metres."""
    first, second = (np.arange(round(64 * seconds)) for seconds in (worn, lying))
    samples = at_heights(np.r_[1.6 + 0.02 * np.sin(first / 10.0), np.full(len(second), height)])
    samples.positions[len(first) :, 0, 1] += tremor * (second % 2)
    return samples


@pytest.mark.parametrize(
    ("lying", "start"), [(5.02, 10.0), (5.9, 10.0), (1.5, 10.0), (0.9, None), (1.02, 10.0), (0.0, None)]
)
def test_a_headset_put_down_lies_from_a_whole_second_on(lying: float, start: float | None) -> None:
    assert put_down(worn_then_lying(10.0, lying, 0.8)) == start


def test_put_down_within_a_second_counts_from_the_next() -> None:
    assert put_down(worn_then_lying(9.5, 5.6, 0.8)) == 10.0
    assert put_down(worn_then_lying(30.2, 8.0, 0.8)) == 31.0


@pytest.mark.parametrize(("height", "lies"), [(1.18, True), (1.22, False), (0.05, True)])
def test_what_lies_is_below_three_quarters_of_the_standing_height(height: float, lies: bool) -> None:
    assert put_down(worn_then_lying(20.0, 4.1, height)) == (20.0 if lies else None)


@pytest.mark.parametrize(
    ("tremor", "lying", "lies"),
    [
        (0.0019, 1.1, True),
        (0.0021, 1.1, False),
        (0.0021, 2.1, True),
        (0.0099, 4.1, True),
        (0.0101, 4.1, False),
    ],
)
def test_what_lies_hardly_moves(tremor: float, lying: float, lies: bool) -> None:
    assert put_down(worn_then_lying(20.0, lying, 0.8, tremor)) == (20.0 if lies else None)


@pytest.mark.parametrize(("degrees", "lies"), [(1.4, True), (1.6, False)])
def test_what_is_nudged_turns_less_than_a_head(degrees: float, lies: bool) -> None:
    samples = worn_then_lying(20.0, 4.1, 0.8, 0.005)
    swing = np.radians(degrees) * (np.arange(len(samples.times)) % 2)
    samples.rotations[:, 0] = np.stack([np.cos(swing / 2), np.sin(swing / 2), 0 * swing, 0 * swing], axis=-1)
    assert put_down(samples) == (20.0 if lies else None)


def test_a_second_with_one_sample_or_none_tells_nothing() -> None:
    samples = worn_then_lying(20.0, 4.1, 0.8)
    for keep in (1, 0):
        # of the second from 21 on one sample, or none, is left
        kept = (samples.times < 21.0) | (samples.times >= 22.0)
        kept[np.flatnonzero(samples.times == 21.0)] = bool(keep)
        part = Samples(
            samples.times[kept], samples.positions[kept], samples.rotations[kept], samples.valid[kept]
        )
        assert put_down(part) == 22.0
    two = Samples(
        *(array[:2] for array in (samples.times, samples.positions, samples.rotations, samples.valid))
    )
    assert put_down(two) is None

"""Resampling against scipy's interpolation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.errors import InputError
from footwork.core.mocap.demo import demo_motion
from footwork.core.recording.recording import Recording
from footwork.core.recording.resample import resample
from footwork.core.recording.simulate import simulate_recording
from scipy.spatial.transform import Rotation, Slerp


@pytest.fixture(scope="module")
def uneven() -> Recording:
    recording = simulate_recording(demo_motion("turn", 3), "turn")
    rng = np.random.default_rng(1)
    keep = np.sort(rng.permutation(len(recording))[: len(recording) // 2])
    times = recording.times[keep] - recording.times[keep[0]]
    return replace(
        recording, times=times, positions=recording.positions[keep], rotations=recording.rotations[keep],
        valid=rng.random((len(keep), 3)) < 0.7,
    )  # fmt: skip


@pytest.mark.parametrize("fps", [30.0, 60.0, 72.0, 90.5])
def test_values_are_scipys(uneven: Recording, fps: float) -> None:
    result = resample(uneven, fps)
    np.testing.assert_allclose(result.times, np.arange(len(result)) / fps, atol=1e-12)
    assert 0.0 <= uneven.times[-1] - result.times[-1] < 1.0 / fps
    for tracker in range(3):
        for axis in range(3):
            expected = np.interp(result.times, uneven.times, uneven.positions[:, tracker, axis])
            np.testing.assert_allclose(result.positions[:, tracker, axis], expected, atol=1e-12)
        xyzw = uneven.rotations[:, tracker, [1, 2, 3, 0]]
        expected = Slerp(uneven.times, Rotation.from_quat(xyzw))(result.times)
        actual = Rotation.from_quat(result.rotations[:, tracker, [1, 2, 3, 0]])
        assert (expected * actual.inv()).magnitude().max() < 1e-7
    assert (np.sum(result.rotations[1:] * result.rotations[:-1], axis=-1) > 0.0).all()


def test_validity_is_the_nearest_samples(uneven: Recording) -> None:
    result = resample(uneven, 50.0)
    nearest = np.abs(result.times[:, None] - uneven.times[None]).argmin(axis=1)
    tie = np.abs(np.sort(np.abs(result.times[:, None] - uneven.times[None]), axis=1)[:, :2] @ [1, -1]) < 1e-9
    np.testing.assert_array_equal(result.valid[~tie], uneven.valid[nearest[~tie]])


def test_an_even_recording_stays_as_it_is() -> None:
    recording = simulate_recording(demo_motion("turn", 0), "turn")
    result = resample(recording, 60.0)
    assert len(result) == len(recording)
    np.testing.assert_allclose(result.positions, recording.positions, atol=1e-9)
    np.testing.assert_allclose(result.rotations, recording.rotations, atol=1e-9)


def test_less_than_two_frames_is_an_error() -> None:
    recording = simulate_recording(demo_motion("turn", 0), "turn")
    short = replace(recording, times=recording.times[:2], positions=recording.positions[:2])
    with pytest.raises(InputError, match="too short"):
        resample(short, 20.0)

"""A stretch of a recording."""

from __future__ import annotations

import math

import numpy as np
import pytest
from footwork.core.errors import InputError
from footwork.core.mocap.demo import demo_motion
from footwork.core.recording.cut import cut
from footwork.core.recording.recording import Recording
from footwork.core.recording.simulate import simulate_recording


@pytest.fixture(scope="module")
def recording() -> Recording:
    return simulate_recording(demo_motion("walk", 0), "walk")


def test_a_part_is_what_the_whole_has_there(recording) -> None:
    part = cut(recording, 2.0, 5.0)
    assert len(part) == 181 and part.times[0] == 0.0 and part.times[-1] == pytest.approx(3.0)
    assert np.array_equal(part.positions, recording.positions[120:301])
    assert np.array_equal(part.rotations, recording.rotations[120:301])
    assert part.eye_height == recording.eye_height and part.fps == pytest.approx(60.0)


def test_open_ends_reach_to_the_ends(recording) -> None:
    assert len(cut(recording, 0.0, math.inf)) == len(recording)
    assert len(cut(recording, -5.0, 1.0)) == 61


@pytest.mark.parametrize(("start", "stop"), [(5.0, 4.0), (1e6, math.inf), (1.0, 1.001)])
def test_nothing_left_is_said(recording, start: float, stop: float) -> None:
    with pytest.raises(InputError, match="choose a longer part"):
        cut(recording, start, stop)

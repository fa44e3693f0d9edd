"""A stretch of a recording."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from footwork.core.errors import InputError
from footwork.core.mocap.demo import demo_motion
from footwork.core.recording.csv_format import write_csv
from footwork.core.recording.cut import cut
from footwork.core.recording.read import read_recording
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


def test_doubts_about_what_is_cut_off_are_not_repeated(recording, tmp_path) -> None:
    valid = recording.valid.copy()
    valid[600:720, 2] = False
    positions = recording.positions.copy()
    positions[840:, 1] += 3.0
    jumpy = replace(recording, valid=valid, positions=positions)
    write_csv(tmp_path / "r.csv", jumpy)
    whole = read_recording(tmp_path / "r.csv")
    lost, jump = whole.doubts
    assert lost.startswith("left controller jumps once, first at 13.98") or jump.startswith(
        "left controller jumps"
    )
    assert not cut(whole, 0.0, 9.0).doubts
    (lost,) = cut(whole, 11.0, 13.0).doubts
    assert lost == "right controller not tracked for 1.0 of 2.0 s"
    (jump,) = cut(whole, 13.0, math.inf).doubts
    assert jump.startswith("left controller jumps once, first at 0.98 s")
    again = cut(cut(whole, 2.0, math.inf), 9.0, 11.0)
    assert again.doubts == cut(whole, 11.0, 13.0).doubts


def test_doubts_at_no_time_stay(recording) -> None:
    doubted = replace(recording, doubts=("eye height of 0.90 m is implausible",))
    assert cut(doubted, 0.0, 3.0).doubts == doubted.doubts

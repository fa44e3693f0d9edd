"""The example recording: what happens in it, that a hand can reach, and that it can be read."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from footwork.core.errors import InputError
from footwork.core.jobs import run
from footwork.core.maths import quat
from footwork.core.recording.read import read_recording
from footwork.core.recording.recording import Recording
from footwork.nn.motion.body import starter_skeleton
from footwork.nn.motion.decoder import read_model
from footwork.nn.motion.example import example_file, example_recording
from footwork.nn.motion.takes import WEIGHTS


@pytest.fixture(scope="module")
def recording() -> Recording:
    return example_recording(read_model(WEIGHTS))


def test_the_person_does_what_a_first_look_should_show(recording: Recording) -> None:
    assert 20.0 < recording.times[-1] < 30.0
    head = recording.positions[:, 0]
    ratios = head[:, 2] / recording.eye_height
    assert ratios.min() < 0.8
    assert 0.97 < np.median(ratios) < 1.02
    speed = np.linalg.norm(head[60:, :2] - head[:-60, :2], axis=1)
    assert speed.max() > 0.9
    facing = np.unwrap(quat.heading(recording.rotations[:, 0]))
    assert np.ptp(facing) > 2.5
    # side-steps: the head goes to where the eyes do not look
    ahead = np.stack([-np.sin(facing), np.cos(facing)], axis=1)[:-60]
    way = head[60:, :2] - head[:-60, :2]
    aside = np.abs(ahead[:, 0] * way[:, 1] - ahead[:, 1] * way[:, 0])
    assert aside.max() > 0.5
    # waves: the right hand is above the shoulders, and swings
    hand = recording.positions[:, 2]
    waving = (recording.times > 23.2) & (recording.times < 25.3)
    assert (hand[waving, 2] > 0.95 * recording.eye_height).mean() > 0.8
    assert recording.positions[:, 1, 2].max() < 1.3


def test_it_moves_as_people_can(recording: Recording) -> None:
    velocity = np.diff(recording.positions, axis=0) * recording.fps
    assert np.linalg.norm(velocity, axis=-1).max(axis=0) == pytest.approx([1.0, 2.0, 3.0], abs=1.5)
    turned = np.linalg.norm(
        quat.to_rotation_vector(
            quat.multiply(recording.rotations[1:], quat.conjugate(recording.rotations[:-1]))
        ),
        axis=-1,
    )
    assert np.degrees(turned * recording.fps).max() < 700.0
    # a hand is never farther from the head than neck, shoulder and arm let it be
    arm = float(np.linalg.norm(starter_skeleton().offsets, axis=1)[8:11].sum())
    apart = np.linalg.norm(recording.positions[:, 1:] - recording.positions[:, :1], axis=-1)
    assert apart.max() < arm + 0.45


def test_its_file_is_read_without_a_doubt_and_written_alike(tmp_path: Path, recording: Recording) -> None:
    path = run(example_file(tmp_path / "new"))
    read = read_recording(str(path))
    assert read.doubts == ()
    assert read.positions == pytest.approx(recording.positions, abs=2e-6)
    assert read.eye_height == pytest.approx(recording.eye_height)
    before = path.read_bytes()
    path.write_text("damaged")
    assert run(example_file(tmp_path / "new")).read_bytes() == before


def test_a_folder_that_cannot_be_made_is_told_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("a file")
    with pytest.raises(InputError, match="file") as told:
        run(example_file(tmp_path / "file" / "starter"))
    assert len(told.value.lines) == 1

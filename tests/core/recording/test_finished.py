"""Whole recordings: what a finished one tells, simulated ones, other rates, other sizes, parts, doubts."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from footwork.core.body.motion import Motion
from footwork.core.errors import InputError
from footwork.core.maths import quat
from footwork.core.recording.body_estimate import BodyEstimate, estimate_doubts
from footwork.core.recording.csv_format import write_csv
from footwork.core.recording.cut import cut
from footwork.core.recording.mounts import DEVICE_MOUNTS, SIMULATED_MOUNTS, grip_mounts
from footwork.core.recording.read import read_recording, repaired_recording
from footwork.core.recording.reading.answers import Answers
from footwork.core.recording.recording import Happening, Recording
from footwork.core.recording.resample import resample
from footwork.core.recording.simulate import lose_trackers, simulate_recording
from footwork.core.recording.targets import joint_targets, raised, scale
from footwork.core.recording.timeline import Samples
from scipy.spatial.transform import Rotation

FPS = 64.0


@pytest.fixture
def finished(as_raw) -> Callable[..., Recording]:
    def make(samples: Samples, given: float | None = None, **more) -> Recording:
        return repaired_recording(as_raw(samples, **more), "folder/take.one.csv", "abc", given)

    return make


@pytest.fixture
def recording(wander, finished) -> Recording:
    return finished(wander(193), 1.6)


def test_a_finished_recording_tells_what_it_is(wander, finished) -> None:
    samples = wander(193)
    samples.valid[100:, 2] = False
    found = finished(samples, 1.625)
    assert found.found == {
        "format": "made up",
        "rate": "64.0 frames per second",
        "length": "3.0 s, 193 frames",
        "eye height": "1.62 m, given",
        "mounts": "typical of real devices: headset 0.08 m ahead and 0.09 m above, "
        "controllers 0.10 m from the wrist, 15 degrees up",
        "tracked": f"head 100.0%, left 100.0%, right {100 / 1.93:.1f}%",
    }
    assert next(iter(found.found)) == "format"
    assert (found.name, found.file, found.sha256) == ("take.one", "folder/take.one.csv", "abc")
    assert found.eye_height == 1.625 and found.mounts is DEVICE_MOUNTS
    assert found.doubts == (f"right controller not tracked for {93 / FPS:.1f} of 3.0 s",)
    np.testing.assert_array_equal(found.times, samples.times)
    np.testing.assert_array_equal(found.positions[:, :2], samples.positions[:, :2])
    np.testing.assert_array_equal(found.valid, samples.valid)


def test_names_mounts_and_repairs_of_the_file_are_told(wander, finished) -> None:
    samples = wander(193)
    samples.positions[20, 0] = samples.positions[50, 1] = 0.0
    found = finished(samples, name="Take 3", mounts=SIMULATED_MOUNTS, eye_height=1.5)
    assert found.name == "Take 3" and found.mounts is SIMULATED_MOUNTS
    assert found.found["mounts"] == "stated in the file"
    assert found.found["eye height"] == "1.50 m, stated in the file"
    assert (
        found.found["repaired"]
        == "headset: 1 sample without a pose; left controller: 1 sample without a pose"
    )


def test_heights_from_an_unknown_place_are_put_at_the_eye_height(wander, finished) -> None:
    samples = wander(193)
    samples.rotations[:, 0] = quat.from_yaw(samples.times)
    for given, eye, doubts in ((1.8, 1.8, 0), (None, 1.65, 1)):
        found = finished(samples, given, on_floor=False)
        shift = found.positions - samples.positions
        np.testing.assert_allclose(shift[..., :2], 0.0, atol=1e-12)
        np.testing.assert_allclose(shift[..., 2], shift[0, 0, 2], atol=1e-12)
        # what is measured once more on the floor is the eye height
        again = finished(replace(samples, positions=found.positions))
        assert again.eye_height == pytest.approx(eye) and found.eye_height == eye
        assert sum("relative to the start" in doubt for doubt in found.doubts) == doubts


def test_a_headset_laid_down_is_told_with_its_height_above_the_floor(finished, wander) -> None:
    samples = wander(64 * 20 + 1)
    samples.positions[640:, 0] = [0.5, 0.5, 0.6]
    samples.positions[640:, 0] += 1e-5 * (np.arange(641)[:, None] % 2)
    for on_floor in (True, False):
        found = finished(samples, 1.6, on_floor=on_floor)
        (lying,) = [item for item in found.happenings if item.kind == "laid down"]
        assert lying.tracker == 0
        np.testing.assert_array_equal([lying.starts, lying.stops], [[10.0], [20.0]])
        assert lying.height == pytest.approx(found.positions[-1, 0, 2])
        line = f"headset lies still at {lying.height:.2f} m from 10 s on: leave that out"
        assert line in found.doubts
    assert not any("lies still" in doubt for doubt in cut(finished(samples, 1.6), 0.0, 9.5).doubts)


@pytest.mark.parametrize("height", [0.3, 1.7, 3.0])
def test_a_file_is_known_by_its_path_and_content(tmp_path: Path, recording: Recording, height: float) -> None:
    path = tmp_path / "walk.csv"
    write_csv(path, replace(recording, name=" A \n walk  of\tmine "))
    found = read_recording(path, Answers(eye_height=height, force=True))
    assert found.file == str(path) and found.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
    assert found.name == "A walk of mine" and found.eye_height == height
    assert found.found["eye height"] == f"{height:.2f} m, given"
    assert read_recording(str(path), Answers(force=True)).eye_height == 1.6


@pytest.mark.parametrize("height", [0.29, 3.01, math.nan])
def test_eye_heights_of_nobody_are_refused(tmp_path: Path, height: float) -> None:
    with pytest.raises(
        InputError, match=f"^eye height {height:g} m is no person's; give metres, such as 1.65$"
    ):
        read_recording(tmp_path / "none.csv", Answers(eye_height=height))


def test_what_cannot_be_read_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError) as raised:
        read_recording(tmp_path / "none.csv")
    assert str(raised.value).startswith(f"{tmp_path / 'none.csv'}: cannot be read (No such file")
    for content in (b"", b" \n\t "):
        (tmp_path / "empty").write_bytes(content)
        with pytest.raises(InputError) as raised:
            read_recording(tmp_path / "empty")
        assert str(raised.value) == f"{tmp_path / 'empty'}: the file is empty; record again"


def test_our_tables_are_written_to_the_letter(tmp_path: Path, recording: Recording) -> None:
    path = tmp_path / "r.csv"
    mounts = grip_mounts((0.0, 0.125, 0.25), 0.5, 0.0)
    valid = recording.valid.copy()
    valid[1, 1] = False
    write_csv(path, replace(recording, mounts=mounts, eye_height=1.5, name="n", valid=valid))
    lines = path.read_text(encoding="utf-8").split("\n")
    assert lines[:4] == [
        "# footwork-recording 1",
        "# name: n",
        "# eye_height: 1.5",
        "# mount_head: 0.0 0.125 0.25 1.0 0.0 0.0 0.0",
    ]
    for i, side in ((1, "left"), (2, "right")):
        key, *values = lines[3 + i].split()[1:]
        assert key == f"mount_{side}:"
        np.testing.assert_array_equal(np.array(values, float), [*mounts.offsets[i], *mounts.turns[i]])
    assert (
        lines[6]
        == "# seconds; metres in Blender's world (Z up, floor at 0); device axes X right, Y forward, Z up"
    )
    assert lines[7].split(",")[:3] == ["time", "head_px", "head_py"]
    assert len(lines) == 8 + 193 + 1 and lines[-1] == ""
    cells = lines[9].split(",")
    assert cells[0] == "0.015625000" and [cells[8], cells[16], cells[24]] == ["1", "0", "1"]
    for k in range(3):
        decimals = [len(cell.split(".")[1]) for cell in cells[1 + 8 * k : 8 + 8 * k]]
        assert decimals == [6, 6, 6, 8, 8, 8, 8]
        values = np.array(cells[1 + 8 * k : 8 + 8 * k], float)
        np.testing.assert_allclose(values[:3], recording.positions[1, k], atol=6e-7)
        np.testing.assert_allclose(values[3:], recording.rotations[1, k], atol=6e-9)


def test_simulated_trackers_tell_what_they_are(unequal, tumble) -> None:
    body = unequal()
    motion = Motion(body, 64.0, np.tile([0.1, 0.2, 0.9], (33, 1)), tumble(33, 64.0, len(body)))
    found = simulate_recording(motion, "any", DEVICE_MOUNTS, 1.625)
    assert (found.name, found.file, found.sha256) == ("any", "", "")
    assert found.doubts == () and found.happenings == ()
    assert found.found == {
        "format": "simulated trackers",
        "rate": "64 frames per second",
        "length": "0.5 s",
        "eye height": "1.62 m, headset of the body at ease",
    }
    assert found.fps == 64.0 and len(found) == 33 and found.valid.shape == (33, 3) and found.valid.all()
    assert found.valid.dtype == np.bool_ and found.mounts is DEVICE_MOUNTS
    positions, rotations = motion.forward()
    for i, role in enumerate(("head", "hand.L", "hand.R")):
        joint = body.joint(role)
        turn = Rotation.from_quat(np.roll(rotations[:, joint], -1, axis=-1))
        expected = positions[:, joint] + turn.apply(DEVICE_MOUNTS.offsets[i])
        np.testing.assert_allclose(found.positions[:, i], expected, atol=1e-12)
        device = turn * Rotation.from_quat(np.roll(DEVICE_MOUNTS.turns[i], -1))
        turned = Rotation.from_quat(np.roll(found.rotations[:, i], -1, axis=-1))
        assert (device * turned.inv()).magnitude().max() < 1e-7
    assert (np.sum(found.rotations[1:] * found.rotations[:-1], axis=-1) > 0.0).all()
    with pytest.raises(InputError, match=r"^any: 1 frames are too few for a recording; give a longer take$"):
        simulate_recording(replace(motion, positions=motion.positions[:1]), "any")
    two = replace(motion, positions=motion.positions[:2], rotations=motion.rotations[:2])
    assert len(simulate_recording(two, "two")) == 2


def test_the_headset_of_a_body_at_ease_is_its_mount_above_the_head(unequal) -> None:
    body = unequal()
    rest = np.tile(quat.IDENTITY, (60, len(body), 1))
    motion = Motion(body, 60.0, np.tile(body.offsets[0], (60, 1)), rest)
    head = body.tpose_positions()[body.joint("head"), 2]
    assert simulate_recording(motion, "a", DEVICE_MOUNTS).eye_height == pytest.approx(head + 0.09)
    assert simulate_recording(motion, "a").eye_height == pytest.approx(head)


@pytest.mark.parametrize(("names", "lost"), [(["left"], [1]), (["right", "head"], [0, 2]), ([], [])])
def test_lost_trackers_lie_where_they_were_first(
    recording: Recording, names: list[str], lost: list[int]
) -> None:
    before = [array.copy() for array in (recording.positions, recording.rotations, recording.valid)]
    found = lose_trackers(recording, iter(names))
    kept = [i for i in range(3) if i not in lost]
    for was, old, new in zip(
        before, (recording.positions, recording.rotations, recording.valid),
        (found.positions, found.rotations, found.valid), strict=True,
    ):  # fmt: skip
        np.testing.assert_array_equal(old, was)
        np.testing.assert_array_equal(new[:, kept], was[:, kept])
    for i in lost:
        assert not found.valid[:, i].any()
        np.testing.assert_array_equal(found.positions[:, i], np.tile(recording.positions[0, i], (193, 1)))
        np.testing.assert_array_equal(found.rotations[:, i], np.tile(recording.rotations[0, i], (193, 1)))
    with pytest.raises(ValueError):
        lose_trackers(recording, ["foot"])


def test_a_body_that_is_higher_has_all_its_trackers_higher(recording: Recording) -> None:
    lift = np.linspace(-0.2, 0.7, 193)
    found = raised(recording, lift)
    np.testing.assert_array_equal(found.positions[..., :2], recording.positions[..., :2])
    np.testing.assert_allclose(found.positions[..., 2] - recording.positions[..., 2], np.tile(lift, (3, 1)).T)
    np.testing.assert_array_equal(found.rotations, recording.rotations)
    np.testing.assert_allclose(joint_targets(found)[1], joint_targets(recording)[1])


def test_scaling_keeps_turns_and_times(recording: Recording) -> None:
    found = scale(recording, 0.5)
    np.testing.assert_array_equal(found.positions, 0.5 * recording.positions)
    np.testing.assert_array_equal(found.mounts.offsets, 0.5 * recording.mounts.offsets)
    np.testing.assert_array_equal(found.mounts.turns, recording.mounts.turns)
    np.testing.assert_array_equal(found.rotations, recording.rotations)
    np.testing.assert_array_equal(found.times, recording.times)
    assert found.eye_height == 0.8 and recording.eye_height == 1.6


@pytest.mark.parametrize(
    ("fps", "count"), [(64.0, 193), (32.0, 97), (128.0, 385), (0.34, 2), (100.0, 301), (63.0, 190)]
)
def test_frames_at_another_rate(recording: Recording, fps: float, count: int) -> None:
    found = resample(recording, fps)
    assert len(found) == len(found.valid) == len(found.rotations) == count
    np.testing.assert_allclose(found.times, np.arange(count) / fps, atol=1e-12)
    assert (found is recording) == (fps == 64.0)
    assert found.fps == pytest.approx(fps)


@pytest.mark.parametrize(("hair", "count"), [(0.5e-6, 193), (3e-6, 192)])
def test_a_last_sample_a_hair_too_early_is_a_frame(recording: Recording, hair: float, count: int) -> None:
    times = recording.times.copy()
    times[-1] -= hair
    assert len(resample(replace(recording, times=times), 64.0)) == count


def test_as_many_samples_at_other_times_are_not_taken_as_they_are(recording: Recording) -> None:
    times = recording.times.copy()
    times[50] += 0.004
    found = resample(replace(recording, times=times), 64.0)
    assert len(found) == 193
    share = (1 / 64) / (1 / 64 + 0.004)
    expected = recording.positions[49] + share * (recording.positions[50] - recording.positions[49])
    np.testing.assert_allclose(found.positions[50], expected, atol=1e-12)


def test_validity_halfway_is_that_of_the_earlier_sample(recording: Recording) -> None:
    valid = recording.valid.copy()
    valid[10, 1], valid[21, 2] = False, False
    found = resample(replace(recording, valid=valid), 128.0)
    assert np.flatnonzero(~found.valid[:, 1]).tolist() == [20, 21]
    assert np.flatnonzero(~found.valid[:, 2]).tolist() == [42, 43]
    quarters = resample(replace(recording, valid=valid), 256.0)
    assert np.flatnonzero(~quarters.valid[:, 1]).tolist() == [39, 40, 41, 42]


def test_one_frame_is_too_short_to_resample(recording: Recording) -> None:
    with pytest.raises(
        InputError, match=r"^take\.one: 3\.000 s are too short for a recording; record for longer$"
    ):
        resample(recording, 0.3)


@pytest.mark.parametrize(
    ("start", "stop", "first", "last"),
    [(1.0, 2.0, 64, 128), (1.001, 1.999, 65, 127), (-1.0, 0.5, 0, 32), (2.5, 99.0, 160, 192),
     (1.0 + 1e-10, 2.0 - 1e-10, 64, 128), (2.984375, 3.0, 191, 192)],
)  # fmt: skip
def test_parts_have_their_ends(
    recording: Recording, start: float, stop: float, first: int, last: int
) -> None:
    found = cut(recording, start, stop)
    kept = slice(first, last + 1)
    np.testing.assert_allclose(found.times, recording.times[kept] - recording.times[first], atol=1e-15)
    for name in ("positions", "rotations", "valid"):
        np.testing.assert_array_equal(getattr(found, name), getattr(recording, name)[kept])


def test_what_is_left_over_is_said(recording: Recording) -> None:
    with pytest.raises(InputError) as raised:
        cut(recording, 3.0, math.inf)
    assert str(raised.value) == (
        "take.one: nothing is left between 3 and inf s of its 3.0 s; choose a longer part"
    )


def test_a_part_tells_of_itself_first_and_keeps_other_doubts(recording: Recording) -> None:
    times = np.array([0.5, 2.0])
    jump = Happening("jump", 1, times, times)
    told = "left controller jumps 2 times, first at 0.50 s: lost and found again, bridged"
    given = replace(recording, happenings=(jump,), doubts=("too dark", told, "too loud"))
    line = "left controller jumps once, first at 1.00 s: lost and found again, bridged"
    found = cut(given, 1.0, 3.0)
    assert found.doubts == (line, "too dark", "too loud")
    np.testing.assert_array_equal(found.happenings[0].starts, [1.0])
    assert cut(given, 2.5, 3.0).doubts == ("too dark", "too loud")


@pytest.mark.parametrize(("frames", "told"), [(63, False), (64, True)])
def test_a_second_in_doubt_is_worth_a_word(frames: int, told: bool) -> None:
    doubt = np.radians(np.full(640, 24.9))
    doubt[[100, *range(300, 300 + frames - 1)]] = np.radians(25.1)
    lines = estimate_doubts(BodyEstimate(np.zeros(640), doubt), 64.0)
    line = "body direction doubtful for 1.0 of 10.0 s, first at 1.6 s: the predictor expects to be 25 degrees off"
    assert lines == ((f"{line} or more there",) if told else ())

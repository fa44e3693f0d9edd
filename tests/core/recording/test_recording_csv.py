"""The project's own recording format: round trip and the line that each fault is blamed on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from footwork.core.errors import InputError
from footwork.core.maths import quat
from footwork.core.mocap.demo import demo_motion
from footwork.core.recording.csv_format import COLUMNS, write_csv
from footwork.core.recording.mounts import DEVICE_MOUNTS, grip_mounts
from footwork.core.recording.read import read_recording
from footwork.core.recording.reading.answers import Answers
from footwork.core.recording.recording import Recording
from footwork.core.recording.simulate import simulate_recording

Edit = Callable[[list[str]], None]


def simulated() -> Recording:
    return simulate_recording(demo_motion("visit", 2), "A visit", grip_mounts((0.01, 0.1, 0.05), 0.09, 0.2))


@pytest.fixture(scope="module")
def lines(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    path = tmp_path_factory.mktemp("csv") / "r.csv"
    write_csv(path, simulated())
    return path.read_text().splitlines()


def header_of(lines: list[str]) -> int:
    return next(i for i, line in enumerate(lines) if not line.startswith("#"))


def test_round_trip(tmp_path: Path) -> None:
    recording = simulated()
    valid = np.random.default_rng(0).random(recording.valid.shape) < 0.95
    valid[0], valid[:, 0] = True, True
    recording = replace(recording, valid=valid, eye_height=1.612345)
    write_csv(tmp_path / "r.csv", recording)
    back = read_recording(tmp_path / "r.csv")
    assert back.name == "A visit"
    assert back.eye_height == recording.eye_height
    assert back.mounts.offsets.tolist() == recording.mounts.offsets.tolist()
    np.testing.assert_allclose(back.mounts.turns, recording.mounts.turns, atol=1e-15)
    np.testing.assert_array_equal(back.valid, valid)
    np.testing.assert_allclose(back.times, recording.times, atol=1e-9)
    np.testing.assert_allclose(back.positions[valid], recording.positions[valid], atol=1e-6)
    dots = np.abs(np.sum(back.rotations * recording.rotations, axis=-1))[valid]
    assert np.degrees(2 * np.arccos(np.minimum(dots, 1.0))).max() < 1e-4
    np.testing.assert_allclose(np.linalg.norm(back.rotations, axis=-1), 1.0, atol=1e-12)
    assert "stated in the file" in back.found["mounts"]
    assert not back.doubts or all("not tracked" in doubt for doubt in back.doubts)


def test_columns_in_any_order_more_columns_and_windows_line_ends(tmp_path: Path, lines: list[str]) -> None:
    at = header_of(lines)
    rows = [line.split(",") for line in lines[at:]]
    shuffled = [",".join([*reversed(row), "button"]) for row in rows]
    (tmp_path / "plain.csv").write_text("\n".join(lines))
    (tmp_path / "other.csv").write_bytes(b"\xef\xbb\xbf" + "\r\n".join([*lines[:at], *shuffled, ""]).encode())
    plain, other = (read_recording(tmp_path / f"{name}.csv") for name in ("plain", "other"))
    np.testing.assert_array_equal(other.positions, plain.positions)
    np.testing.assert_array_equal(other.rotations, plain.rotations)


def test_a_hand_made_file_needs_one_comment_only(tmp_path: Path) -> None:
    header, rows = ",".join(COLUMNS), []
    for i in range(30):
        rows.append(",".join([str(i / 30), *["0.1,0.2,1.6,1,0,0,0,1"] * 3]))
    (tmp_path / "hand.csv").write_text("\n".join(["# footwork-recording 1", header, *rows]))
    recording = read_recording(tmp_path / "hand.csv", Answers(eye_height=1.7))
    assert recording.name == "hand"
    assert recording.eye_height == 1.7
    assert recording.mounts is DEVICE_MOUNTS
    np.testing.assert_allclose(recording.positions, np.broadcast_to([0.1, 0.2, 1.6], (30, 3, 3)))
    np.testing.assert_allclose(recording.rotations, np.broadcast_to(quat.IDENTITY, (30, 3, 4)))


def set_cell(row: int, column: str, value: str) -> Edit:
    def edit(lines: list[str]) -> None:
        at = header_of(lines) + row
        cells = lines[at].split(",")
        cells[COLUMNS.index(column)] = value
        lines[at] = ",".join(cells)

    return edit


def zero_quaternion(lines: list[str]) -> None:
    for part in ("qw", "qx", "qy", "qz"):
        set_cell(7, f"left_{part}", "0")(lines)


def replace_line(start: str, new: str) -> Edit:
    def edit(lines: list[str]) -> None:
        i = next(i for i, line in enumerate(lines) if line.startswith(start))
        lines[i] = new

    return edit


def cut_row(lines: list[str]) -> None:
    at = header_of(lines) + 5
    lines[at] = lines[at][: len(lines[at]) // 2]


def drop_rows(lines: list[str]) -> None:
    del lines[header_of(lines) + 1 :]


def drop_table(lines: list[str]) -> None:
    del lines[header_of(lines) :]


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (
            replace_line("time,", ",".join(COLUMNS).replace("left_qy", "left_q")),
            r"line 8: no column 'left_qy'",
        ),
        (cut_row, r"line 13: \d+ cells for 25 columns"),
        (set_cell(4, "head_px", "left"), r"line 12: 'left' is not a number"),
        (set_cell(4, "head_px", "nan"), r"line 12: head has an empty or infinite value"),
        (set_cell(4, "right_qz", ""), r"line 12: right has an empty"),
        (set_cell(9, "left_pz", "inf"), r"line 17: left has an empty or infinite"),
        (set_cell(3, "time", "nan"), r"line 11: time is not a finite number"),
        (set_cell(20, "time", "0.1"), r"line 28: time does not run forward"),
        (zero_quaternion, r"line 15: left has a zero quaternion"),
        (drop_rows, r"line 8: the table ends after its header"),
        (drop_table, r"line 7: no table"),
        (replace_line("# footwork", "# footwork-recording 2"), r"line 1: version 2 is newer"),
        (replace_line("# footwork", "# footwork-recording one"), r"line 1: the format's version is 'one'"),
        (replace_line("# eye_height", "# eye_height: tall"), r"line 3: eye_height is 'tall'"),
        (replace_line("# eye_height", "# eye_height: -1.6"), r"line 3: eye height -1.6 m is no person's"),
        (set_cell(4, "left_py", "1e30"), r"line 12: left has a value past 10000"),
        (replace_line("# mount_left", "# mount_left: 0 0 0"), r"line 5: mount_left is '0 0 0', not 7"),
        (replace_line("# mount_left", "# mount_left: 0 0 0 0 0 0 0"), r"line 5: mount_left's rotation"),
        (replace_line("# mount_left", "#"), r"no mount_left beside the other mounts"),
    ],
)
def test_faults_are_named_by_their_line(tmp_path: Path, lines: list[str], edit: Edit, message: str) -> None:
    changed = list(lines)
    edit(changed)
    (tmp_path / "bad.csv").write_text("\n".join(changed) + "\n")
    with pytest.raises(InputError, match=message) as raised:
        read_recording(tmp_path / "bad.csv")
    assert "\n" not in str(raised.value)
    assert str(raised.value).startswith(f"{tmp_path / 'bad.csv'}: ")


def test_the_first_fault_is_named(tmp_path: Path, lines: list[str]) -> None:
    changed = list(lines)
    set_cell(9, "time", "0")(changed)
    set_cell(4, "right_px", "nan")(changed)
    (tmp_path / "bad.csv").write_text("\n".join(changed))
    with pytest.raises(InputError, match="line 12: right"):
        read_recording(tmp_path / "bad.csv")


def test_untracked_samples_may_hold_anything(tmp_path: Path, lines: list[str]) -> None:
    changed = list(lines)
    for row in range(40, 50):
        for part, value in zip(
            ("px", "py", "pz", "qw", "qx", "qy", "qz", "valid"), ["nan"] * 3 + ["0"] * 5, strict=True
        ):
            set_cell(row, f"left_{part}", value)(changed)
    (tmp_path / "r.csv").write_text("\n".join(changed))
    recording, original = read_recording(tmp_path / "r.csv"), simulated()
    np.testing.assert_array_equal(np.flatnonzero(~recording.valid[:, 1]), np.arange(39, 49))
    assert np.isfinite(recording.positions).all()
    assert np.linalg.norm(recording.positions - original.positions, axis=-1).max() < 0.05


def test_writing_into_nowhere_is_an_input_error(tmp_path: Path) -> None:
    with pytest.raises(InputError):
        write_csv(tmp_path / "no" / "r.csv", simulated())

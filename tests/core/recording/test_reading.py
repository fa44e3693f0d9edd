"""Files read by what their names say and by what a person can do, against one walk that is known."""

from __future__ import annotations

import gzip
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from footwork.core.errors import InputError
from footwork.core.mocap.demo import demo_motion
from footwork.core.recording.csv_format import write_csv
from footwork.core.recording.mounts import DEVICE_MOUNTS
from footwork.core.recording.read import read_recording
from footwork.core.recording.reading.answers import NO_ANSWERS, Answers
from footwork.core.recording.recording import TRACKERS, Recording
from footwork.core.recording.resample import resample
from footwork.core.recording.simulate import simulate_recording
from scipy.spatial.transform import Rotation

AXES = {"R": (1, 0, 0), "L": (-1, 0, 0), "F": (0, 1, 0), "B": (0, -1, 0), "U": (0, 0, 1), "D": (0, 0, -1)}
NAMES = ("hmd", "left", "right")


@pytest.fixture(scope="module")
def walk() -> Recording:
    """Someone who walks and turns, wearing real devices; looks about a little, as people do."""
    return simulate_recording(demo_motion("turn", 3), "turn", DEVICE_MOUNTS)


def poses(walk: Recording, axes: str) -> tuple[np.ndarray, Rotation]:
    """Positions `(T, 3, 3)` and rotations of `T * 3` in a file's axes, by matrices."""
    change = np.array([AXES[letter] for letter in axes], dtype=float).T
    turns = Rotation.from_quat(np.roll(walk.rotations.reshape(-1, 4), -1, axis=-1)).as_matrix()
    return walk.positions @ change, Rotation.from_matrix(change.T @ turns @ change)


def columns(walk: Recording, axes: str, metres: float = 1.0) -> np.ndarray:
    """`(T, 3, 7)` position and quaternion x y z w."""
    places, turns = poses(walk, axes)
    return np.concatenate([places / metres, turns.as_quat().reshape(-1, 3, 4)], axis=-1)


def names(
    pattern: str = "{}_pos_{}", turned: str = "{}_rot_{}", trackers: tuple[str, ...] = NAMES
) -> list[str]:
    return [
        name
        for tracker in trackers
        for name in (
            *(pattern.format(tracker, a) for a in "xyz"),
            *(turned.format(tracker, a) for a in "xyzw"),
        )
    ]


def table(
    walk: Recording,
    values: np.ndarray,
    header: list[str],
    time: str = "time",
    clock: Callable[[float], str] = "{:.6f}".format,
    separator: str = ",",
) -> str:
    lines = [separator.join([*([time] if time else []), *header])]
    for second, row in zip(walk.times, values.reshape(len(values), -1), strict=True):
        lines.append(separator.join([*([clock(second)] if time else []), *(f"{value:.7f}" for value in row)]))
    return "\n".join(lines) + "\n"


def milliseconds(second: float) -> str:
    return f"{1000.0 * second:.3f}"


def is_walk(found: Recording, walk: Recording, hands: tuple[int, ...] = (1, 2)) -> bool:
    """Whether a recording shows the walk, up to where it stands and which way it faces."""

    def seen(recording: Recording) -> tuple[np.ndarray, np.ndarray]:
        turns = Rotation.from_quat(np.roll(recording.rotations.reshape(-1, 4), -1, axis=-1)).as_matrix()
        turns = turns.reshape(-1, 3, 3, 3)
        forward = turns[0, 0, :, 1]
        back = Rotation.from_euler("z", np.arctan2(forward[0], forward[1])).as_matrix()
        places = recording.positions - recording.positions[:1, :1] * [1.0, 1.0, 0.0]
        return places @ back.T, back @ turns

    count = min(len(found), len(walk))
    (a, x), (b, y) = seen(found), seen(walk)
    which = [0, *hands]
    # hands that stand still to the last digit are taken for asleep
    known = found.valid[:count, which]
    near = np.linalg.norm(a[:count, which] - b[:count, which], axis=-1)[known].max() < 2e-3
    turned = np.einsum("tnij,tnij->tn", x[:count, which], y[:count, which])[known]
    awake = known.mean() > 0.8
    return abs(len(found) - len(walk)) <= 1 and bool(near and awake) and bool((turned > 2.999).all())


def read(folder: Path, content: str | bytes, answers: Answers = NO_ANSWERS) -> Recording:
    path = folder / "recording.dat"
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return read_recording(path, answers)


@pytest.mark.parametrize("axes", ["RUF", "RUB", "RFU", "FRU", "FLU"])
@pytest.mark.parametrize(
    ("pattern", "turned", "trackers"),
    [
        ("{}_pos_{}", "{}_rot_{}", ("head", "lefthand", "righthand")),
        ("{}.position.{}", "{}.orientation.{}", ("viewer", "leftController", "rightController")),
        ("{} P{}", "{} Q{}", ("Camera", "L Hand", "R Hand")),
    ],
)
def test_axes_are_found(tmp_path, walk, axes, pattern, turned, trackers) -> None:
    found = read(tmp_path, table(walk, columns(walk, axes), names(pattern, turned, trackers)))
    assert is_walk(found, walk)
    assert axes in found.found["reading"]


@pytest.mark.parametrize(("unit", "metres"), [("cm", 0.01), ("mm", 0.001), ("ft", 0.3048)])
def test_units_are_found(tmp_path, walk, unit, metres) -> None:
    found = read(
        tmp_path, table(walk, columns(walk, "RUF", metres), names(trackers=("head", "l_hand", "r_hand")))
    )
    assert is_walk(found, walk) and f" {unit}," in found.found["reading"]


@pytest.mark.parametrize(
    ("axes", "metres", "words"), [("RUB", 1.0, "RUB"), ("RUF", 0.01, "unit cm"), ("RFU", 0.001, "RFU")]
)
def test_what_a_format_states_wrongly_is_read_right_and_doubted(tmp_path, walk, axes, metres, words) -> None:
    header = names()
    found = read(
        tmp_path,
        table(walk, columns(walk, axes, metres), header, "timestamp_ms", milliseconds),
    )
    assert found.found["format"] == "Unity recorder CSV" and is_walk(found, walk)
    assert any("read with" in doubt and words in doubt for doubt in found.doubts)
    right = read(tmp_path, table(walk, columns(walk, "RUF"), header, "timestamp_ms", milliseconds))
    assert not any("read with" in doubt for doubt in right.doubts) and is_walk(right, walk)


def test_hands_that_are_swapped_are_put_right_and_doubted(tmp_path, walk) -> None:
    swapped = columns(walk, "RUF")[:, [0, 2, 1]]
    found = read(tmp_path, table(walk, swapped, names(), "timestamp_ms", milliseconds))
    assert is_walk(found, walk) and any("swapped" in doubt for doubt in found.doubts)


def test_hands_that_change_half_way_are_put_back(tmp_path, walk) -> None:
    values = columns(walk, "RUF")
    half = len(values) * 3 // 5
    values[half:] = values[half:, [0, 2, 1]]
    found = read(tmp_path, table(walk, values, names(), "timestamp_ms", milliseconds))
    assert is_walk(found, walk)
    assert any(f"change places at {walk.times[half]:.1f} s" in doubt for doubt in found.doubts)


@pytest.mark.parametrize("turned", [False, True])
def test_hands_told_from_the_head(tmp_path, walk, turned) -> None:
    places, turns = poses(walk, "RUF")
    local = places[:, 1:] - places[:, :1]
    matrices = turns.as_matrix().reshape(-1, 3, 3, 3)
    if turned:
        local = np.einsum("tji,tnj->tni", matrices[:, 0], local)
        matrices[:, 1:] = np.einsum("tji,tnjk->tnik", matrices[:, 0], matrices[:, 1:])
    quats = Rotation.from_matrix(matrices.reshape(-1, 3, 3)).as_quat().reshape(-1, 3, 4)
    values = np.concatenate([np.concatenate([places[:, :1], local], axis=1), quats], axis=-1)
    found = read(tmp_path, table(walk, values, names(), "timestamp_ms", milliseconds))
    assert is_walk(found, walk) and any("told from the head" in doubt for doubt in found.doubts)


def test_a_clock_that_starts_again_is_joined_and_doubted(tmp_path, walk) -> None:
    text = table(walk, columns(walk, "RUF"), names(), "timestamp_ms", milliseconds)
    found = read(tmp_path, text + "".join(text.splitlines(keepends=True)[1:]))
    assert found.times[-1] == pytest.approx(2 * walk.times[-1] + 1 / 60, abs=0.02)
    assert any("clock starts again" in doubt for doubt in found.doubts)


@pytest.mark.parametrize(
    ("time", "clock"),
    [
        ("timestamp", lambda s: f"{1717236000.123 + s:.6f}"),
        ("time_us", lambda s: f"{1e6 * s:.0f}"),
        ("clock", lambda s: f"{1000 * s:.3f}"),
        ("utc", lambda s: f"2024-06-01T10:{int(s) // 60:02d}:{s % 60:09.6f}Z"),
        ("ticks", lambda s: f"{637_000_000_000 + 1e7 * s:.0f}"),
    ],
)
def test_times_of_any_kind(tmp_path, walk, time, clock) -> None:
    found = read(
        tmp_path,
        table(walk, columns(walk, "RUF"), names(trackers=("head", "left hand", "right hand")), time, clock),
    )
    assert is_walk(found, walk)
    np.testing.assert_allclose(found.times, walk.times[: len(found)], atol=2e-3)


def test_frames_without_times_are_asked_for(tmp_path, walk) -> None:
    content = table(walk, columns(walk, "RUF"), names(), "frame", lambda s: f"{60 * s:.0f}")
    with pytest.raises(InputError, match=r"--rate"):
        read(tmp_path, content)
    assert is_walk(read(tmp_path, content, Answers(rate=60.0)), walk)
    assert is_walk(read(tmp_path, table(walk, columns(walk, "RUF"), names(), ""), Answers(rate=60.0)), walk)


DRESSES: dict[str, Callable[[str], str | bytes]] = {
    "semicolons": lambda text: text.replace(",", ";"),
    "decimal commas": lambda text: text.replace(",", ";").replace(".", ","),
    "tabs": lambda text: text.replace(",", "\t"),
    "UTF-16": lambda text: text.encode("utf-16"),
    "gzip": lambda text: gzip.compress(text.encode()),
    "capitals": str.upper,
    "a comment above": lambda text: "# session 7, someone's\n" + text,
    "quotes": lambda text: "\n".join(
        ",".join(f'"{cell}"' for cell in line.split(",")) for line in text.splitlines()
    ),
    "trailing commas": lambda text: "\n".join(
        line + "," * (n > 0) for n, line in enumerate(text.splitlines())
    ),
    "other columns": lambda text: "\n".join(
        line + (",left_thumbstick_x,left_velocity_y,note" if n == 0 else ",0.3,-1.5,what")
        for n, line in enumerate(text.splitlines())
    ),
    "Windows": lambda text: ("\ufeff" + text).replace("\n", "\r\n").encode(),
}


@pytest.mark.parametrize("dress", DRESSES)
def test_tables_in_any_dress(tmp_path, walk, dress) -> None:
    text = table(walk, columns(walk, "RUF"), names(), "timestamp_ms", milliseconds)
    assert is_walk(read(tmp_path, DRESSES[dress](text)), walk)


def test_vectors_in_one_cell(tmp_path, walk) -> None:
    lines = [
        "time,head position,head rotation,left hand position,left hand rotation,right hand position,right hand rotation"
    ]
    for second, row in zip(walk.times, columns(walk, "RUF"), strict=True):
        cells = [
            f'"({", ".join(f"{v:.7f}" for v in part)})"' for pose in row for part in (pose[:3], pose[3:])
        ]
        lines.append(",".join([f"{second:.5f}", *cells]))
    assert is_walk(read(tmp_path, "\n".join(lines)), walk)


def test_no_names_at_all(tmp_path, walk) -> None:
    content = table(walk, columns(walk, "RUB"), names()).split("\n", 1)[1]
    assert is_walk(read(tmp_path, content), walk)


def test_one_row_a_device(tmp_path, walk) -> None:
    lines = ["time;device;x;y;z;qx;qy;qz;qw"]
    for second, row in zip(walk.times, columns(walk, "RUB"), strict=True):
        for device, pose in zip(("HMD", "Controller (Left)", "Controller (Right)"), row, strict=True):
            lines.append(";".join([f"{second:.5f}", device, *(f"{value:.7f}" for value in pose)]))
    assert is_walk(read(tmp_path, "\n".join(lines)), walk)


@pytest.mark.parametrize("order", ["YXZ", "ZYX"])
def test_angles_in_degrees(tmp_path, walk, order) -> None:
    places, turns = poses(walk, "RUF")
    found = turns.as_euler(order, degrees=True)
    angles = np.empty_like(found)
    for column, axis in enumerate(order):
        angles[:, "XYZ".index(axis)] = found[:, column]
    values = np.concatenate([places, angles.reshape(-1, 3, 3)], axis=-1)
    header = [f"{t}_{kind}_{a}" for t in ("head", "left", "right") for kind in ("pos", "rot") for a in "xyz"]
    content = table(walk, values, header)
    assert is_walk(read(tmp_path, content, Answers(rotation=f"{order}-degrees")), walk)
    guessed = read(tmp_path, content)
    assert is_walk(guessed, walk) or any("--rotation" in doubt for doubt in guessed.doubts)


def test_rotators_of_unreal(tmp_path, walk) -> None:
    places, turns = poses(walk, "FRU")
    # Unreal: yaw about Z, then pitch about -Y, then roll about -X
    yaw, pitch, roll = (turns.as_euler("ZYX", degrees=True) * [1.0, -1.0, -1.0]).T
    values = np.concatenate([100.0 * places, np.stack([pitch, yaw, roll], -1).reshape(-1, 3, 3)], axis=-1)
    header = [
        f"{t}_{a}" for t in ("HMD", "LeftHand", "RightHand") for a in ("X", "Y", "Z", "Pitch", "Yaw", "Roll")
    ]
    assert is_walk(read(tmp_path, table(walk, values, header, "Time")), walk)


@pytest.mark.parametrize("rows", [3, 4])
def test_matrices_in_lines_of_json(tmp_path, walk, rows) -> None:
    places, turns = poses(walk, "RUB")
    whole = np.tile(np.eye(4), (len(walk), 3, 1, 1))
    whole[..., :3, :3], whole[..., :3, 3] = turns.as_matrix().reshape(-1, 3, 3, 3), places
    lines = [
        json.dumps(
            {"t": second, "poses": {name: pose.tolist() for name, pose in zip(NAMES, row, strict=True)}}
        )
        for second, row in zip(walk.times.tolist(), whole[:, :, :rows], strict=True)
    ]
    assert is_walk(read(tmp_path, "\n".join(lines)), walk)


def objects(
    walk: Recording, axes: str, shape: Callable[[np.ndarray], Any], keys: tuple[str, ...]
) -> list[dict[str, Any]]:
    return [
        {"time": second, **{key: shape(pose) for key, pose in zip(keys, row, strict=True)}}
        for second, row in zip(walk.times.tolist(), columns(walk, axes), strict=True)
    ]


def vectors(pose: np.ndarray) -> dict[str, Any]:
    return {
        "position": dict(zip("xyz", pose[:3].tolist(), strict=True)),
        "rotation": dict(zip("xyzw", pose[3:].tolist(), strict=True)),
    }


def short(pose: np.ndarray) -> dict[str, Any]:
    return {
        "p": dict(zip("xyz", pose[:3].tolist(), strict=True)),
        "r": dict(zip("xyzw", pose[3:].tolist(), strict=True)),
    }


def lists(pose: np.ndarray) -> dict[str, Any]:
    return {"pos": pose[:3].tolist(), "quat": pose[3:].tolist()}


@pytest.mark.parametrize(
    ("shape", "keys"),
    [
        (vectors, ("head", "leftHand", "rightHand")),
        (vectors, ("view", "/user/hand/left", "/user/hand/right")),
        (short, ("h", "l", "r")),
        (lists, ("headset", "left_controller", "right_controller")),
        (lambda pose: pose.tolist(), ("hmd", "l", "r")),
    ],
)
def test_json_of_any_shape(tmp_path, walk, shape, keys) -> None:
    frames = objects(walk, "RUF", shape, keys)
    for content in (frames, {"meta": {"app": "any"}, "frames": frames}):
        assert is_walk(read(tmp_path, json.dumps(content)), walk)


def test_browser_recordings_with_quaternions_and_dashes(tmp_path, walk) -> None:
    rows = columns(walk, "RUB")
    content = {
        key: {
            "poses": [
                {**vectors(pose), "timestamp": 1000 * s}
                for s, pose in zip(walk.times, rows[:, i], strict=True)
            ]
        }
        for i, key in enumerate(("camera", "left-hand", "right-hand"))
    }
    assert is_walk(read(tmp_path, json.dumps(content)), walk)


def test_inputs_of_webxr(tmp_path, walk) -> None:
    schema = [[n, {"handedness": side, "hasGrip": True}] for n, side in enumerate(("left", "right"))]
    frames = [
        [1000 * s, *row[0].tolist(), *([n, *([0.0] * 7), *row[n + 1].tolist()] for n in range(2))]
        for s, row in zip(walk.times.tolist(), columns(walk, "RUB"), strict=True)
    ]
    assert is_walk(read(tmp_path, json.dumps({"schema": schema, "frames": frames})), walk)


def test_a_controller_alone(tmp_path, walk) -> None:
    content = table(walk, columns(walk, "RUF")[:, :2], names(trackers=("head", "left")))
    found = read(tmp_path, content, Answers(axes="RUF"))
    assert is_walk(found, walk, hands=(1,)) and not found.valid[:, 2].any()
    assert any("right controller never tracked" in doubt for doubt in found.doubts)


def test_other_trackers_do_no_harm(tmp_path, walk) -> None:
    values = np.concatenate([columns(walk, "RUF"), columns(walk, "RUF")[:, :2] - 0.7], axis=1)
    header = names(trackers=("head", "left_hand", "right_hand", "waist", "left_foot"))
    assert is_walk(read(tmp_path, table(walk, values, header)), walk)


def test_what_can_be_no_person_is_refused_unless_forced(tmp_path, walk) -> None:
    values = columns(walk, "RFU")
    rng = np.random.default_rng(1)
    values[..., 3:] = rng.normal(size=values[..., 3:].shape)
    values[:, 1:, :3] += rng.normal(0.0, 40.0, (len(values), 2, 3))
    content = table(walk, values, names(trackers=("head", "left", "right")))
    with pytest.raises(InputError, match="shows a person"):
        read(tmp_path, content)
    assert read(tmp_path, content, Answers(axes="RFU", unit="m", rotation="wxyz", force=True)).doubts


@pytest.mark.parametrize(
    ("answers", "words"),
    [
        (Answers(axes="RUU"), "--axes"),
        (Answers(axes="XYZ"), "--axes"),
        (Answers(unit="yd"), "--unit"),
        (Answers(rotation="euler"), "--rotation"),
        (Answers(rate=-3.0), "--rate"),
        (Answers(up="W"), "--up"),
        (Answers(axes="RUF", up="Z"), "--up"),
    ],
)
def test_answers_that_cannot_be(tmp_path, walk, answers, words) -> None:
    with pytest.raises(InputError, match=words):
        read(tmp_path, table(walk, columns(walk, "RUF"), names()), answers)


def test_answers_are_believed(tmp_path, walk) -> None:
    content = table(walk, columns(walk, "RUF"), names(trackers=("head", "left", "right")))
    assert "RUF" in read(tmp_path, content, Answers(up="Y")).found["reading"]
    mirrored = table(walk, columns(walk, "LUF"), names(trackers=("head", "left", "right")))
    with pytest.raises(InputError, match=r"--axes LUF.*--swap-hands|--swap-hands.*--axes LUF"):
        read(tmp_path, mirrored)
    assert is_walk(read(tmp_path, mirrored, Answers(axes="LUF")), walk)


def test_doubts_are_faults_when_asked_for(tmp_path, walk) -> None:
    content = table(walk, columns(walk, "RUB"), names(), "timestamp_ms", milliseconds)
    with pytest.raises(InputError, match=r"--strict"):
        read(tmp_path, content, Answers(strict=True))


def test_a_seated_wearer_is_asked_about(tmp_path, walk) -> None:
    values = columns(walk, "RUF")
    values[..., 1] -= 0.45
    found = read(tmp_path, table(walk, values, names(), "timestamp_ms", milliseconds))
    assert any("seated" in doubt for doubt in found.doubts)


def test_packed_replays_are_refused_by_name(tmp_path) -> None:
    content = b"\x05\x01\x00\x00\x03info\x00!\x00\x00\x00\x03software\x00\x12\x00\x00\x00\x05frames\x00\xcc\x00\x00\x00"
    with pytest.raises(InputError, match="XROR"):
        read(tmp_path, content)


@pytest.mark.parametrize(
    "content", [b"\x1f\x8b\x08\x00broken", gzip.compress(b"time,a\n" * 99)[:-9], b"\xff\xfeab\x00"]
)
def test_damaged_dresses_are_named(tmp_path, content) -> None:
    with pytest.raises(InputError, match=r"compression|UTF-16"):
        read(tmp_path, content)


def test_every_case_is_read_right_or_asked_about(data: Path) -> None:
    folder = data.parent / "cases" / "recordings_takes"
    if not folder.is_dir():
        pytest.skip("no cases beside the project")
    truth = np.load(folder / "truth.npz")
    silent: list[str] = []
    for path in sorted((folder / "open").iterdir()):
        if path.suffix == ".bvh" or path.suffix == ".txt":
            continue
        try:
            found = read_recording(path)
        except InputError:
            continue
        places = np.stack(
            [
                np.stack([np.interp(found.times, truth["T"], truth["P"][:, i, a]) for a in range(3)], -1)
                for i in range(3)
            ],
            1,
        )
        off = np.linalg.norm(found.positions - places, axis=-1)[
            :, : 2 if path.name.startswith("l10") else 3
        ].mean()
        if off > 1e-3 and not found.doubts:
            silent.append(path.name)
    assert silent == []


assert len(TRACKERS) == len(NAMES)


@pytest.mark.parametrize("rate", [60.0, 90.0, 120.0])
def test_ticks_are_told_from_microseconds(tmp_path, walk, rate) -> None:
    content = table(
        walk,
        columns(walk, "RUF"),
        names(trackers=("head", "left", "right")),
        "timestamp",
        lambda s: f"{1e7 * s * 60.0 / rate:.0f}",
    )
    found = read(tmp_path, content)
    assert found.times[-1] == pytest.approx(walk.times[len(found) - 1] * 60.0 / rate, abs=0.01)


def test_radians_are_told_from_degrees(tmp_path, walk) -> None:
    places, turns = poses(walk, "RUF")
    y, x, z = turns.as_euler("YXZ").T
    values = np.concatenate([places, np.stack([x, y, z], -1).reshape(-1, 3, 3)], axis=-1)
    header = [f"{t}_{kind}_{a}" for t in ("head", "left", "right") for kind in ("pos", "rot") for a in "xyz"]
    found = read(tmp_path, table(walk, values, header))
    assert "radians" in found.found["reading"]


def test_of_several_poses_the_trackers_own_is_read_and_the_others_are_named(tmp_path, walk) -> None:
    rows = columns(walk, "RUB")
    aimed = rows[:, 1:].copy()
    aimed[..., :3] += 0.06
    header = names(trackers=("head", "left_aim", "right_aim", "left_grip", "right_grip"))
    values = np.concatenate([rows[:, :1], aimed, rows[:, 1:]], axis=1)
    found = read(tmp_path, table(walk, values, header))
    assert is_walk(found, walk)
    assert any("several poses of left" in doubt and "left_grip" in doubt for doubt in found.doubts)


@pytest.mark.parametrize("flat", [True, False])
def test_matrices_written_column_by_column(tmp_path, walk, flat) -> None:
    places, turns = poses(walk, "RUB")
    whole = np.tile(np.eye(4), (len(walk), 3, 1, 1))
    whole[..., :3, :3], whole[..., :3, 3] = turns.as_matrix().reshape(-1, 3, 3, 3), places
    written = np.swapaxes(whole, -1, -2)
    frames = [
        {
            "t": s,
            **{n: {"matrix": (m.ravel() if flat else m).tolist()} for n, m in zip(NAMES, row, strict=True)},
        }
        for s, row in zip(walk.times.tolist(), written, strict=True)
    ]
    assert is_walk(read(tmp_path, json.dumps(frames)), walk)


def test_trackers_with_times_of_their_own(tmp_path, walk) -> None:
    rows = columns(walk, "RUF")
    lag = 5
    late = rows.copy()
    late[lag:, 1:] = rows[:-lag, 1:]
    header = ["head_time", "left_time", "right_time", *names(trackers=("head", "left", "right"))]
    lines = [",".join(header)]
    for second, row in zip(walk.times, late, strict=True):
        own = [second, second - lag / 60.0, second - lag / 60.0]
        lines.append(",".join(f"{value:.7f}" for value in (*own, *row.ravel())))
    found = read(tmp_path, "\n".join(lines))
    near = np.linalg.norm(found.positions - walk.positions[: len(found)], axis=-1)[30:-30]
    assert np.median(near[:, 1:]) < 0.005


@pytest.mark.parametrize("letters", ["0123", "rijk"])
def test_other_names_of_a_quaternions_numbers(tmp_path, walk, letters) -> None:
    rows = columns(walk, "RUF")[..., [0, 1, 2, 6, 3, 4, 5]]
    header = [
        f"{t}_{c}" for t in ("head", "left", "right") for c in ("px", "py", "pz", *(f"q{k}" for k in letters))
    ]
    found = read(tmp_path, table(walk, rows, header), Answers(rotation="wxyz"))
    assert is_walk(found, walk)


@pytest.mark.parametrize(
    ("name", "clock"),
    [
        ("boot_seconds", lambda s: f"{4312.5 + s:.5f}"),
        ("c0", lambda s: f"{1000.0 * s:.2f}"),
        (
            "Datum",
            lambda s: f"31.12.2024 23:59:{50 + s:09.6f}" if s < 10 else f"01.01.2025 00:00:{s - 10:09.6f}",
        ),
        ("stamp", lambda s: f"03/14/2024 11:59:{50 + s:09.6f} AM" if s < 10 else f"12:00:{s - 10:09.6f} PM"),
        (
            "sec,nanosec",
            lambda s: f"{1700000000 + int(s + 0.7)},{round((s + 0.7) % 1 * 1e6) % 1000000 * 1000}",
        ),
    ],
)
def test_clocks_are_known_by_what_they_do(tmp_path, walk, name, clock) -> None:
    header = names(trackers=("head", "left", "right"))
    found = read(tmp_path, table(walk, columns(walk, "RUF"), header, name, clock))
    assert is_walk(found, walk)
    np.testing.assert_allclose(found.times, walk.times[: len(found)], atol=2e-3)


ODD: dict[str, Callable[[str], str | bytes]] = {
    "notes above": lambda text: "Recorder,v2.1\nSubject,P07\n\n" + text,
    "a section above": lambda text: "[Header]\nRate=72\n[Data]\n" + text,
    "units below": lambda text: text.replace("\n", "\nms" + ",m,m,m,,,," * 3 + "\n", 1),
    "totals": lambda text: text + "Total,864 frames\n",
    "means": lambda text: text + "mean" + ",0.1" * 21 + "\n",
    "names again": lambda text: text + text.splitlines()[0] + "\n",
    "code page": lambda text: ("# Säule für Müller\n" + text).encode("cp1252"),
    "control-Z": lambda text: text.encode() + b"\x1a",
}


@pytest.mark.parametrize("dress", ODD)
def test_what_is_above_and_below_a_table_is_left_out(tmp_path, walk, dress) -> None:
    text = table(walk, columns(walk, "RUF"), names(), "timestamp_ms", milliseconds)
    assert is_walk(read(tmp_path, ODD[dress](text)), walk)


def test_thousands_are_set_apart(tmp_path, walk) -> None:
    rows = [";".join(["time_ms", *names()])]
    for second, row in zip(walk.times, columns(walk, "RUF", 0.001), strict=True):
        cells = (
            [f"{v:,.4f}" for pose in row for v in pose[:3]],
            [f"{v:.7f}" for pose in row for v in pose[3:]],
        )
        merged = [c for i in range(3) for c in (*cells[0][3 * i : 3 * i + 3], *cells[1][4 * i : 4 * i + 4])]
        rows.append(";".join([f"{1000 * second:,.2f}", *merged]))
    assert is_walk(read(tmp_path, "\n".join(rows)), walk)


def _columnar(walk: Recording) -> Any:
    values = columns(walk, "RUB").reshape(len(walk), -1).T.tolist()
    return {
        "time": walk.times.tolist(),
        **dict(zip(names(trackers=("head", "left", "right")), values, strict=True)),
    }


def _device_lists(walk: Recording) -> Any:
    rows, times = columns(walk, "RUB"), walk.times.tolist()
    hands = (("headset", "none"), ("controller", "left"), ("controller", "right"))
    samples = [[{"t": s, **vectors(p)} for s, p in zip(times, rows[:, i], strict=True)] for i in range(3)]
    return [
        {"type": kind, "handedness": hand, "data": data}
        for (kind, hand), data in zip(hands, samples, strict=True)
    ]


def _keyed(walk: Recording) -> Any:
    frames = objects(walk, "RUB", vectors, ("head", "left", "right"))
    return {f"{frame.pop('time'):.5f}": frame for frame in frames}


def _texts(walk: Recording) -> Any:
    frames = json.dumps(objects(walk, "RUB", vectors, ("head", "left", "right")))
    return json.loads(frames, parse_float=str)


def _godot(walk: Recording) -> Any:
    places, turns = poses(walk, "RUB")
    values = np.concatenate([turns.as_matrix().reshape(-1, 3, 9), places], axis=-1)
    texts = [[f"Transform3D({', '.join(f'{x:.7f}' for x in pose)})" for pose in row] for row in values]
    return [
        {"time": s, **dict(zip(NAMES, row, strict=True))}
        for s, row in zip(walk.times.tolist(), texts, strict=True)
    ]


@pytest.mark.parametrize("shape", [_columnar, _device_lists, _keyed, _texts, _godot])
def test_json_of_other_shapes(tmp_path, walk, shape) -> None:
    assert is_walk(read(tmp_path, json.dumps(shape(walk))), walk)


def test_other_trackers_are_kept_up_to_our_own_table(tmp_path, walk) -> None:
    places = columns(walk, "RUF", 0.01)
    low = places[:, :1].copy()
    low[..., 1] -= 70.0
    header = names(trackers=("head", "left_hand", "right_hand", "waist"))
    found = read(tmp_path, table(walk, np.concatenate([places, low], axis=1), header))
    (waist,) = found.extra
    assert waist.name == "waist" and "waist" in found.found["other trackers"]
    np.testing.assert_allclose(waist.positions, found.positions[:, 0] - [0.0, 0.0, 0.7], atol=1e-4)
    assert np.abs((waist.rotations * found.rotations[:, 0]).sum(-1)).min() > 0.99999
    assert resample(found, 45.0).extra[0].positions.shape == resample(found, 45.0).positions[:, 0].shape
    write_csv(tmp_path / "own.csv", found)
    again = read_recording(tmp_path / "own.csv").extra[0]
    np.testing.assert_allclose(again.positions, waist.positions, atol=1e-5)
    assert again.name == "waist"


@pytest.mark.parametrize(
    "message",
    [
        lambda s, a, name, pose: f"{s:.5f} {a} {name} {' '.join(pose)}",
        lambda s, a, name, pose: f'[{s:.5f}] {a} ,sfffffff "{name}" {" ".join(pose)}',
        lambda s, a, name, pose: (
            f'{{"time": {s:.5f}, "address": "{a}", "args": ["{name}", {", ".join(pose)}]}}'
        ),
        lambda s, a, name, pose: f"/VMC/Ext/T {s:.5f}\n{a} {name} {' '.join(pose)}",
    ],
)
def test_messages_of_vmc(tmp_path, walk, message) -> None:
    who = (
        ("/VMC/Ext/Hmd/Pos", "hmd"),
        ("/VMC/Ext/Con/Pos", "LeftController"),
        ("/VMC/Ext/Con/Pos", "RightController"),
    )
    lines = [
        message(second, *who[i], [f"{value:.7f}" for value in pose])
        for second, row in zip(walk.times, columns(walk, "RUF"), strict=True)
        for i, pose in enumerate(row)
    ]
    found = read(tmp_path, "\n".join(lines))
    assert is_walk(found, walk) and found.found["format"] == "VMC messages"


def test_folders_with_a_table_a_device_and_trial(tmp_path, walk) -> None:
    rows = columns(walk, "RUF")
    half = len(walk) // 2
    for trial, part in enumerate((slice(0, half), slice(half, None)), 1):
        for i, name in enumerate(("hmd_movement", "left_hand_movement", "right_hand_movement")):
            lines = ["time,pos_x,pos_y,pos_z,rot_x,rot_y,rot_z,rot_w"]
            for second, pose in zip(walk.times[part], rows[part, i], strict=True):
                lines.append(",".join(f"{value:.7f}" for value in (31.0 + second, *pose)))
            file = tmp_path / "S001" / "trackers" / f"{name}_T{trial:03d}.csv"
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text("\n".join(lines))
    (tmp_path / "S001" / "trial_results.csv").write_text("trial,score\n1,2\n")
    assert is_walk(read_recording(tmp_path), walk)
    (tmp_path / "none").mkdir()
    with pytest.raises(InputError, match="no table of the headset"):
        read_recording(tmp_path / "none")

"""Three trackers as numbers and texts of other programs."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

AXES = {"R": (1, 0, 0), "L": (-1, 0, 0), "F": (0, 1, 0), "B": (0, -1, 0), "U": (0, 0, 1), "D": (0, 0, -1)}
Files = bytes | dict[str, bytes]
START = datetime(2024, 5, 3, 10, 20, 30, tzinfo=UTC)
EPOCH = START.timestamp()
SECOND_OF_TICKS = 10_000_000


@dataclass(frozen=True)
class Motion:
    """Three trackers in Footwork's axes, metres and seconds."""

    times: np.ndarray
    positions: np.ndarray
    """`(T, 3, 3)`."""
    rotations: np.ndarray
    """`(T, 3, 4)` w x y z."""

    def poses(self, axes: str, turn: str = "xyzw", scale: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
        """Places `(T, 3, 3)` and numbers of rotations `(T, 3, k)` as a file in other axes has them."""
        change = np.array([AXES[letter] for letter in axes], dtype=np.float64)
        turns = Rotation.from_quat(np.roll(self.rotations, -1, axis=-1).reshape(-1, 4)).as_matrix()
        turned = Rotation.from_matrix(change @ turns @ change.T)
        shape = (*self.positions.shape[:2], -1)
        return scale * self.positions @ change.T, written(turned, turn).reshape(shape)


def written(turns: Rotation, how: str) -> np.ndarray:
    """Numbers `(n, k)` of rotations."""
    name, _, unit = how.partition("-")
    if name in ("xyzw", "wxyz"):
        return np.roll(turns.as_quat(), int(name == "wxyz"), axis=-1)
    if name == "matrix":
        return turns.as_matrix().reshape(-1, 9)
    if name == "columns":
        return turns.as_matrix().transpose(0, 2, 1).reshape(-1, 9)
    if name == "sixd":
        return turns.as_matrix()[:, :, :2].transpose(0, 2, 1).reshape(-1, 6)
    if name == "pairs":
        return turns.as_matrix()[:, :, :2].reshape(-1, 6)
    if name == "vector":
        return turns.as_rotvec(degrees=unit == "deg")
    if name == "rotator":
        yaw, pitch, roll = turns.as_euler("ZYX", degrees=unit == "deg").T
        return np.stack([-pitch, yaw, -roll], axis=-1)
    angles = turns.as_euler(name, degrees=unit == "deg")
    out = np.empty_like(angles)
    for column, letter in enumerate(name):
        out[:, "XYZ".index(letter)] = angles[:, column]
    return out


Row = list[Any]


def text(header: Row | None, rows: Iterable[Row], mark: str = ",", digits: int = 6, end: str = "\n") -> str:
    """A table; texts with the mark in them are quoted."""
    out = io.StringIO()
    writer = csv.writer(out, delimiter=mark, lineterminator=end)
    if header is not None:
        writer.writerow(header)
    for row in rows:
        writer.writerow([f"{cell:.{digits}f}" if isinstance(cell, float) else cell for cell in row])
    return out.getvalue()


def wide(
    motion: Motion, names: Callable[[int, str], str], parts: str, axes: str, turn: str, **how: Any
) -> str:
    """A table with one row a frame: time, then three trackers with `parts` words for components."""
    places, turns = motion.poses(axes, turn, how.pop("scale", 1.0))
    times = how.pop("times", motion.times)
    title = how.pop("title", "time")
    words = parts.split()
    order = how.pop("order", (0, 1, 2))
    header = [title, *(names(i, word) for i in order for word in words)]
    body = np.concatenate([places, turns], axis=-1)[:, order].reshape(len(places), -1)
    rows = [[time, *map(float, row)] for time, row in zip(times, body, strict=True)]
    return text(header, rows, **how)


def long(motion: Motion, labels: list[str], header: str, axes: str, turn: str, **how: Any) -> str:
    """A table with one row a device: a label, a time, seven or more numbers."""
    places, turns = motion.poses(axes, turn, how.pop("scale", 1.0))
    times = how.pop("times", motion.times)
    grouped = how.pop("grouped", False)
    body = np.concatenate([places, turns], axis=-1)
    pairs = [(f, i) for f in range(len(body)) for i in range(3)]
    if grouped:
        pairs.sort(key=lambda pair: pair[1])
    rows = [[labels[i], times[f], *map(float, body[f, i])] for f, i in pairs]
    return text(header.split(), rows, **how)


def plain(data: Any) -> bytes:
    return json.dumps(data).encode()


def lines(rows: Iterable[Any]) -> bytes:
    return "\n".join(json.dumps(row) for row in rows).encode() + b"\n"


def keyed(names: str, values: np.ndarray) -> dict[str, float]:
    return dict(zip(names.split(), np.round(values, 7).tolist(), strict=True))


def row_list(values: np.ndarray) -> list[Any]:
    return np.round(values, 7).tolist()


def frames(motion: Motion, axes: str, turn: str, make: Callable[..., Any], scale: float = 1.0) -> list[Any]:
    """`make(time, places, turns)` of every frame."""
    places, turns = motion.poses(axes, turn, scale)
    return [make(float(t), p, q) for t, p, q in zip(motion.times, places, turns, strict=True)]


def matrices(motion: Motion, axes: str, rows: int, by_columns: bool = False) -> np.ndarray:
    """`(T, 3, 4 * rows)` matrices of poses."""
    places, turns = motion.poses(axes, "matrix")
    out = np.zeros((*places.shape[:2], 4, 4))
    out[..., :3, :3] = turns.reshape(*places.shape[:2], 3, 3)
    out[..., :3, 3] = places
    out[..., 3, 3] = 1.0
    out = out[..., :rows, :]
    return (out.swapaxes(-1, -2) if by_columns else out).reshape(*places.shape[:2], -1)


XYZ, QUAT = "x y z", "x y z w"
DEVICES = ("head", "left", "right")
ENGLISH = ("Headset", "LeftController", "RightController")
SEVEN = "pos_x pos_y pos_z rot_x rot_y rot_z rot_w"

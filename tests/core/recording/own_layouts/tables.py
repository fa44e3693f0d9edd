"""Seventy layouts of tables: columns, rows, files and texts."""

from __future__ import annotations

import gzip
from collections.abc import Callable
from datetime import timedelta
from typing import Any

import numpy as np

from .writing import (
    DEVICES,
    ENGLISH,
    EPOCH,
    SECOND_OF_TICKS,
    SEVEN,
    START,
    Files,
    Motion,
    lines,
    long,
    matrices,
    row_list,
    text,
    wide,
)


def matrix_tables() -> dict[str, Callable[[Motion], Files]]:
    def table(m: Motion, body: np.ndarray, name: Callable[[int, int], str], title: str = "time") -> bytes:
        header = [title, *(name(i, k) for i in range(3) for k in range(body.shape[-1]))]
        rows = [
            [float(t), *map(float, row)] for t, row in zip(m.times, body.reshape(len(body), -1), strict=True)
        ]
        return text(header, rows).encode()

    def posed(
        m: Motion, axes: str, how: str, suffix: Callable[[int], str], names: tuple[str, ...] = DEVICES
    ) -> bytes:
        body = np.concatenate(m.poses(axes, how), axis=-1)
        return table(
            m, body, lambda i, k: f"{names[i]}_p{'xyz'[k]}" if k < 3 else f"{names[i]}_{suffix(k - 3)}"
        )

    return {
        "3x3": lambda m: posed(m, "RUB", "matrix", lambda k: f"m{k // 3}{k % 3}"),
        "3x3 from 1": lambda m: posed(m, "RUF", "matrix", lambda k: f"r{k // 3 + 1}{k % 3 + 1}"),
        "3x3 counted": lambda m: posed(m, "FLU", "matrix", lambda k: f"rot_{k}"),
        "3x4": lambda m: table(
            m, matrices(m, "RUB", 3), lambda i, k: f"{DEVICES[i]}_m{k // 4}{k % 4}", "timestamp"
        ),
        "4x4": lambda m: table(m, matrices(m, "RUF", 4), lambda i, k: f"{ENGLISH[i]}.matrix.{k}"),
        "4x4 by columns": lambda m: table(m, matrices(m, "RUB", 4, True), lambda i, k: f"{DEVICES[i]}_mat_{k}"),
        "4x4 from 1": lambda m: table(
            m, matrices(m, "RUB", 4), lambda i, k: f"{('hmd', 'left', 'right')[i]}_m{k // 4 + 1}{k % 4 + 1}"
        ),
        "6-D": lambda m: posed(m, "RUB", "sixd", lambda k: f"rot6d_{k}"),
        "6-D pairs": lambda m: posed(m, "RUF", "pairs", lambda k: f"6d_{'abcdef'[k]}"),
        "4x4 in JSON": lambda m: lines(
            {"t": float(t), **{n: row_list(row[i].reshape(4, 4)) for i, n in enumerate(DEVICES)}}
            for t, row in zip(m.times, matrices(m, "RUB", 4), strict=True)
        ),
    }  # fmt: skip


def angle_tables() -> dict[str, Callable[[Motion], Files]]:
    def of(axes: str, turn: str, words: str, scale: float = 1.0) -> Callable[[Motion], Files]:
        return lambda m: wide(
            m, lambda i, w: f"{ENGLISH[i]} {w}", words, axes, turn, title="Time (s)", scale=scale
        ).encode()

    euler = "pos.x pos.y pos.z rot.x rot.y rot.z"
    unreal = "X Y Z Pitch Yaw Roll"
    return {
        "Unity ZXY": of("RUF", "YXZ-deg", euler),
        "WebXR YXZ": of("RUB", "YXZ-rad", euler),
        "three.js XYZ": of("RUB", "XYZ-rad", euler.replace("rot", "euler")),
        "Blender XYZ": of("RFU", "ZYX-deg", euler.replace("rot", "rotation")),
        "Unreal": of("FRU", "rotator-deg", unreal, 100.0),
        "Unreal in metres": of("FRU", "rotator-deg", unreal),
        "robot": of("FLU", "ZYX-rad", euler),
        "rotation vector": of("RUB", "vector-rad", euler.replace("rot", "rotvec")),
        "units in names": of("RUF", "YXZ-deg", "posX(m) posY(m) posZ(m) eulerX(deg) eulerY(deg) eulerZ(deg)"),
        "ZXY": of("RUB", "ZXY-deg", euler),
    }  # fmt: skip


def long_tables() -> dict[str, Callable[[Motion], Files]]:
    seven = " x y z qx qy qz qw"
    iso = lambda m: [(START + timedelta(seconds=float(t))).isoformat() for t in m.times]  # noqa: E731
    return {
        "device": lambda m: long(m, list(ENGLISH), "device time" + seven, "RUB", "xyzw").encode(),
        "tracker": lambda m: long(m, ["hmd", "lhand", "rhand"], "tracker timestamp" + seven, "RUF", "xyzw").encode(),
        "paths": lambda m: long(
            m, ["/user/head", "/user/hand/left", "/user/hand/right"], "path time" + seven, "RUB", "xyzw"
        ).encode(),
        "node": lambda m: long(
            m, ["Head", "LeftHand", "RightHand"], "node t" + seven, "RUF", "xyzw", mark=";"
        ).encode(),
        "wxyz": lambda m: long(m, list(DEVICES), "name time px py pz qw qx qy qz", "FLU", "wxyz").encode(),
        "grouped": lambda m: long(
            m, list(ENGLISH), "object time" + seven, "RUB", "xyzw", grouped=True
        ).encode(),
        "iso": lambda m: long(m, list(DEVICES), "role utc" + seven, "RUB", "xyzw", times=iso(m)).encode(),
        "centimetres": lambda m: long(
            m,
            ["HMD", "MotionControllerLeft", "MotionControllerRight"],
            "source time" + seven,
            "FRU",
            "xyzw",
            scale=100.0,
        ).encode(),
        "angles": lambda m: long(m, list(DEVICES), "joint time x y z rx ry rz", "RUF", "YXZ-deg").encode(),
        "frame": lambda m: long(
            m, list(ENGLISH), "device frame" + seven, "RUB", "xyzw", times=list(range(len(m.times)))
        ).encode(),
    }  # fmt: skip


def folders() -> dict[str, Callable[[Motion], Files]]:
    def of(
        names: tuple[str, ...],
        header: str,
        axes: str,
        turn: str = "xyzw",
        mark: str = ",",
        scale: float = 1.0,
    ) -> Callable[[Motion], Files]:
        def make(m: Motion) -> Files:
            body = np.concatenate(m.poses(axes, turn, scale), axis=-1)
            return {
                name: text(
                    header.split(),
                    ([float(t), *map(float, row)] for t, row in zip(m.times, body[:, i], strict=True)),
                    mark,
                ).encode()
                for i, name in enumerate(names)
            }

        return make

    seven = "time x y z qx qy qz qw"
    return {
        "plain": of(("head.csv", "left.csv", "right.csv"), seven, "RUB"),
        "hmd": of(("hmd.csv", "lcontroller.csv", "rcontroller.csv"), seven, "RUF"),
        "trackers": of(
            ("trackers/headset_movement.csv", "trackers/lefthand_movement.csv", "trackers/righthand_movement.csv"),
            "time pos_x pos_y pos_z rot_x rot_y rot_z", "RUF", "YXZ-deg",
        ),
        "semicolons": of(("Head.txt", "LeftHand.txt", "RightHand.txt"), seven, "RUB", mark=";"),
        "tabs": of(("HMD.tsv", "Left.tsv", "Right.tsv"), seven, "FLU", mark="\t"),
        "named": of(
            ("s01_head.csv", "s01_left_hand.csv", "s01_right_hand.csv"), "timestamp px py pz qx qy qz qw", "RUB"
        ),
        "wxyz": of(("headset.csv", "controller_l.csv", "controller_r.csv"), "t x y z qw qx qy qz", "RFU", "wxyz"),
        "centimetres": of(
            ("hmd.csv", "left.csv", "right.csv"), "time X Y Z Pitch Yaw Roll", "FRU", "rotator-deg", scale=100.0
        ),
        "matrices": of(
            ("head.csv", "left.csv", "right.csv"),
            "time px py pz m00 m01 m02 m10 m11 m12 m20 m21 m22", "RUB", "matrix",
        ),
        "below": of(
            ("take1/Camera.csv", "take1/ControllerLeft.csv", "take1/ControllerRight.csv"), seven, "RUF"
        ),
    }  # fmt: skip


def vectors_in_cells() -> dict[str, Callable[[Motion], Files]]:
    def of(
        style: str,
        axes: str,
        turn: str = "xyzw",
        mark: str = ",",
        words: tuple[str, str] = ("position", "rotation"),
    ) -> Callable[[Motion], Files]:
        left, right = {"(": "()", "[": "[]", "{": "{}", "<": ("<", ">"), "": ("", "")}[style[:1]]
        between = style[1:] or ", "

        def cell(values: np.ndarray) -> str:
            return left + between.join(f"{value:.6f}" for value in values) + right

        def make(m: Motion) -> Files:
            places, turns = m.poses(axes, turn)
            header = ["time", *(f"{n}_{word}" for n in ENGLISH for word in words)]
            rows = [
                [float(t), *(cell(v) for i in range(3) for v in (p[i], q[i]))]
                for t, p, q in zip(m.times, places, turns, strict=True)
            ]
            return text(header, rows, mark).encode()

        return make

    def tables(m: Motion, mark: str) -> bytes:
        places, turns = m.poses("RUB")
        rows = [
            [float(t), ENGLISH[i], str(tuple(row_list(p[i]))), str(tuple(row_list(q[i])))]
            for t, p, q in zip(m.times, places, turns, strict=True)
            for i in range(3)
        ]
        return text(["time", "device", "position", "rotation"], rows, mark).encode()

    return {
        "round": of("(, ", "RUF"),
        "square": of("[, ", "RUB"),
        "square, spaces": of("[ ", "RUB"),
        "curly": of("{, ", "RUF"),
        "tabs": of("(, ", "RUB", mark="\t"),
        "semicolons within": of("(; ", "RUF"),
        "angles": of("(, ", "RUF", "YXZ-deg", words=("pos", "euler")),
        "wxyz": of("[, ", "FLU", "wxyz", words=("loc", "quat")),
        "long": lambda m: tables(m, ","),
        "long, bars": lambda m: tables(m, "|"),
    }  # fmt: skip


def text_dress() -> dict[str, Callable[[Motion], Files]]:
    def base(m: Motion, **how: Any) -> str:
        return wide(m, lambda i, w: f"{ENGLISH[i]}_{w}", SEVEN, "RUB", "xyzw", **how)

    def decimal_commas(m: Motion) -> str:
        return base(m, mark=";").replace(".", ",")

    def units_below(m: Motion) -> str:
        head, _, rest = base(m).partition("\n")
        return f"{head}\n{','.join(['s', *(['m'] * 3 + ['-'] * 4) * 3])}\n{rest}"

    def two_rows(m: Motion) -> str:
        _, _, rest = base(m).partition("\n")
        groups = ["", *(cell for n in ENGLISH for cell in (n, *[""] * 6))]
        return f"{','.join(groups)}\n{','.join(['time', *SEVEN.split() * 3])}\n{rest}"

    def with_nulls(m: Motion) -> str:
        rows = base(m).splitlines()
        rows[40] = ",".join([*rows[40].split(",")[:8], *["null"] * 7, *rows[40].split(",")[15:]])
        return "\n".join(rows) + "\n"

    return {
        "decimal commas": lambda m: decimal_commas(m).encode(),
        "UTF-16": lambda m: base(m).encode("utf-16"),
        "mark at the start": lambda m: base(m, end="\r\n").encode("utf-8-sig"),
        "gzip": lambda m: gzip.compress(base(m).encode()),
        "comments": lambda m: ("# Kite 1.2\n# subject: 7\n\n" + base(m)).encode(),
        "units below": lambda m: units_below(m).encode(),
        "two rows of names": lambda m: two_rows(m).encode(),
        "null": lambda m: with_nulls(m).encode(),
        "Latin-1": lambda m: ("# Gerät: Größe M\n" + base(m)).encode("latin-1"),
        "bars": lambda m: base(m, mark="|").encode(),
    }  # fmt: skip


def clocks() -> dict[str, Callable[[Motion], Files]]:
    def of(title: str, times: Callable[[Motion], list[Any]]) -> Callable[[Motion], Files]:
        return lambda m: wide(
            m, lambda i, w: f"{DEVICES[i]}_{w}", SEVEN, "RUF", "xyzw", title=title, times=times(m)
        ).encode()

    def dates(m: Motion, form: str) -> list[str]:
        return [(START + timedelta(seconds=float(t))).strftime(form) for t in m.times]

    return {
        "ms": of("time_ms", lambda m: [round(1000 * t) for t in m.times]),
        "us": of("timestamp_us", lambda m: [round(1e6 * t) for t in m.times]),
        "ns": of("timestamp (ns)", lambda m: [round(1e9 * t) for t in m.times]),
        "epoch in seconds": of("unix", lambda m: [EPOCH + float(t) for t in m.times]),
        "epoch in ms": of("timestamp", lambda m: [round(1000 * (EPOCH + t)) for t in m.times]),
        "ticks": of("ticks", lambda m: [round(SECOND_OF_TICKS * (62_135_596_800 + EPOCH + t)) for t in m.times]),
        "date": of("datetime", lambda m: dates(m, "%Y-%m-%d %H:%M:%S.%f")),
        "clock": of("time", lambda m: dates(m, "%H:%M:%S.%f")),
        "frames": of("frame", lambda m: list(range(len(m.times)))),
        "unnamed ms": of("time", lambda m: [float(1000 * t) for t in m.times]),
    }  # fmt: skip

"""Thirty layouts of JSON: objects, arrays and lines."""

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
    QUAT,
    START,
    XYZ,
    Files,
    Motion,
    frames,
    keyed,
    lines,
    plain,
    row_list,
)


def _pose(
    place: np.ndarray, turn: np.ndarray, words: tuple[str, str] = ("position", "rotation")
) -> dict[str, Any]:
    return {words[0]: keyed(XYZ, place), words[1]: keyed(QUAT, turn)}


def json_objects() -> dict[str, Callable[[Motion], Files]]:
    def cell(words: tuple[str, str], names: tuple[str, ...]) -> Callable[..., Any]:
        return lambda t, p, q: {"t": t, **{n: _pose(p[i], q[i], words) for i, n in enumerate(names)}}

    return {
        "frames": lambda m: plain({"frames": frames(m, "RUB", "xyzw", cell(("position", "orientation"), DEVICES))}),
        "samples": lambda m: plain(
            {
                "meta": {"app": "Kite", "hz": 60, "tags": ["a", "b"]},
                "samples": frames(m, "RUF", "xyzw", cell(("pos", "quat"), ("hmd", "leftHand", "rightHand"))),
            }
        ),
        "list of devices": lambda m: plain(
            frames(
                m,
                "RUB",
                "xyzw",
                lambda t, p, q: {
                    "timestamp": t,
                    "devices": [{"role": n, **_pose(p[i], q[i])} for i, n in enumerate(DEVICES)],
                },
            )
        ),
        "inputs": lambda m: plain(
            {
                "log": frames(
                    m,
                    "RUB",
                    "xyzw",
                    lambda t, p, q: {
                        "ms": round(1000 * t, 3),
                        "viewer": _pose(p[0], q[0]),
                        "inputs": [
                            {"handedness": n, "gripPose": _pose(p[i], q[i])} for i, n in ((1, "left"), (2, "right"))
                        ],
                    },
                )
            }
        ),
        "by device": lambda m: plain(
            {
                n: [
                    {"time": float(t), **_pose(p[i], q[i])}
                    for t, p, q in zip(m.times, *m.poses("RUF"), strict=True)
                ]
                for i, n in enumerate(("HMD", "L_Controller", "R_Controller"))
            }
        ),
        "numbered": lambda m: plain(
            {
                str(k): row
                for k, row in enumerate(frames(m, "RUB", "xyzw", cell(("p", "q"), ("head", "left", "right"))))
            }
        ),
        "wxyz": lambda m: plain(
            {
                "data": frames(
                    m,
                    "FLU",
                    "wxyz",
                    lambda t, p, q: {
                        "stamp": t,
                        **{
                            n: {"loc": keyed(XYZ, p[i]), "rot": keyed("w x y z", q[i])}
                            for i, n in enumerate(ENGLISH)
                        },
                    },
                )
            }
        ),
        "capital": lambda m: plain(
            {
                "Recording": {
                    "Frames": frames(
                        m,
                        "RUF",
                        "xyzw",
                        lambda t, p, q: {
                            "Time": t,
                            **{
                                n: {"Position": keyed("X Y Z", p[i]), "Rotation": keyed("X Y Z W", q[i])}
                                for i, n in enumerate(("Head", "LeftHand", "RightHand"))
                            },
                        },
                    )
                }
            }
        ),
        "centimetres": lambda m: plain(
            {"frames": frames(m, "FRU", "xyzw", cell(("location", "rotation"), ("hmd", "left", "right")), 100.0)}
        ),
        "grouped": lambda m: plain(
            frames(
                m,
                "RUB",
                "xyzw",
                lambda t, p, q: {
                    "time": t,
                    "head": _pose(p[0], q[0]),
                    "hands": {"left": _pose(p[1], q[1]), "right": _pose(p[2], q[2])},
                },
            )
        ),
    }  # fmt: skip


def json_arrays() -> dict[str, Callable[[Motion], Files]]:
    def listed(names: tuple[str, ...], words: tuple[str, str]) -> Callable[..., Any]:
        return lambda t, p, q: {
            "time": t,
            **{n: {words[0]: row_list(p[i]), words[1]: row_list(q[i])} for i, n in enumerate(names)},
        }

    def columns(m: Motion, axes: str, name: Callable[[str, str], str], turn: str = "xyzw") -> dict[str, Any]:
        places, turns = m.poses(axes, turn)
        parts = [*(f"pos_{c}" for c in "xyz"), *(f"rot_{c}" for c in turn)]
        body = np.concatenate([places, turns], axis=-1)
        return {
            name(n, part): row_list(body[:, i, k])
            for i, n in enumerate(DEVICES)
            for k, part in enumerate(parts)
        }

    def table(m: Motion) -> tuple[list[str], list[Any]]:
        places, turns = m.poses("RUB")
        names = ["t", *(f"{n}.{p}" for n in DEVICES for p in ("px", "py", "pz", "qx", "qy", "qz", "qw"))]
        body = np.concatenate([places, turns], axis=-1).reshape(len(places), -1)
        return names, row_list(np.c_[m.times, body])

    def block(m: Motion, axes: str, words: tuple[str, str], names: tuple[str, ...]) -> dict[str, Any]:
        places, turns = m.poses(axes)
        return {
            n: {words[0]: row_list(places[:, i]), words[1]: row_list(turns[:, i])}
            for i, n in enumerate(names)
        }

    return {
        "vectors": lambda m: plain(frames(m, "RUB", "xyzw", listed(DEVICES, ("position", "quaternion")))),
        "vectors wxyz": lambda m: plain(
            {"frames": frames(m, "FLU", "wxyz", listed(("hmd", "lhand", "rhand"), ("pos", "quat")))}
        ),
        "seven": lambda m: plain(
            frames(
                m,
                "RUF",
                "xyzw",
                lambda t, p, q: {"time": t, **{n: row_list(np.r_[p[i], q[i]]) for i, n in enumerate(DEVICES)}},
            )
        ),
        "columns": lambda m: plain({"time": row_list(m.times), **columns(m, "RUB", lambda n, p: f"{n}_{p}")}),
        "columns below": lambda m: plain(
            {"clock": row_list(m.times), "channels": columns(m, "RUF", lambda n, p: f"{n}/{p}")}
        ),
        "header row": lambda m: plain([table(m)[0], *table(m)[1]]),
        "split": lambda m: plain({"columns": table(m)[0], "data": table(m)[1], "index": list(range(len(m.times)))}),
        "blocks": lambda m: plain({"time": row_list(m.times), **block(m, "RUB", ("positions", "rotations"), DEVICES)}),
        "blocks capital": lambda m: plain(
            {"Timestamps": row_list(1000 * m.times), "Tracks": block(m, "RUF", ("Pos", "Rot"), ENGLISH)}
        ),
        "devices with times": lambda m: plain(
            {
                n: {"time": row_list(m.times), **pose}
                for n, pose in block(m, "RUB", ("position", "orientation"), ("headset", "left", "right")).items()
            }
        ),
    }  # fmt: skip


def json_lines() -> dict[str, Callable[[Motion], Files]]:
    def each(m: Motion, axes: str, make: Callable[..., Any]) -> list[Any]:
        places, turns = m.poses(axes)
        return [
            make(float(t), i, p[i], q[i])
            for t, p, q in zip(m.times, places, turns, strict=True)
            for i in range(3)
        ]

    def whole(m: Motion, axes: str, names: tuple[str, ...], turn: str = "xyzw") -> list[Any]:
        return frames(
            m, axes, turn, lambda t, p, q: {"ts": t, **{n: _pose(p[i], q[i]) for i, n in enumerate(names)}}
        )

    def flat(t: float, p: np.ndarray, q: np.ndarray) -> dict[str, float]:
        out = {"time": t}
        for i, n in enumerate(("hmd", "left", "right")):
            out |= keyed(f"{n}_x {n}_y {n}_z {n}_qx {n}_qy {n}_qz {n}_qw", np.r_[p[i], q[i]])
        return out

    return {
        "whole": lambda m: lines(whole(m, "RUB", DEVICES)),
        "whole, Unity": lambda m: lines(whole(m, "RUF", ("centerEye", "leftHand", "rightHand"))),
        "flat": lambda m: lines(frames(m, "RUF", "xyzw", flat)),
        "event a device": lambda m: lines(
            each(m, "RUB", lambda t, i, p, q: {"t": t, "device": ENGLISH[i], **_pose(p, q)})
        ),
        "event a device, lists": lambda m: lines(
            each(m, "FLU", lambda t, i, p, q: {"time": t, "name": DEVICES[i], "pos": row_list(p), "quat": row_list(q)})
        ),
        "epoch": lambda m: lines(
            each(
                m,
                "RUF",
                lambda t, i, p, q: {
                    "epoch_ms": round(1000 * (EPOCH + t)),
                    "tracker": ("hmd", "left_hand", "right_hand")[i],
                    "x": p[0], "y": p[1], "z": p[2], "qx": q[0], "qy": q[1], "qz": q[2], "qw": q[3],
                },
            )
        ),
        "notes between": lambda m: lines([{"type": "header", "version": 2, "game": "Kite"}, *whole(m, "RUB", DEVICES)]),
        "payload": lambda m: lines(
            {"event": "pose", "payload": row} for row in whole(m, "RUB", ("head", "leftController", "rightController"))
        ),
        "iso": lambda m: lines(
            {**row, "ts": (START + timedelta(seconds=row["ts"])).isoformat()} for row in whole(m, "RUF", DEVICES)
        ),
        "gzip": lambda m: gzip.compress(lines(whole(m, "RUB", ("hmd", "l", "r")))),
    }  # fmt: skip

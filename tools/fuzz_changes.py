"""How sound files are changed for fuzzing: bytes, or values, shapes and counts within their structure."""

from __future__ import annotations

import copy
import io
import json
import random
import re
import struct
from typing import Any

import numpy as np
from footwork.core.npz import write_npz

GENTLE = 0.6
"""Share of the structured changes that leave a file of its kind, so that much is read and carried on."""
REPLAY_FLOATS = 60 * 23
"""At the end of the sound replay."""
NUMBERS = (
    "0",
    "-1",
    "1",
    "nan",
    "inf",
    "-inf",
    "1e300",
    "1e-310",
    "1e6",
    "-1e9",
    "99999999",
    "9" * 400,
    "",
    "x",
    "0.5",
)
VALUES: tuple[Any, ...] = (
    None,
    True,
    0,
    -1,
    3,
    1e6,
    1e300,
    10**250,
    2.5,
    "",
    "text",
    [],
    {},
    [1],
    {"a": 1},
    [[[]]],
)


def change_bytes(rng: random.Random, content: bytes) -> bytes:
    """Bits, bytes and stretches changed, lost, doubled or put elsewhere."""
    out = bytearray(content)
    for _ in range(rng.choice((1, 1, 2, 5, 20))):
        at, length = rng.randrange(max(1, len(out))), min(rng.choice((1, 2, 8, 100)), len(out))
        way = rng.randrange(6)
        if way == 0 and out:
            out[at] ^= 1 << rng.randrange(8)
        elif way == 1:
            out[at : at + length] = rng.randbytes(length)
        elif way == 2:
            del out[at : at + length]
        elif way == 3:
            out[at:at] = out[at : at + length] * rng.choice((1, 3, 50))
        elif way == 4 and rng.random() < 0.3:
            del out[at:]
        else:
            other = rng.randrange(max(1, len(out)))
            out[at:at] = out[other : other + length]
    return bytes(out)


def nearby(rng: random.Random, value: float) -> float:
    """A number that differs a little."""
    return value * rng.uniform(0.95, 1.05) + rng.uniform(-0.01, 0.01)


def change_figures(rng: random.Random, content: bytes) -> bytes:
    """Some numbers of a text's rows made a little different, or a row lost or doubled where nothing counts them."""
    lines = content.decode().split("\n")
    rows = [at for at, line in enumerate(lines) if line[:1].isdigit() or line[:1] == "-"]
    for at in rng.sample(rows, min(len(rows), rng.choice((1, 2, 10, 40)))):
        numbers = list(re.finditer(r"-?\d+\.\d+(?:e-?\d+)?", lines[at]))
        if numbers:
            number = rng.choice(numbers)
            changed = f"{nearby(rng, float(number[0])):.6f}"
            lines[at] = lines[at][: number.start()] + changed + lines[at][number.end() :]
    return "\n".join(lines).encode()


def change_text(rng: random.Random, content: bytes) -> bytes:
    """Numbers replaced, lines lost, doubled or swapped; every other time only numbers moved a little."""
    if rng.random() < GENTLE:
        return change_figures(rng, content)
    lines = content.decode().split("\n")
    for _ in range(rng.choice((1, 1, 2, 4))):
        at, way = rng.randrange(len(lines)), rng.randrange(8)
        if way == 0 and len(lines) > 1:
            del lines[at]
        elif way == 1:
            lines[at:at] = [lines[at]] * rng.choice((1, 2, 300))
        elif way == 2:
            other = rng.randrange(len(lines))
            lines[at], lines[other] = lines[other], lines[at]
        else:
            # half of them where the words are, not among the rows
            at = rng.randrange(min(len(lines), 150)) if rng.random() < 0.5 else at
            found = list(re.finditer(r"-?\d+(?:\.\d+)?(?:e-?\d+)?", lines[at]))
            if found:
                number = rng.choice(found)
                lines[at] = (
                    lines[at][: number.start()] + new_number(rng, number[0]) + lines[at][number.end() :]
                )
    return "\n".join(lines).encode()


def new_number(rng: random.Random, old: str) -> str:
    """Another one in its place."""
    if rng.random() < 0.5:
        return rng.choice(NUMBERS)
    return repr(float(old) * rng.choice((-1.0, 0.0, 0.5, 1.1, 10.0, 1e3, 1e6, 1e-6)))


def change_json(rng: random.Random, content: bytes) -> bytes:
    """Values replaced, lost, doubled or nested; every other time only numbers moved a little, or texts replaced."""
    value = json.loads(content)
    if rng.random() < GENTLE:
        for _ in range(rng.choice((1, 2, 10, 40))):
            change_leaf(rng, value)
        return json.dumps(value).encode()
    for _ in range(rng.choice((1, 1, 2, 4))):
        change_value(rng, value)
    return json.dumps(value).encode()


def change_leaf(rng: random.Random, value: Any) -> None:
    """One number or text within a value, kept in its kind."""
    while True:
        keys = list(value) if isinstance(value, dict) else list(range(len(value)))
        if not keys:
            return
        key = rng.choice(keys)
        inner = value[key]
        if isinstance(inner, dict | list):
            value = inner
            continue
        if isinstance(inner, bool):
            value[key] = not inner
        elif isinstance(inner, int):
            value[key] = inner + rng.choice((0, 0, 1, -1))
        elif isinstance(inner, float):
            value[key] = nearby(rng, inner)
        elif isinstance(inner, str):
            value[key] = rng.choice((inner, inner.upper(), f"{inner}2", f"\u00e4{inner}", "x\x1b[2J\ny"))
        return


def change_value(rng: random.Random, value: Any) -> None:
    """One place within a value."""
    while True:
        keys = list(value) if isinstance(value, dict) else list(range(len(value)))
        if not keys:
            return
        key = rng.choice(keys)
        inner = value[key]
        if isinstance(inner, dict | list) and inner and rng.random() < 0.8:
            value = inner
            continue
        if rng.random() < 0.2:
            del value[key]
        elif isinstance(inner, int | float) and rng.random() < 0.5:
            value[key] = inner * rng.choice((-1, 0, 10, 1000, 10**9, 0.1))
        else:
            value[key] = copy.deepcopy(rng.choice((*VALUES, [inner], {"x": inner}, [inner] * 50)))
        return


def change_npz(rng: random.Random, content: bytes) -> bytes:
    """Values, kinds, shapes and lengths of arrays changed, arrays lost."""
    with np.load(io.BytesIO(content)) as found:
        arrays = {name: found[name] for name in found.files}
    whole = dict(arrays)
    gentle = rng.random() < GENTLE
    for _ in range(rng.choice((1, 1, 2, 3))):
        name = rng.choice(list(arrays))
        if gentle:
            arrays[name] = move_array(rng, arrays[name])
            continue
        if name == "header" and arrays[name] is whole[name] and rng.random() < 0.9:
            arrays[name] = np.frombuffer(change_json(rng, arrays[name].tobytes()), np.uint8)
        elif rng.random() < 0.05 and len(arrays) > 1:
            del arrays[name]
        else:
            arrays[name] = change_array(rng, arrays[name])
    file = io.BytesIO()
    write_npz(file, arrays, compressed=rng.random() < 0.3)
    return file.getvalue()


def move_array(rng: random.Random, array: np.ndarray) -> np.ndarray:
    """Its values moved a little, one or all of them; flags turned; names renamed. What counts stays."""
    out = np.array(array)
    if out.size == 0 or out.dtype.kind not in "fbU":
        return out
    at = np.unravel_index(rng.randrange(out.size), out.shape)
    if out.dtype.kind == "b":
        out[at] = not out[at]
    elif out.dtype.kind == "U":
        out = np.asarray(out.astype(f"<U{out.dtype.itemsize // 4 + 1}"))
        out[at] = f"{out[at]}2" if out.ndim else out[at]
    elif rng.random() < 0.5:
        out[at] = nearby(rng, float(out[at]))
    else:
        noise = np.random.default_rng(rng.randrange(1 << 32)).normal(size=out.shape)
        out = (out * (1.0 + rng.choice((1e-4, 1e-3, 0.02)) * noise)).astype(out.dtype)
    return out


def change_array(rng: random.Random, array: np.ndarray) -> np.ndarray:
    """One array, in one way."""
    out = np.array(array)
    way = rng.randrange(7)
    with np.errstate(all="ignore"):
        if way <= 2 and out.size:
            at = np.unravel_index(rng.randrange(out.size), out.shape)
            if out.dtype.kind == "f":
                out[at] = rng.choice(
                    (0.0, -1.0, 1e30, -1e30, np.nan, np.inf, 1e-38, float(out[at]) * 1.01, 1e4)
                )
            elif out.dtype.kind in "iu":
                out[at] = rng.choice((0, 1, 2, 100))
            elif out.dtype.kind == "b":
                out[at] = not out[at]
            else:
                out[at] = rng.choice(("", "x", "hips", "{}", "\x1b[2J\n"))
        elif way == 3 and out.dtype.kind in "fiu":
            out = np.asarray(out * rng.choice((0, -1, 2, 1000, 1.01))).astype(out.dtype)
        elif way == 4 and out.ndim:
            out = rng.choice(
                (out[:-1], np.concatenate([out, out]), out[::-1].copy(), out[:0], out[None], out.T)
            )
        elif way == 5:
            out = (
                out.astype(rng.choice(("<f8", ">f4", "<i8", "?", "<U9", "<f2")))
                if out.dtype.kind != "U"
                else out
            )
        elif way == 6 and out.size:
            out = rng.choice((out.reshape(-1), np.asarray(out.flat[0]), np.repeat(out.reshape(-1), 3)))
    return out


def change_replay(rng: random.Random, content: bytes) -> bytes:
    """Counts and floats of a binary replay; every other time only floats of its frames, moved a little."""
    out = bytearray(content)
    if rng.random() < GENTLE:
        for _ in range(rng.choice((1, 2, 10, 40))):
            at = len(out) - 4 * rng.randrange(1, REPLAY_FLOATS)
            out[at : at + 4] = struct.pack("<f", nearby(rng, struct.unpack("<f", out[at : at + 4])[0]))
        return bytes(out)
    for _ in range(rng.choice((1, 2, 5))):
        at = 4 * rng.randrange(2, len(out) // 4 - 1) + rng.randrange(4)
        value = rng.choice((0, 1, -1, 2**31 - 1, 1000)) if rng.random() < 0.3 else None
        number = rng.choice((0.0, np.nan, np.inf, 1e30, -1.0, 1e-40, 90.0))
        out[at : at + 4] = struct.pack("<i", value) if value is not None else struct.pack("<f", number)
    return bytes(out)

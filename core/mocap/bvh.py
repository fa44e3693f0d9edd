"""BVH files as they stand: file units, file axes, every channel; reading, writing and forward kinematics.

The format: Biovision's hierarchy and motion text file. A joint's position channels replace its offset, as
in Blender's importer, MotionBuilder and the data sets in use; an axis without a channel keeps its offset.
"""

from __future__ import annotations

import codecs
import hashlib
import io
import os
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from ..bounds import BVH_NUMBER
from ..errors import InputError
from ..maths import quat
from ..transaction import Transaction, write_atomically
from .bvh_header import Header, header_end, parse_header

Array = NDArray[np.floating[Any]]

CHANNELS = ("Xposition", "Yposition", "Zposition", "Xrotation", "Yrotation", "Zrotation")
_SNIFF = 1 << 16
_UTF16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
_CTRL_Z = b"\x1a"
"""The end of a file in old systems."""
_HEADER_LIMIT = 1 << 24
"""A hierarchy larger than 16 MB is noise."""
_NUMBER_LIMIT = 64
"""No sane writer spends more bytes than this on one number and the space around it."""


@dataclass(frozen=True, slots=True, eq=False)
class BvhFile:
    """What a BVH file says, unchanged."""

    names: tuple[str, ...]
    """Joint names `(J,)`, in file order: each joint is followed by all that hangs on it."""
    parents: NDArray[np.intp]
    """`(J,)`, -1 for the root."""
    offsets: Array
    """`(J, 3)`, file units and axes."""
    channels: tuple[tuple[str, ...], ...]
    """Each joint's channels in file order, each one of `CHANNELS`."""
    end_sites: Array
    """`(E, 3)` offsets of the end sites, ordered by the joint that they hang on."""
    end_parents: NDArray[np.intp]
    """`(E,)` the joint of each end site."""
    frame_time: float
    """Seconds between two frames, as written in the file."""
    values: Array
    """`(T, C)` channel values in file order: lengths in file units, angles in degrees."""
    file: str
    """File name as given; "" for one that was not read."""
    sha256: str
    zero_is_a_frame: bool = False
    """Whether the zero pose is but one of the motion's own poses, and no pose that the skeleton was made in."""
    doubts: tuple[str, ...] = ()
    """What is odd about the file, and was read all the same."""

    def __len__(self) -> int:
        return len(self.values)


def recognise(head: bytes) -> bool:
    """Whether the start of a file is that of a BVH file, in whatever text encoding."""
    text = head.removeprefix(b"\xef\xbb\xbf").replace(b"\0", b"").lstrip(b"\xff\xfe \t\r\n")
    return text[:9].upper() == b"HIERARCHY"


def read_bvh(path: str | os.PathLike[str], rate: float | None = None) -> BvhFile:
    """Read a BVH file.

    Args:
        path: the file.
        rate: frames per second, in place of the file's.

    Raises:
        InputError: the file is missing, not BVH, or broken; names the line.
    """
    name = str(path)
    try:
        with Path(path).open("rb") as stream:
            start = stream.read(_SNIFF)
            if start.startswith(_UTF16):
                return parse_bvh(_as_utf8(start + stream.read(), name), name, rate)
            _check_start(start, name)
            while len(start) < (header_end(start) or _HEADER_LIMIT):
                more = stream.read(len(start))
                if not more:
                    break
                start += more
            # parsed before the rest is read: a header that is noise, or a body far too long, ends here
            header = parse_header(start, name, rate)
            size = os.fstat(stream.fileno()).st_size
            if size - header.body > _NUMBER_LIMIT * (header.columns + 1) * (header.frames + 1000):
                raise InputError(
                    f"{name}: line {header.frames_line}: {size} bytes are too many for the {header.frames} frames "
                    "that Frames: promises; correct that number"
                )
            data = start + stream.read()
    except IsADirectoryError:
        raise InputError(f"{name}: is a folder; give a BVH file") from None
    except OSError as error:
        raise InputError(f"{name}: {error.strerror or error}; give a BVH file that can be read") from error
    return _build(data, header, name)


def _as_utf8(data: bytes, file: str) -> bytes:
    try:
        return data.decode("utf-16").encode()
    except UnicodeError:
        raise InputError(f"{file}: line 1: not UTF-16 text, though it begins so; save it as UTF-8") from None


def parse_bvh(data: bytes, file: str, rate: float | None = None) -> BvhFile:
    """A BVH file from its bytes; `file` is the name used in messages, `rate` as for `read_bvh`.

    Raises:
        InputError: not BVH, or broken; names the line.
    """
    _check_start(data[:_SNIFF], file)
    return _build(data, parse_header(data, file, rate), file)


def write_bvh(path: str | os.PathLike[str], bvh: BvhFile, outputs: Transaction | None = None) -> None:
    """Write a BVH file that reads back equal to the last bit, at once or in a transaction.

    Raises:
        InputError: the file cannot be written.
    """
    text = format_bvh(bvh).encode()

    def write(stream: BinaryIO) -> None:
        stream.write(text)

    write_atomically(path, write, outputs)


def format_bvh(bvh: BvhFile) -> str:
    """The text of a BVH file: every number by its shortest exact form.

    Raises:
        ValueError: the joints are not in file order, so that the values would go to the wrong ones.
    """
    count = len(bvh.names)
    children = [np.flatnonzero(bvh.parents == joint).tolist() for joint in range(count)]
    ends = [np.flatnonzero(bvh.end_parents == joint).tolist() for joint in range(count)]
    lines = ["HIERARCHY"]
    expected = 0
    todo: list[tuple[int, int]] = [(0, 0)]
    while todo:
        joint, depth = todo.pop()
        tab = "\t" * depth
        if joint < 0:
            lines.append(f"{tab}}}")
            continue
        if joint != expected:
            raise ValueError(f"joint {bvh.names[joint]} is not in file order")
        expected += 1
        lines += [f"{tab}{'JOINT' if depth else 'ROOT'} {bvh.names[joint]}", f"{tab}{{"]
        lines.append(f"{tab}\tOFFSET {_numbers(bvh.offsets[joint])}")
        lines.append(" ".join([f"{tab}\tCHANNELS {len(bvh.channels[joint])}", *bvh.channels[joint]]))
        for end in ends[joint]:
            offset = _numbers(bvh.end_sites[end])
            lines += [f"{tab}\tEnd Site", f"{tab}\t{{", f"{tab}\t\tOFFSET {offset}", f"{tab}\t}}"]
        todo.append((-1, depth))
        todo += [(child, depth + 1) for child in reversed(children[joint])]
    lines.extend(["MOTION", f"Frames: {len(bvh)}", f"Frame Time: {bvh.frame_time!r}"])
    lines.extend(" ".join(map(repr, row)) for row in bvh.values.tolist())
    return "\n".join(lines) + "\n"


def local_transforms(bvh: BvhFile, joints: NDArray[np.intp] | None = None) -> tuple[Array, Array]:
    """Local positions `(T, K, 3)` in file units and rotations `(T, K, 4)` of all or some joints."""
    chosen = np.arange(len(bvh.names)) if joints is None else joints
    positions = np.repeat(bvh.offsets[None, chosen], len(bvh), axis=0)
    rotations = np.zeros((len(bvh), len(chosen), 4))
    starts = np.cumsum([0, *(len(names) for names in bvh.channels)])
    by_order: dict[str, list[tuple[int, list[int]]]] = {}
    for k, joint in enumerate(chosen.tolist()):
        turns: list[int] = []
        order = ""
        for column, channel in enumerate(bvh.channels[joint], start=int(starts[joint])):
            if channel.endswith("rotation"):
                turns.append(column)
                order += channel[0]
            else:
                positions[:, k, "XYZ".index(channel[0])] = bvh.values[:, column]
        by_order.setdefault(order, []).append((k, turns))
    for order, members in by_order.items():
        where = [k for k, _ in members]
        angles = np.radians(bvh.values[:, [columns for _, columns in members]])
        rotations[:, where] = _from_angles(angles, order)
    return positions, rotations


def _from_angles(angles: Array, order: str) -> Array:
    """Quaternions `(T, K, 4)` of intrinsic angles `(T, K, n)` in radians about the `n` axes of `order`."""
    if not order:
        return np.broadcast_to(quat.IDENTITY, (*angles.shape[:2], 4))
    q = quat.from_axis(order[0], angles[..., 0])
    for i, axis in enumerate(order[1:], start=1):
        q = quat.multiply(q, quat.from_axis(axis, angles[..., i]))
    return q


def _numbers(values: Array) -> str:
    return " ".join(map(repr, values.tolist()))


def _check_start(start: bytes, file: str) -> None:
    text = start.removeprefix(b"\xef\xbb\xbf").lstrip()
    if not text:
        raise InputError(f"{file}: line 1: the file is empty; give a BVH file")
    if text[:9].upper() != b"HIERARCHY":
        raise InputError(f"{file}: line 1: is not BVH, which starts with the word HIERARCHY; give a BVH file")


def _build(data: bytes, header: Header, file: str) -> BvhFile:
    doubts: list[str] = []
    body = data[header.body :]
    if body.rstrip().endswith(_CTRL_Z):
        body = body.rstrip().rstrip(_CTRL_Z)
        doubts.append("the file ends with a Ctrl-Z, as in old systems: it may have been cut there")
    if header.frames == 0 and body.strip() and header.columns:
        header.frames = sum(1 for line in body.splitlines() if line.strip())
        doubts.append(f"the file says Frames: 0 and has {header.frames} rows: they are read")
    if header.frames == 0:
        raise InputError(f"{file}: line {header.frames_line}: the file has no frames; export it anew")
    values = _parse_values(body, header, file)
    order = np.argsort(np.array(header.end_parents, dtype=np.intp), kind="stable")
    return BvhFile(
        names=tuple(header.names),
        parents=np.array(header.parents, dtype=np.intp),
        offsets=np.array(header.offsets, dtype=np.float64).reshape(-1, 3),
        channels=tuple(header.channels),
        end_sites=np.array(header.end_sites, dtype=np.float64).reshape(-1, 3)[order],
        end_parents=np.array(header.end_parents, dtype=np.intp)[order],
        frame_time=header.frame_time,
        values=values,
        file=file,
        sha256=hashlib.sha256(data).hexdigest(),
        doubts=tuple(doubts),
    )


def _parse_values(body: bytes, header: Header, file: str) -> Array:
    """The body's numbers `(T, C)`; whatever is wrong is then looked for line by line."""
    if b"\n" not in body and b"\r" in body:
        body = body.replace(b"\r", b"\n")
    if header.columns == 0:
        return np.zeros((header.frames, 0))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # an empty body warns, and is told below in our words
            values = np.loadtxt(io.BytesIO(body), comments=None, ndmin=2, encoding="latin-1")
    except ValueError:
        values = np.zeros((0, 0))
    if values.shape != (header.frames, header.columns) or not (np.abs(values) < BVH_NUMBER).all():
        raise InputError(_first_fault(body, header, file))
    return np.ascontiguousarray(values)


def _first_fault(body: bytes, header: Header, file: str) -> str:
    """One line about the first row that is not `header.columns` finite numbers, or about their count."""
    rows = 0
    number = header.body_line - 1
    for number, line in enumerate(body.splitlines(), start=header.body_line):
        words = line.split()
        if not words:
            continue
        where = f"{file}: line {number}: "
        if rows == header.frames:
            return f"{where}more rows than the {header.frames} that Frames: promises; correct that number"
        bad = next((word for word in words if not _is_number(word)), None)
        if bad is not None:
            word = bad[:40].decode("ascii", "replace")
            return f"{where}{word!r} is not a finite number; repair it or export anew"
        if len(words) != header.columns:
            return f"{where}{len(words)} numbers where {header.columns} channels need one each; export anew"
        rows += 1
    return f"{file}: line {number}: the file ends after {rows} of {header.frames} frames; export it anew"


def _is_number(word: bytes) -> bool:
    try:
        return abs(float(word)) < BVH_NUMBER
    except ValueError:
        return False

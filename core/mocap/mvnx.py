"""MVNX: Xsens' own XML, with the place and the turn of every segment in every frame.

Metres, Z up, X ahead; a segment's place is that of the joint that it begins at. The frame of type "tpose" shows the
T-pose.
The parser knows no entities and no document types, so that no small file can become a large one.
"""

from __future__ import annotations

import hashlib
import os
from itertools import pairwise
from pathlib import Path
from typing import Any
from xml.parsers import expat

import numpy as np
from numpy.typing import NDArray

from ..body import hierarchy
from ..bounds import BVH_NUMBER, DEPTH, FRAMES, JOINTS, TAKE_BYTES, TAKE_RATE
from ..errors import FaultError, InputError
from ..maths import quat
from .bvh import BvhFile
from .poses import bvh_of_poses

Array = NDArray[np.floating[Any]]

_CHUNK = 1 << 20
_LONGEST_TEXT = 1 << 20
"""Bytes of the numbers of one frame."""
_TPOSE = "tpose"
_LIMBS = {
    "": "Pelvis L5 L3 T12 T8 Neck Head",
    "T8": "{}Shoulder {}UpperArm {}ForeArm {}Hand",
    "Pelvis": "{}UpperLeg {}LowerLeg {}Foot {}Toe",
}
"""Chains of segments under a segment, of files that do not say what hangs on what."""


def recognise(head: bytes) -> bool:
    """Whether the start of a file is that of an MVNX file, in whatever text encoding."""
    text = head.replace(b"\0", b"").lstrip(b"\xef\xbb\xbf\xff\xfe \t\r\n")
    return text.startswith(b"<") and b"<mvnx" in text


def read_mvnx(path: str | os.PathLike[str], rate: float | None = None) -> BvhFile:
    """Read an MVNX file.

    Args:
        path: the file.
        rate: frames per second, in place of the file's.

    Raises:
        InputError: the file is missing, broken, or not of one person; names the line where it can.
    """
    name = str(path)
    scanner = _Scanner()
    digest = hashlib.sha256()
    try:
        with Path(path).open("rb") as stream:
            if os.fstat(stream.fileno()).st_size > TAKE_BYTES:
                raise InputError(f"{name}: larger than {TAKE_BYTES // 1_000_000} MB; export it in parts")
            while chunk := stream.read(_CHUNK):
                digest.update(chunk)
                scanner.feed(chunk)
        scanner.close()
        return _take(scanner, name, digest.hexdigest(), rate)
    except expat.ExpatError as error:
        what = expat.ErrorString(error.code)
        raise InputError(f"{name}: line {error.lineno}: broken XML ({what}); export the file anew") from None
    except FaultError as fault:
        raise InputError(f"{name}: {fault}; export the file anew") from None
    except OSError as error:
        raise InputError(f"{name}: {error.strerror or error}; give an MVNX file that can be read") from error


class _Scanner:
    """Goes through the elements of a file, and keeps what a take needs."""

    def __init__(self) -> None:
        self.parser = expat.ParserCreate()
        self.parser.buffer_text = True
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.CharacterDataHandler = self._text
        self.parser.StartDoctypeDeclHandler = self._refuse
        self.parser.EntityDeclHandler = self._refuse
        self.open: list[str] = []
        self.subjects = 0
        self.rate = ""
        self.segments: list[str] = []
        self.links: list[tuple[str, str]] = []
        self.frame = ""
        """Type of the frame that is open."""
        self.pieces: list[str] = []
        self.size = 0
        self.values: dict[str, Array] = {}
        """Of the frame that is open."""
        self.tpose: dict[str, Array] = {}
        self.positions: list[Array] = []
        self.orientations: list[Array] = []

    def feed(self, chunk: bytes) -> None:
        """The next part of the file."""
        self.parser.Parse(chunk, False)

    def close(self) -> None:
        """The file's end."""
        self.parser.Parse(b"", True)

    def _refuse(self, *_: Any) -> None:
        raise self._fault("a document type, which no MVNX file has")

    def _fault(self, what: str) -> FaultError:
        return FaultError(f"line {self.parser.CurrentLineNumber}: {what}")

    def _start(self, tag: str, given: dict[str, str]) -> None:
        tag = tag.rpartition(":")[2]
        self.open.append(tag)
        if len(self.open) > DEPTH:
            raise self._fault("elements nested too deeply")
        self.pieces, self.size = [], 0
        if tag == "subject":
            self.subjects += 1
            self.rate = given.get("frameRate", "")
        elif tag == "segment":
            self.segments.append(given.get("label", "").strip())
            if len(self.segments) > JOINTS:
                raise self._fault(f"more than {JOINTS} segments")
        elif tag == "frame":
            self.frame, self.values = given.get("type", "normal"), {}

    def _text(self, text: str) -> None:
        if self.open and self.open[-1] in ("orientation", "position", "connector1", "connector2"):
            self.pieces.append(text)
            self.size += len(text)
            if self.size > _LONGEST_TEXT:
                raise self._fault(f"{self.open[-1]} of a frame is too long")

    def _end(self, _: str) -> None:
        tag = self.open.pop()
        inside = self.open[-1] if self.open else ""
        if tag in ("orientation", "position") and inside == "frame":
            self.values[tag] = self._numbers(tag, 4 if tag == "orientation" else 3)
        elif tag in ("connector1", "connector2") and inside == "joint":
            segment = "".join(self.pieces).strip().partition("/")[0]
            if tag == "connector1":
                self.links.append((segment, ""))
            elif self.links:
                self.links[-1] = (self.links[-1][0], segment)
        elif tag == "frame":
            self._close_frame()
        self.pieces = []

    def _numbers(self, tag: str, width: int) -> Array:
        words = "".join(self.pieces).split()
        wanted = width * len(self.segments)
        if len(words) != wanted:
            raise self._fault(
                f"{len(words)} numbers in {tag} where {len(self.segments)} segments need {wanted}"
            )
        try:
            values = np.array(words, dtype=np.float64)
        except ValueError:
            raise self._fault(f"a word among the numbers of {tag}") from None
        if not (np.abs(values) < BVH_NUMBER).all():
            raise self._fault(f"a number in {tag} that is not finite")
        return values.reshape(-1, width)

    def _close_frame(self) -> None:
        normal = self.frame == "normal"
        if not normal and self.frame != _TPOSE:
            return
        missing = [tag for tag in ("orientation", "position") if tag not in self.values]
        if missing:
            raise self._fault(f"a frame without {missing[0]}")
        if (np.linalg.norm(self.values["orientation"], axis=-1) < 0.5).any():
            raise self._fault("an orientation that is no rotation")
        if not normal:
            self.tpose = self.values
            return
        if len(self.positions) >= FRAMES:
            raise self._fault(f"more than {FRAMES} frames")
        self.positions.append(self.values["position"])
        self.orientations.append(self.values["orientation"])


def _take(scanner: _Scanner, file: str, sha256: str, rate: float | None) -> BvhFile:
    """The take that was found in a file."""
    if scanner.subjects != 1:
        raise FaultError(f"{scanner.subjects} people (subjects) in one file, where one is read")
    if not scanner.positions:
        raise FaultError("no frames")
    fps = _rate(scanner.rate) if rate is None else rate
    if fps is None:
        raise InputError(f"{file}: frameRate {scanner.rate!r} is no rate; say it with --rate")
    order, parents = _hierarchy(scanner.segments, scanner.links)
    positions = np.stack(scanner.positions)[:, order]
    rotations = quat.normalize(np.stack(scanner.orientations)[:, order])
    doubts: list[str] = []
    if scanner.tpose:
        rest = scanner.tpose["position"][order]
        zero = quat.normalize(scanner.tpose["orientation"][order])
    else:
        # segments have the world's axes in T-pose, by the format's definition
        doubts.append("the file has no frame of type tpose: its first frame's lengths are taken")
        zero = np.tile(quat.IDENTITY, (len(order), 1))
        rest = _unturned(positions[0], rotations[0], parents)
    rotations = quat.multiply(rotations, quat.conjugate(zero))
    names = [scanner.segments[segment] for segment in order]
    return bvh_of_poses(
        names, parents, rest, positions, rotations, fps=fps, file=file, sha256=sha256, doubts=doubts
    )


def _rate(text: str) -> float | None:
    try:
        rate = float(text)
    except ValueError:
        return None
    return rate if TAKE_RATE[0] <= rate <= TAKE_RATE[1] else None


def _unturned(positions: Array, rotations: Array, parents: NDArray[np.intp]) -> Array:
    """Positions `(J, 3)` of a frame's segments, turned to the world's axes."""
    out = np.array(positions)
    for joint in range(1, len(parents)):
        above = parents[joint]
        way = quat.rotate(quat.conjugate(rotations[above]), positions[joint] - positions[above])
        out[joint] = out[above] + way
    return out


def _hierarchy(names: list[str], links: list[tuple[str, str]]) -> tuple[list[int], NDArray[np.intp]]:
    """The segments with parents before children, and each one's parent in that order, -1 for the first."""
    index = {name: segment for segment, name in enumerate(names)}
    if len(index) < len(names) or "" in index:
        raise FaultError("segments without a name, or two of one name")
    parents = [-1] * len(names)
    for above, below in links or _usual_links():
        if above in index and below in index:
            parents[index[below]] = index[above]
    order = [segment for segment, parent in enumerate(parents) if parent < 0]
    roots = len(order)
    for segment in order:
        order += [child for child, parent in enumerate(parents) if parent == segment]
    if roots != 1 or len(order) != len(names):
        raise FaultError(f"its {len(names)} segments do not hang together as one body")
    return order, hierarchy.part(parents, order)


def _usual_links() -> list[tuple[str, str]]:
    links: list[tuple[str, str]] = []
    for start, chain in _LIMBS.items():
        for side in ("Right", "Left") if start else ("",):
            names = [start, *(name.format(side) for name in chain.split())][not start :]
            links += pairwise(names)
    return links

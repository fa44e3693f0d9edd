"""The text before a BVH file's numbers: the hierarchy, the number of frames and the frame time."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field

from ..bounds import BVH_NUMBER, DEPTH, FRAME_TIME, JOINT_FRAMES, JOINTS
from ..errors import InputError

_NUMBER = r"[-+.\w]+"
_STATEMENT = re.compile(
    r"""[ \t\r\n]*(?:
      (?P<hierarchy>HIERARCHY)\b
    | (?P<root>ROOT)[ \t]+(?P<root_name>[^\r\n{}]+)
    | (?P<joint>JOINT)[ \t]+(?P<joint_name>[^\r\n{}]+)
    | (?P<end>End[ \t]+\w+|EndSite\b)[^\r\n{}]*
    | (?P<open>\{)
    | (?P<close>\})
    | OFFSET\b(?P<offset>(?:[ \t]+"""
    + _NUMBER
    + r"""){3})
    | CHANNELS[ \t]+(?P<count>\d{1,6})
    | (?P<motion>MOTION)\b
    )""",
    re.VERBOSE | re.IGNORECASE,
)
_DECIMAL_COMMA = re.compile(r"OFFSET[ \t]+[-+]?\d+,\d", re.IGNORECASE)
_WORD = re.compile(r"[ \t]+([^\s{}]+)")
_FRAMES = re.compile(r"\s*Frames\s*:?\s*([-+.\w]+)[^\S\n]*", re.IGNORECASE)
_FRAME_TIME = re.compile(r"\s*Frame[ \t_]*Time\s*:?\s*([-+.,\w]+)[^\S\n]*\n?", re.IGNORECASE)
_BODY = re.compile(rb"[\s}]MOTION\s+Frames", re.IGNORECASE)
_SPACE = re.compile(r"[ \t\r\n]*")
_CHANNEL = re.compile(r"([XYZ])(position|rotation)", re.IGNORECASE)


@dataclass(slots=True)
class Header:
    """A hierarchy as it is read."""

    names: list[str] = field(default_factory=list[str])
    parents: list[int] = field(default_factory=list[int])
    offsets: list[list[float]] = field(default_factory=list[list[float]])
    channels: list[tuple[str, ...]] = field(default_factory=list[tuple[str, ...]])
    end_sites: list[list[float]] = field(default_factory=list[list[float]])
    end_parents: list[int] = field(default_factory=list[int])
    frames: int = 0
    frames_line: int = 0
    """The number of the line that says so."""
    frame_time: float = 0.0
    body: int = 0
    """Where in the bytes the rows start."""
    body_line: int = 0
    """The number of the first row's line."""

    @property
    def columns(self) -> int:
        """Numbers in a row."""
        return sum(map(len, self.channels))


def parse_header(data: bytes, file: str, rate: float | None = None) -> Header:
    """Read everything before the rows.

    Args:
        data: the file's bytes, at least up to the line with the frame time.
        file: name for messages.
        rate: frames per second, whatever the frame time says.

    Raises:
        InputError: broken; names the line.
    """
    # latin-1 keeps one character for each byte, so positions are byte positions; names are decoded later
    return _Scanner(data[: header_end(data)].decode("latin-1"), file, rate).header()


def header_end(data: bytes) -> int | None:
    """A place in the bytes safely past the header's last line, or None where the header is not complete."""
    found = _BODY.search(data)
    return None if found is None else found.end() + 1024


class _Scanner:
    """Goes through the statements of a hierarchy, minding the braces."""

    def __init__(self, text: str, file: str, rate: float | None) -> None:
        self.text = text
        self.file = file
        self.rate = rate
        self.at = 3 if text.startswith("ï»¿") else 0  # the byte order mark, read as latin-1
        self.result = Header()
        self.open: list[int] = []
        """Joints whose braces are open; -1 for an end site."""
        self.pending: int | None = None
        """The joint, or -1 for an end site, whose opening brace comes next."""

    def header(self) -> Header:
        """Scan it all."""
        while True:
            found = _STATEMENT.match(self.text, self.at)
            if found is None:
                rest = self.text[self.skip() :][:40].split()
                if not rest:
                    raise self.fault("the file ends before MOTION; export it anew", len(self.text.rstrip()))
                what = "is not expected here"
                if rest[0].upper() in ("OFFSET", "CHANNELS", "ROOT", "JOINT"):
                    what = "lacks what should follow it"
                    if _DECIMAL_COMMA.match(self.text, self.skip()):
                        what = "is followed by numbers with decimal commas, where BVH has points"
                raise self.fault(f"{rest[0]!r} {what}; export the file anew", self.skip())
            start, self.at = self.skip(), found.end()
            if found["motion"]:
                self.check_closed(start)
                return self.motion()
            self.statement(found, start)

    def statement(self, found: re.Match[str], start: int) -> None:
        """One statement of the hierarchy."""
        if self.pending is not None and not found["open"]:
            raise self.fault("an opening brace is missing; export the file anew", start)
        if found["root"] or found["joint"]:
            self.begin_joint(found["root_name"] or found["joint_name"], bool(found["root"]), start)
        elif found["end"]:
            self.result.end_parents.append(self.current(start))
            self.result.end_sites.append([0.0, 0.0, 0.0])
            self.pending = -1
        elif found["open"]:
            if self.pending is None:
                raise self.fault("an opening brace without a joint; export the file anew", start)
            self.open.append(self.pending)
            self.pending = None
        elif found["close"]:
            if not self.open:
                raise self.fault("a closing brace too many; export the file anew", start)
            self.open.pop()
        elif found["offset"]:
            self.offset(found["offset"], start)
        elif found["count"]:
            self.channels(int(found["count"]), start)

    def begin_joint(self, name: str, root: bool, start: int) -> None:
        """A ROOT or JOINT line."""
        result = self.result
        if root and result.names:
            raise self.fault("a second ROOT; split the file, one person each", start)
        if len(result.names) == JOINTS or len(self.open) == DEPTH:
            what = (
                f"more than {JOINTS} joints"
                if len(self.open) < DEPTH
                else f"{DEPTH} joints hang on one another"
            )
            raise self.fault(f"{what}, which is no body; give a file of one person", start)
        result.parents.append(-1 if root else self.current(start))
        result.names.append(_decode(name.strip()))
        result.offsets.append([0.0, 0.0, 0.0])
        result.channels.append(())
        self.pending = len(result.names) - 1

    def current(self, start: int) -> int:
        """The joint whose braces are open."""
        if not self.open or self.open[-1] < 0:
            raise self.fault("a joint stands outside of any other; export the file anew", start)
        return self.open[-1]

    def offset(self, text: str, start: int) -> None:
        """An OFFSET line of a joint or an end site."""
        values = [self.number(word, start) for word in text.split()]
        if not self.open:
            raise self.fault("OFFSET outside of a joint; export the file anew", start)
        if self.open[-1] < 0:
            self.result.end_sites[-1] = values
        else:
            self.result.offsets[self.open[-1]] = values

    def channels(self, count: int, start: int) -> None:
        """A CHANNELS line."""
        joint = self.current(start)
        names: list[str] = []
        for _ in range(count):
            found = _WORD.match(self.text, self.at)
            word = "" if found is None else found[1]
            known = _CHANNEL.fullmatch(word)
            if found is None or known is None:
                what = f"unknown channel {word[:40]!r}" if word else f"{len(names)} of {count} channels"
                raise self.fault(f"{what}; use Xposition to Zposition and Xrotation to Zrotation", start)
            self.at = found.end()
            names.append(known[1].upper() + known[2].lower())
        positions = [name for name in names if name.endswith("position")]
        if len(set(positions)) < len(positions) or len(names) - len(positions) > 3:
            raise self.fault("a joint has a channel twice; export the file anew", start)
        if self.result.channels[joint]:
            raise self.fault("a second CHANNELS line for one joint; export the file anew", start)
        self.result.channels[joint] = tuple(names)

    def check_closed(self, start: int) -> None:
        """MOTION comes after the hierarchy is closed."""
        if self.open or self.pending is not None:
            raise self.fault("MOTION before all braces are closed; export the file anew", start)
        if not self.result.names:
            raise self.fault("a hierarchy without joints; export the file anew", start)

    def motion(self) -> Header:
        """The two lines after MOTION."""
        result = self.result
        found = _FRAMES.match(self.text, self.at)
        if found is None:
            raise self.fault("Frames: is missing after MOTION; export the file anew", self.skip())
        count = self.number(found[1], self.skip())
        if count != int(count) or count < 0:
            raise self.fault(f"Frames: {found[1]} is not a count; correct it", self.skip())
        result.frames, result.frames_line = int(count), self.line(self.skip())
        joints = len(result.names)
        if joints > result.columns and joints * result.frames > JOINT_FRAMES:
            raise self.fault(
                f"{result.frames} frames of {joints} joints with {result.columns} channels; export it anew",
                self.skip(),
            )
        self.at = found.end()
        found = _FRAME_TIME.match(self.text, self.at)
        if found is None:
            raise self.fault("Frame Time: is missing after Frames:; export the file anew", self.skip())
        stated = self.rate is not None
        result.frame_time = 1.0 / self.rate if self.rate is not None else self.number(found[1], self.skip())
        if result.frame_time <= 0.0:
            raise self.fault(
                f"Frame Time: {found[1]} is not a positive number of seconds; say the rate: --rate N",
                self.skip(),
            )
        if not stated and not FRAME_TIME[0] <= result.frame_time <= FRAME_TIME[1]:
            time = result.frame_time
            rate = f"{time:g}" if 10.0 <= time <= 1000.0 else "N"
            raise self.fault(
                f"Frame Time: {found[1]} is no time between two frames; say the rate: --rate {rate}",
                self.skip(),
            )
        result.body = found.end()
        result.body_line = self.line(result.body)
        return result

    def number(self, word: str, start: int) -> float:
        """A finite number, or a fault."""
        try:
            value = float(word)
        except ValueError:
            value = math.nan
        if not abs(value) < BVH_NUMBER:
            raise self.fault(f"{word[:40]!r} is not a finite number; repair or export anew", start)
        return value

    def skip(self) -> int:
        """Where the next statement starts: after the white space."""
        found = _SPACE.match(self.text, self.at)
        return self.at if found is None else found.end()

    def line(self, at: int) -> int:
        """The number of the line at a position."""
        before = self.text[:at]
        return 1 + (before.count("\n") or before.count("\r"))

    def fault(self, what: str, at: int) -> InputError:
        """An error that names the line."""
        return InputError(f"{self.file}: line {self.line(at)}: {what}")


def _decode(name: str) -> str:
    raw = name.encode("latin-1")
    try:
        return raw.decode("utf-8")
    except UnicodeDecodeError:
        return name

"""What the name of a column or of a value says: whose position or rotation it is, and which component.

Names are taken apart into words, so that `hmd_pos_x`, `CenterEye_PosX`, `head.position.x`, `h.p.x` and
`/user/hand/left.orientation.w` are understood alike.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

_HEAD = {
    "head",
    "kopf",
    "tete",
    "cabeza",
    "testa",
    "casque",
    "hmd",
    "headset",
    "camera",
    "cam",
    "viewer",
    "quest",
    "quest2",
    "quest3",
    "rift",
    "vive",
    "pico",
    "xrcamera",
    "camera3",
    "xrcamera3d",
    "view",
    "centereye",
    "eye",
    "cameraeye",
    "vrcamera",
    "h",
}
_SIDES = {
    "left": {
        "links",
        "linke",
        "gauche",
        "izquierda",
        "sinistra",
        "l",
        "lhand",
        "lcontroller",
        "ltouch",
        "lcon",
        "lctrl",
        "handl",
        "controllerl",
    },
    "right": {
        "rechts",
        "rechte",
        "droite",
        "derecha",
        "destra",
        "r",
        "rhand",
        "rcontroller",
        "rtouch",
        "rcon",
        "rctrl",
        "handr",
        "controllerr",
    },
}
HANDS = {"hand", "controller", "touch", "wand", "con", "grip", "ctrl"}
_OTHERS = {
    "waist", "pelvis", "hips", "hip", "chest", "foot", "feet", "ankle", "knee", "elbow", "shoulder", "toe", "spine",
    "back", "torso", "tracker",
}  # fmt: skip
_NOT_A_POSE = {
    "vel", "velocity", "speed", "angular", "linear", "acc", "accel", "acceleration", "stick", "thumbstick", "joystick",
    "trackpad", "touchpad", "gaze", "button", "buttons", "trigger", "axis", "axes", "pressed", "touched", "confidence",
    "battery", "finger", "thumb", "index", "middle", "ring", "pinky", "little", "joint", "bone", "scale", "gravity",
    "gamepad", "fixation", "pupil", "hit", "ray", "direction", "forward",
}  # fmt: skip
_PLACE = {
    "pos",
    "position",
    "positions",
    "loc",
    "location",
    "translation",
    "trans",
    "p",
    "t",
    "place",
    "coordinates",
    "origin",
}
_TURN = {
    "rot", "rotation", "rotations", "quat", "quaternion", "orientation", "ori", "orient", "q", "r", "euler", "angle",
    "angles", "rotvec", "rvec", "rotator", "attitude", "eulerangles",
}  # fmt: skip
_SIXD = {"sixd", "6d", "rot6d"}
_MATRIX = {"matrix", "mat", "transform", "m", "basis"}
_GLUED = re.compile(
    r"(pos|position|loc|location|rot|rotation|quat|quaternion|orientation|ori|euler|q|p|t|r)?([xyzw])"
)
_COUNTED = re.compile(r"(?:q|quat)([0-3]|[rijk])")
_COMPLEX = {"r": "w", "i": "x", "j": "y", "k": "z"}
_APART = {
    "local": 5, "parent": 5, "relative": 5, "target": 3, "spectator": 3, "aim": 2, "pointer": 2, "raw": 1, "grip": 0,
    "world": 0, "global": 0,
}  # fmt: skip
"""How far words beside a pose's own make it another pose than the one that is looked for; 1 for any other word."""
_CELL = re.compile(r"(?:m|r|mat|matrix)?([0-3])([0-3])")
ANGLES = ("pitch", "yaw", "roll")
METRES = {
    "m": 1.0,
    "meters": 1.0,
    "metres": 1.0,
    "cm": 0.01,
    "centimeters": 0.01,
    "mm": 0.001,
    "ft": 0.3048,
    "feet": 0.3048,
    "in": 0.0254,
    "inch": 0.0254,
    "inches": 0.0254,
}
DEGREES = {
    "deg": "degrees",
    "degree": "degrees",
    "degrees": "degrees",
    "rad": "radians",
    "radians": "radians",
}
SECONDS = {
    "s": 1.0, "sec": 1.0, "secs": 1.0, "seconds": 1.0, "ms": 1e-3, "msec": 1e-3, "milliseconds": 1e-3, "us": 1e-6,
    "microseconds": 1e-6, "ns": 1e-9, "nanoseconds": 1e-9, "ticks": 1e-7,
}  # fmt: skip
TIME = {
    "time",
    "timestamp",
    "timestamps",
    "clock",
    "elapsed",
    "utc",
    "datetime",
    "date",
    "displaytime",
    "ticks",
    "ts",
    "stamp",
    "epoch",
    "unix",
    "a",
    "t",
    "times",
}
_NUMBER = {
    "frame",
    "frames",
    "framenumber",
    "frameid",
    "framecount",
    "sample",
    "idx",
    "index",
    "n",
    "row",
    "frameindex",
}
_DEVICE = {
    "source",
    "device",
    "devicename",
    "devicetype",
    "tracker",
    "object",
    "name",
    "role",
    "type",
    "node",
    "part",
    "id",
}


_LABELS = {"hand", "handedness", "side", "joint", "class", "deviceclass", "message", "address", "controller"}


PARTS = {
    **{f"p{axis}": ("place", axis) for axis in "xyz"},
    **{f"q{axis}": ("turn", axis) for axis in "wxyz"},
    **{f"r{axis}": ("turn", axis) for axis in "xyz"},
    **{angle: ("turn", angle) for angle in ANGLES},
    **{f"m{row}{column}": ("matrix", f"{row}{column}") for row in range(3) for column in range(3)},
    **{f"sixd_{letter}": ("sixd", letter) for letter in "abcdef"},
}
"""What a person calls the components of a pose, and their kinds and components."""


@dataclass(frozen=True, slots=True)
class Meaning:
    """What one name says."""

    tracker: str = ""
    """"head", "left", "right", the words of another tracker, or "" for none."""
    kind: str = ""
    """"place", "turn", "sixd", "matrix" or "" where only the component is said."""
    part: str = ""
    """x y z w, pitch yaw roll, a digit, two digits of a matrix' row and column, or a to f of six numbers."""
    metres: float = 0.0
    """Of a unit of length that the name has, 0 for none."""
    angles: str = ""
    """"degrees", "radians" or ""."""
    beside: tuple[str, ...] = ()
    """What the name says beside tracker, kind and component."""


@dataclass(slots=True)
class Columns:
    """Which columns hold a tracker's pose."""

    place: list[int] = field(default_factory=list[int])
    turn: list[int] = field(default_factory=list[int])
    kind: str = ""
    """Of the rotation, as in `rotations.KINDS`, or "none"."""
    ordered: bool = True
    """Whether names tell the quaternion's w from the others."""
    last: list[int] = field(default_factory=list[int])
    """The start of a fourth row, which holds the place where matrices are written column by column."""


@dataclass(slots=True)
class Understood:
    """What all names of a table together say."""

    trackers: dict[str, Columns]
    time: int = -1
    seconds: float = 0.0
    """Of the time's unit; 0 where its numbers have to tell."""
    times: dict[str, int] = field(default_factory=dict[str, int])
    """Columns of times of a tracker's own."""
    several: list[str] = field(default_factory=list[str])
    """Trackers of which there is more than one pose."""
    number: int = -1
    """Column that counts frames."""
    device: int = -1
    """Column that says whose pose a row is."""
    labels: list[int] = field(default_factory=list[int])
    """This column and others that say more of it, such as a hand."""
    metres: float = 0.0
    angles: str = ""


def words_of(name: str) -> list[str]:
    """The words of a name, lower case and without accents: at capitals, separators and brackets."""
    if not name.isascii():
        name = "".join(c for c in unicodedata.normalize("NFKD", name) if not unicodedata.combining(c))
    spaced = re.sub(r"([a-z0-9])([A-Z])", r"\1 \2", name)
    spaced = re.sub(r"([A-Z]{2,})([A-Z][a-z])", r"\1 \2", spaced)
    return [word for word in re.split(r"[^0-9a-zA-Z]+", spaced.lower()) if word]


def whose(words: Sequence[str]) -> tuple[str, int]:
    """The tracker that words name, and how many words at most belong to its name; "" for none."""
    side, last = "", 0
    for number, word in enumerate(words):
        # a single letter is a side before all others or after a hand; "h.r.x" is of a head's rotation
        lone = len(word) == 1 and number > 0 and words[number - 1] not in HANDS
        for name, known in _SIDES.items():
            if not side and not lone and (word.startswith(name) or word in known):
                side, last = name, number + 1
    others = [number for number, word in enumerate(words) if word in _OTHERS]
    if len(others) == 1 and words[others[0]] == "tracker" and (side or _HEAD & set(words)):
        # a tracker of a hand or a head is theirs
        others = []
    if others:
        return " ".join(word for word in words[: others[-1] + 1]), others[-1] + 1
    if side and "eye" in words:
        return "", 0
    if side:
        return side, last
    heads = [number for number, word in enumerate(words) if word in _HEAD]
    return ("head", heads[0] + 1) if heads else ("", 0)


def meaning(name: str) -> Meaning:
    """What a column's name says of a pose; no tracker and no part where it says nothing."""
    words = words_of(name)
    metres = next((METRES[word] for word in words[1:] if word in METRES and word != "m"), 0.0)
    if re.search(r"[\[(]\s*m\s*[\])]", name):
        metres = 1.0
    degrees = next((DEGREES[word] for word in words if word in DEGREES), "")
    while len(words) > 1 and (words[-1] in METRES or words[-1] in DEGREES):
        words = words[:-1]
    if not words or _NOT_A_POSE & set(words):
        return Meaning()
    tracker, used = whose(words[:-1])
    kind, part = _component(words[used:] if tracker else words)
    if not part:
        return Meaning()
    return Meaning(
        tracker, kind, part, metres, degrees, tuple(word for word in words[:-1] if _is_beside(word))
    )


def _is_beside(word: str) -> bool:
    """Whether a word says something of a pose beside what it is of and what it is."""
    known = (
        word in _PLACE or word in _TURN or word in HANDS or word in _HEAD or word in _SIXD or word in _MATRIX
    )
    if word in ("x", "y", "z"):
        return False
    return word in _APART or not (known or word.isdecimal() or whose([word])[0])


def _component(words: Sequence[str]) -> tuple[str, str]:
    """Kind and component of the words after a tracker's name."""
    if not words:
        return "", ""
    body, last = words[:-1], words[-1]
    kind = ""
    for word in body:
        if word in _SIXD:
            kind = "sixd"
        elif word in _MATRIX and kind == "":
            kind = "matrix"
        elif word in _TURN:
            kind = "turn"
        elif word in _PLACE:
            kind = "place"
    if kind == "sixd" and last in "abcdef":
        return kind, last
    if last in ANGLES:
        return "turn", last
    counted = _COUNTED.fullmatch(last)
    if counted:
        return "turn", _COMPLEX.get(counted[1], counted[1])
    if "basis" in body and body[-1] in ("x", "y", "z") and last in ("x", "y", "z"):
        return "matrix", f"{'xyz'.index(last)}{'xyz'.index(body[-1])}"
    glued, cell = _GLUED.fullmatch(last), _CELL.fullmatch(last)
    if glued:
        if glued[1]:
            kind = "turn" if glued[1] in _TURN else "place"
        return ("turn" if glued[2] == "w" else kind or "place"), glued[2]
    digits = [word for word in words if word.isdecimal()]
    if cell and not digits:
        return "matrix", cell[1] + cell[2]
    if last.isdecimal() and len(last) <= 2:
        return kind, "".join(digits[-2:]) if len(digits) > 1 else last
    return "", ""


def understand(names: Sequence[str], said_of: Mapping[str, str] | None = None) -> Understood:
    """What the names of a table's columns say.

    Args:
        names: of the columns.
        said_of: what a person says of columns, by name, as in `corrections`.
    """
    out = Understood({})
    poses: dict[str, dict[tuple[str, ...], dict[str, dict[str, int]]]] = {}
    given = said_of or {}
    # what a person says comes first, so that no name takes its place
    for column, name in sorted(enumerate(names), key=lambda item: item[1] not in given):
        said = told_meaning(given[name]) if name in given else meaning(name)
        if said.part:
            pose = poses.setdefault(said.tracker, {}).setdefault(said.beside, {})
            pose.setdefault(said.kind, {}).setdefault(said.part, column)
            out.metres = out.metres or said.metres
            out.angles = out.angles or said.angles
        elif name not in given:
            _other(out, column, name)
        else:
            _other_told(out, column, given[name], name)
    for tracker, several in poses.items():
        beside = sorted(several, key=lambda words: sum(_APART.get(word, 1) for word in words))
        whole = [found for found in (_columns(several[words]) for words in beside) if found is not None]
        if not whole:
            kinds: dict[str, dict[str, int]] = {}
            for words in beside:
                for kind, parts in several[words].items():
                    kinds.setdefault(kind, parts)
            whole = [found for found in [_columns(kinds)] if found is not None]
        if not whole and tracker not in ("", "head", "left", "right"):
            # markers of motion capture have no rotation
            places = [_places(parts.get("place", {})) for parts in several.values()]
            whole = [Columns(found, [], "none") for found in places if found][:1]
        if whole:
            out.trackers[tracker] = whole[0]
        if len(whole) > 1 and tracker:
            out.several.append(tracker)
    return out


def told_meaning(text: str) -> Meaning:
    """What a person says of a column of a pose, such as "head.px" or "left.qw"; no part where it is of no pose."""
    tracker, point, part = text.rpartition(".")
    found = PARTS.get(part)
    return Meaning(tracker, found[0], found[1]) if point and tracker and found else Meaning()


def _other_told(out: Understood, column: int, text: str, name: str) -> None:
    """Take a column for time, frame number or device, as a person says."""
    word, _, unit = text.partition(" ")
    if word == "time":
        out.time = column
        out.seconds = SECONDS.get(unit, 0.0) or next(
            (SECONDS[word] for word in reversed(words_of(name)) if word in SECONDS), 0.0
        )
    elif word == "frame":
        out.number = column
    elif word == "device":
        out.device = column if out.device < 0 else out.device
        out.labels.append(column)


def _other(out: Understood, column: int, name: str) -> None:
    """Take a column that is of no pose for time, frame number or device."""
    words = words_of(name)
    if not words:
        return
    tracker = whose(words[:-1])[0] if words[-1] in TIME - {"a", "t"} else ""
    if tracker:
        out.times.setdefault(tracker, column)
    if out.time < 0 and (
        words[0] in TIME or TIME & set(words) - {"a", "t"} or name.strip().lower() in SECONDS
    ):
        out.time = column
        out.seconds = next((SECONDS[word] for word in reversed(words) if word in SECONDS), 0.0)
    elif out.number < 0 and words[0] in _NUMBER:
        out.number = column
    elif words[-1] in _DEVICE or words[-1] in _LABELS:
        out.device = column if out.device < 0 else out.device
        out.labels.append(column)


def _columns(kinds: dict[str, dict[str, int]]) -> Columns | None:
    """A tracker's pose of its named components; None without position or rotation."""
    bare = kinds.get("", {}) or kinds.get("matrix", {})
    whole = _whole(bare)
    if whole is not None:
        return whole
    place, turn = kinds.get("place", {}), kinds.get("turn", {})
    places = _places(place)
    if not places:
        return None
    for order, kind, ordered in (
        ("wxyz", "quaternion", True), ("0123", "quaternion", False), (ANGLES, "rotator", True), ("xyz", "euler", True),
        ("012", "euler", True),
    ):  # fmt: skip
        found = _picked(turn, order)
        # of more numbers in a list the first four are no quaternion
        if found and (order[0] != "0" or len(turn) == len(order)):
            return Columns(places, found, kind, ordered)
    for source, order, kind in (
        (kinds.get("sixd", {}), "abcdef", "sixd"), (kinds.get("sixd", {}), "012345", "sixd"), (turn, "012345", "sixd"),
        ({**turn, **kinds.get("matrix", {})}, [f"{r}{c}" for r in range(3) for c in range(3)], "matrix"),
        ({**turn, **kinds.get("matrix", {})}, [str(n) for n in range(9)], "matrix"),
    ):  # fmt: skip
        found = _picked(source, order)
        if found:
            return Columns(places, found, kind)
    return None


def _places(parts: dict[str, int]) -> list[int]:
    return _picked(parts, "xyz") or _picked(parts, "012")


def _whole(parts: dict[str, int]) -> Columns | None:
    """Columns of a pose in one list or matrix: 7 numbers, or 3 or 4 rows of 4."""
    high = 4 if len(parts) == 16 else 3
    rows = _picked(parts, [f"{r}{c}" for r in range(high) for c in range(4)])
    if not rows and len(parts) in (12, 16):
        rows = _picked(parts, [str(n) for n in range(4 * high)])
    if rows:
        turn = [rows[4 * r + c] for r in range(3) for c in range(3)]
        return Columns([rows[3], rows[7], rows[11]], turn, "matrix", last=rows[12:15])
    seven = _picked(parts, "0123456")
    return Columns(seven[:3], seven[3:], "quaternion", False) if seven and len(parts) == 7 else None


def _picked(parts: dict[str, int], order: Sequence[str]) -> list[int]:
    """The columns of all components in this order; empty where one is missing."""
    return [parts[part] for part in order] if all(part in parts for part in order) else []

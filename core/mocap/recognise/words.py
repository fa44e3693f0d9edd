"""What a bone's name says: its side and which parts of a body it may mean, in whatever dress.

A name is cut at separators, digits and changes of case, and glued words are cut by the vocabulary. Words that most
names of a skeleton share (a character's or a program's name) say nothing.
"""

from __future__ import annotations

import re
import unicodedata
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache

from .vocabulary import LEFT, MEANINGS, MECHANISM, NEGATIVE, NOISE, RIGHT

LONGEST_NAME = 120
"""Characters of a name that are looked at."""
_CUT = re.compile(r"[^\W\d_]+|\d+")
_CAMEL = re.compile(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])")
_UNKNOWN = 0.15
"""What each word that means nothing takes from a score."""
_SHARED = 0.6
"""A word that so many of the names have says nothing."""
_PAIRED = 4
"""So many pairs of names that differ by two words alone make these words sides."""
_RIGHT_LETTERS = frozenset("dr")
"""Right in Romance languages, as in "Brazo.D"."""
_WORDS = frozenset(MEANINGS) | LEFT | RIGHT | NOISE | NEGATIVE
_LONGEST_WORD = max(map(len, _WORDS))


@dataclass(frozen=True, slots=True)
class NameSays:
    """What one name says."""

    side: str = ""
    """ "L", "R" or "" for none."""
    parts: dict[str, float] = field(default_factory=dict[str, float])
    """Part -> score, 0 to 1; "spine" for any joint of the spine."""
    mechanism: bool = False
    """Whether it calls itself a bone that only serves others."""
    dim: bool = False
    """Whether it names a twist, a finger, a helper or the like."""


def read_names(names: Sequence[str]) -> list[NameSays]:
    """What each of a skeleton's names says, `(J,)`; "" says nothing."""
    cut = [pieces(name) for name in names]
    named = sum(bool(words) for words in cut)
    counts = Counter(word for words in cut for word in set(words))
    shared = frozenset(
        word
        for word, count in counts.items()
        if named > 4 and count > _SHARED * named and word not in LEFT and word not in RIGHT
    )
    pair = _side_pair(cut)
    return [_meaning(words, shared, pair) for words in cut]


@lru_cache(maxsize=20_000)
def pieces(name: str) -> tuple[str, ...]:
    """The words of a name, lower case, without accents; namespaces before a colon are dropped."""
    text = unicodedata.normalize("NFKC", re.split(r"[:|]", name)[-1][:LONGEST_NAME])
    out: list[str] = []
    for run in _CUT.findall(text):
        for word in _CAMEL.split(run) if run.isascii() else [run]:
            plain = _plain(word)
            out += [plain] if plain.isdigit() or plain in _WORDS else _unglued(plain)
    return tuple(out)


def _plain(word: str) -> str:
    lowered = word.lower()
    for letter, letters in (("ä", "ae"), ("ö", "oe"), ("ü", "ue"), ("ß", "ss")):
        lowered = lowered.replace(letter, letters)
    if lowered.isascii():
        return lowered
    bare = "".join(c for c in unicodedata.normalize("NFD", lowered) if unicodedata.category(c) != "Mn")
    # marks carry meaning in Japanese: only accents on Latin letters go
    return bare if bare.isascii() else lowered


def _unglued(word: str) -> list[str]:
    """A word as the fewest known ones; itself where it cannot be cut into such."""
    best: list[list[str] | None] = [list[str](), *(None for _ in word)]
    for end in range(1, len(word) + 1):
        for start in range(max(0, end - _LONGEST_WORD), end):
            before, piece = best[start], word[start:end]
            # single letters are sides, at the ends only, as in "lthigh" and "handr"
            outer = start == 0 or end == len(word)
            known = piece in _WORDS and (len(piece) > 1 or not piece.isascii() or (outer and piece in "lr"))
            if before is not None and known:
                found = best[end]
                if found is None or len(before) + 1 < len(found):
                    best[end] = [*before, piece]
    whole = best[len(word)]
    return (
        [word]
        if whole is None or not any(len(piece) > 1 or not piece.isascii() for piece in whole)
        else whole
    )


def _meaning(words: tuple[str, ...], shared: frozenset[str], pair: tuple[str, str] | None) -> NameSays:
    left, right = (LEFT, RIGHT) if pair is None else ({pair[0]}, {pair[1]})
    sides = {"L" if word in left else "R": word for word in words if word in left or word in right}
    side = next(iter(sides), "") if len(sides) < 2 else max(sides, key=lambda s: len(sides[s]))
    mechanism = bool(words) and words[0] in MECHANISM
    rest = [w for w in words if w not in left and w not in right and not w.isdigit() and w not in MECHANISM]
    telling = [word for word in rest if word not in shared] or rest
    dim = any(word in NEGATIVE for word in telling)
    scores = {} if dim else _scores(telling)
    # "hip" is the pelvis, and with a side the thigh's joint
    scores.pop("hips" if side else "thigh", None) if {"hips", "thigh"} <= scores.keys() else None
    return NameSays(side, scores, mechanism, dim)


def _scores(words: list[str]) -> dict[str, float]:
    """Part -> score of the words of a name without its side; of words that stand together the longest count."""
    spans = [
        (start, end)
        for start in range(len(words))
        for end in range(start + 1, min(start + 4, len(words)) + 1)
        if "".join(words[start:end]) in MEANINGS
    ]
    scores: dict[str, float] = {}
    for start, end in spans:
        if any(a <= start and end <= b and (a, b) != (start, end) for a, b in spans):
            continue
        others = words[:start] + words[end:]
        cost = _UNKNOWN * sum(word not in NOISE for word in others)
        for part, score in MEANINGS["".join(words[start:end])].items():
            scores[part] = max(scores.get(part, 0.0), score - cost)
    return {part: score for part, score in scores.items() if score > 0.1}


def _side_pair(cut: Sequence[tuple[str, ...]]) -> tuple[str, str] | None:
    """Two words that tell sides in a language of their own: names differ by them and by nothing else.

    Returns:
        (left, right) where no known words for sides pair names; None where they do, or none is found. Which of two
        unknown words is left is a guess for the shape to confirm.
    """
    slots: dict[tuple[tuple[str, ...], int, tuple[str, ...]], set[str]] = {}
    for words in cut:
        for at, word in enumerate(words):
            if not word.isdigit():
                slots.setdefault((words[:at], at, words[at + 1 :]), set()).add(word)
    counts = Counter(tuple(sorted(found)) for found in slots.values() if len(found) == 2)
    known = sum(n for (a, b), n in counts.items() if (a in LEFT and b in RIGHT) or (a in RIGHT and b in LEFT))
    if known >= _PAIRED or not counts:
        return None
    (a, b), count = min(counts.items(), key=lambda item: (-item[1], item[0]))
    if count < _PAIRED:
        return None
    return (b, a) if a in RIGHT or a in _RIGHT_LETTERS or b in LEFT else (a, b)

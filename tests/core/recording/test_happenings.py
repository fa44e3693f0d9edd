"""What trackers did, in words, and what of it falls into a part."""

from __future__ import annotations

import numpy as np
import pytest
from footwork.core.recording.happenings import clip, in_words
from footwork.core.recording.recording import Happening


def happened(kind: str, tracker: int, *spans: tuple[float, float], height: float = 0.0) -> Happening:
    starts, stops = np.array(spans).T
    return Happening(kind, tracker, starts, stops, height)


@pytest.mark.parametrize(
    ("item", "line"),
    [
        (happened("jump", 0, (3.25, 3.25)), "headset jumps once, first at 3.25 s: recentred? use one side of it only"),
        (
            happened("jump", 1, (3.25, 3.25), (7, 7), (9, 9)),
            "left controller jumps 3 times, first at 3.25 s: lost and found again, bridged",
        ),
        (happened("jump", 2, (0, 0)), "right controller jumps once, first at 0.00 s: lost and found again, bridged"),
        (
            happened("still", 2, (1, 4), (10, 12.5)),
            "right controller stands exactly still for 5.5 s: if it slept, set its valid column to 0",
        ),
        (happened("still", 1, (1, 6)), ""),
        (happened("lost", 1, (0, 100)), "left controller never tracked: its arm follows the matched motion"),
        (happened("lost", 1, (0, 101)), "left controller never tracked: its arm follows the matched motion"),
        (happened("lost", 0, (1, 2), (50, 51.5)), "headset not tracked for 2.5 of 100.0 s"),
        (happened("lost", 2, (0, 99)), "right controller not tracked for 99.0 of 100.0 s"),
        (happened("lost", 2, (0, 2)), ""),
        (happened("laid down", 0, (90.4, 100), height=0.724),
         "headset lies still at 0.72 m from 90 s on: leave that out"),
        (happened("danced", 0, (0, 100)), ""),
    ],
)  # fmt: skip
def test_each_kind_has_its_line_if_it_lasts(item: Happening, line: str) -> None:
    assert in_words([item], 100.0) == ((line,) if line else ())


def test_lines_stand_in_order_and_short_ones_are_left_out() -> None:
    items = [happened("jump", 2, (1, 1)), happened("lost", 1, (0, 0.1)), happened("jump", 1, (2, 2))]
    assert [line.split()[0] for line in in_words(items, 60.0)] == ["right", "left"]
    assert in_words([], 60.0) == ()


def test_a_part_has_what_happened_in_it_in_its_own_seconds() -> None:
    items = [
        happened("lost", 1, (0.0, 1.0), (3.0, 5.0), (6.0, 9.0), (12.0, 13.0)),
        happened("jump", 0, (3.9, 3.9), (4.0, 4.0), (8.0, 8.0), (8.1, 8.1)),
        happened("still", 2, (0.0, 3.9)),
        happened("laid down", 0, (2.0, 20.0), height=0.7),
    ]
    lost, jump, lying = clip(items, 4.0, 8.0)
    assert (lost.kind, lost.tracker) == ("lost", 1)
    np.testing.assert_allclose([lost.starts, lost.stops], [[0.0, 2.0], [1.0, 4.0]])
    np.testing.assert_allclose([jump.starts, jump.stops], [[0.0, 4.0], [0.0, 4.0]])
    np.testing.assert_allclose([lying.starts, lying.stops], [[0.0], [4.0]])
    assert lying.height == 0.7
    assert clip(items, 21.0, 30.0) == () == clip([], 0.0, 1.0)
    # what only touches a part belongs to it
    assert [item.kind for item in clip(items, 20.0, 30.0)] == ["laid down"]
    assert [item.kind for item in clip(items[:1], -5.0, 0.0)] == ["lost"]

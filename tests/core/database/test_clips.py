from __future__ import annotations

import math

import numpy as np
import pytest
from footwork.core.database.clips import Exclusion, check_exclusions, kept_ranges, parse_exclusion
from footwork.core.errors import InputError
from footwork.core.mocap.demo import demo_motion
from hypothesis import given
from hypothesis import strategies as st


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("walk:0-1.5", Exclusion("walk", 0.0, 1.5)),
        ("walk:2.25-10", Exclusion("walk", 2.25, 10.0)),
        ("walk:-3", Exclusion("walk", 0.0, 3.0)),
        ("walk:3-", Exclusion("walk", 3.0, math.inf)),
        (r"C:\takes\walk 1.bvh:0-2", Exclusion(r"C:\takes\walk 1.bvh", 0.0, 2.0)),
        ("a-1:b:.5-.75", Exclusion("a-1:b", 0.5, 0.75)),
    ],
)
def test_parse(text: str, expected: Exclusion) -> None:
    assert parse_exclusion(text) == expected
    assert parse_exclusion(str(expected)) == expected


@pytest.mark.parametrize(
    "text",
    ["", "walk", "walk:", "walk:1", ":1-2", "walk:2-1", "walk:1-1", "walk:a-b", "walk:1--2"],
)
def test_parse_faults(text: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_exclusion(text)
    assert "TAKE:FROM-TO" in str(caught.value)


def test_unknown_take_and_past_the_end(as_take) -> None:
    take = as_take(demo_motion("turn"), "turn")
    check_exclusions([take], [Exclusion(name, 1.0, 99.0) for name in ("turn", "turn.bvh", "takes/turn.bvh")])
    with pytest.raises(InputError, match="no such take; there are turn"):
        check_exclusions([take], [Exclusion("walk", 0.0, 1.0)])
    with pytest.raises(InputError, match=r"past its end at 14\.00 s"):
        check_exclusions([take], [Exclusion("turn", 14.0, 15.0)])


SPAN = st.tuples(st.integers(0, 60), st.integers(1, 40)).map(lambda s: (s[0] / 10, (s[0] + s[1]) / 10))


@given(st.lists(SPAN, max_size=5), st.integers(1, 80))
def test_kept_frames_are_those_in_no_exclusion(
    as_take, spans: list[tuple[float, float]], frames: int
) -> None:
    take = as_take(demo_motion("turn"), "turn")
    exclusions = [Exclusion("turn", *span) for span in spans] + [Exclusion("other", 0.0, math.inf)]
    kept = np.zeros(frames, dtype=bool)
    ranges = kept_ranges(take, exclusions, frames, 10.0)
    for start, stop in ranges:
        assert not kept[max(start - 1, 0) : stop].any()
        kept[start:stop] = True
    times = np.arange(frames) / 10.0 + 1e-9
    expected = ~np.any([(times >= a) & (times < b) for a, b in spans] or [np.zeros(frames, bool)], axis=0)
    np.testing.assert_array_equal(kept, expected)
    assert ranges == sorted(ranges)

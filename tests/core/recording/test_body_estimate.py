"""What is said of the body's direction."""

from __future__ import annotations

import numpy as np
from footwork.core.recording.body_estimate import BodyEstimate, estimate_doubts

FPS = 60.0


def told(degrees: np.ndarray) -> tuple[str, ...]:
    return estimate_doubts(BodyEstimate(np.zeros(len(degrees)), np.radians(degrees)), FPS)


def test_two_seconds_in_doubt_are_told_with_their_place() -> None:
    degrees = np.full(600, 10.0)
    degrees[150:270] = 31.0
    (line,) = told(degrees)
    assert "2.0 of 10.0 s" in line and "first at 2.5 s" in line


def test_short_doubts_sure_answers_and_no_notion_of_doubt_are_not_worth_a_word() -> None:
    degrees = np.full(600, 24.0)
    assert told(degrees) == ()
    degrees[150:200] = 90.0
    assert told(degrees) == ()
    assert estimate_doubts(BodyEstimate(np.zeros(600), None), FPS) == ()

"""Rows of the lists of takes and databases."""

from __future__ import annotations

from typing import Any

import bpy

from ..bridge.importing import read_scene_take
from ..core.mocap.answers import NO_ANSWERS, TakeAnswers
from ..core.mocap.take import Take
from ..core.mocap.takes import load_take
from ..properties.scene import footwork_of
from .base import FootworkOperator


class RowOperator(FootworkOperator):
    """Mixin for operators on the active row of a list."""

    what = ""
    """Name of a row: "take" for the list `takes`, whose active row is `take_index`."""

    @classmethod
    def refusal(cls, context: bpy.types.Context) -> str:
        """Without rows there is nothing to do."""
        return "" if cls.rows(context) else f"There is no {cls.what} in the list"

    @classmethod
    def rows(cls, context: bpy.types.Context) -> Any:
        """The list."""
        return getattr(footwork_of(context.scene), f"{cls.what}s")

    @classmethod
    def active(cls, context: bpy.types.Context) -> Any:
        """The active row, None where the list is empty."""
        return active(cls.rows(context), getattr(footwork_of(context.scene), f"{cls.what}_index"))

    def remove(self, context: bpy.types.Context) -> None:
        """Take the active row off the list, and go on to the next one."""
        rows, index = self.rows(context), self._index(context)
        rows.remove(index)
        self._show(context, min(index, max(len(rows) - 1, 0)))

    def move(self, context: bpy.types.Context, step: int) -> None:
        """Move the active row by `step` within the list."""
        rows, index = self.rows(context), self._index(context)
        target = min(max(index + step, 0), len(rows) - 1)
        rows.move(index, target)
        self._show(context, target)

    def _index(self, context: bpy.types.Context) -> int:
        index = getattr(footwork_of(context.scene), f"{self.what}_index")
        return min(max(index, 0), len(self.rows(context)) - 1)

    def _show(self, context: bpy.types.Context, index: int) -> None:
        setattr(footwork_of(context.scene), f"{self.what}_index", index)


def active(rows: Any, index: int) -> Any:
    """The active row of a list; None where the list is empty."""
    return rows[min(max(index, 0), len(rows) - 1)] if rows else None


def listed(text: str) -> list[str]:
    """The parts of a text that are separated by commas."""
    return [part.strip() for part in text.split(",") if part.strip()]


def answers_of(row: Any) -> TakeAnswers:
    """What was said by hand of a take's file."""
    return TakeAnswers(
        unit="" if row.unit == "AUTO" else row.unit,
        up="" if row.up == "AUTO" else row.up,
        rate=row.rate or None,
    )


def read_take(path: str, answers: TakeAnswers = NO_ANSWERS, fps: float | None = None) -> Take:
    """A take from a file of any kind; InputError where it is none."""
    return load_take(path, fps, answers, read_scene_take)


def told(source: Any) -> tuple[str, str]:
    """What a take or recording says of itself: found and doubts, a line each."""
    found = "\n".join(f"{name}\t{value}" for name, value in source.found.items())
    return found, "\n".join(source.doubts)

"""The base of every operator: why it is disabled, and what becomes of bad input."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Literal

import bpy

from ..core.errors import InputError, one_line
from ..properties.upgrade import upgrade_all

# A mixin has no Operator below it while it runs, but may use what comes with one
Operator = bpy.types.Operator if TYPE_CHECKING else object


class FootworkOperator(Operator):
    """Mixin for all operators: a subclass says in `refusal` when it is disabled, and does its job in `work`."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Enabled unless there is a reason against it, which the tooltip then shows."""
        reason = cls.refusal(context)
        if reason:
            cls.poll_message_set(reason)
        return not reason

    @classmethod
    def refusal(cls, context: bpy.types.Context) -> str:
        """Why the button is disabled, "" where it is not."""
        return ""

    def work(self, context: bpy.types.Context) -> None:
        """Do the job, and report what came of it.

        Raises:
            InputError: it cannot be done; nothing is changed then.
        """
        raise NotImplementedError

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Do the job at once, as buttons and scripts ask for."""
        return self.guarded(self._whole, context)

    def tell(self, kind: Literal["INFO", "WARNING", "ERROR"], text: str) -> None:
        """Report a line, whatever a file or a name put into it."""
        self.report({kind}, one_line(text))

    def guarded(self, part: Callable[..., set[str]], *arguments: Any) -> set[str]:
        """What a part of the operator answers; bad input becomes an error report and a cancel."""
        try:
            return part(*arguments)
        except InputError as error:
            for line in error.lines:
                self.tell("ERROR", line)
            return {"CANCELLED"}

    def _whole(self, context: bpy.types.Context) -> set[str]:
        # scenes may have come in ways that no handler hears of
        upgrade_all()
        self.work(context)
        return {"FINISHED"}

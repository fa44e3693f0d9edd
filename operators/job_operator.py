"""The base of every operator that takes its time: a core job, driven a slice per timer tick or straight through."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import bpy
from bpy.app.handlers import persistent

from ..bridge.lookup import Kept
from ..core.jobs import Job, run
from ..properties.upgrade import upgrade_all
from .base import FootworkOperator

SLICE_S = (0.025, 0.25)
"""Least and most time for the job in one timer tick: as long as Blender took since the last one, so that slow drawing
takes half of the time at most."""
REDRAW_S = 0.15


@dataclass(slots=True)
class Running:
    """What the panels show of the job in progress."""

    operator: str
    title: str
    fraction: float = 0.0
    message: str = ""
    cancelled: bool = False
    give_up: Callable[[], None] = lambda: None
    """Closes the job and gives back what it has of Blender."""


running: Running | None = None
"""The job in progress, if any; there is never more than one."""


def end() -> None:
    """End the job in progress, whatever becomes of its operator; nothing where none runs."""
    global running
    if running is None:
        return
    ended, running = running, None
    ended.give_up()


def _give_up(
    job: Job[Any], manager: bpy.types.WindowManager, workspace: bpy.types.WorkSpace, timer: bpy.types.Timer
) -> None:
    job.close()
    manager.event_timer_remove(timer)
    manager.progress_end()
    workspace.status_text_set(None)
    _redraw(manager)


@persistent
def end_before_load(*_: object) -> None:
    """For Blender's handlers: what a job was started for goes with the file."""
    end()


class JobOperator(FootworkOperator):
    """Mixin for operators over a core job.

    `start` reads everything from Blender into plain data and returns the job; `finish` writes its result. Between them
    the user may undo, or delete what the job works for: a subclass names that in `kept`, and looks it up in `finish`.
    Nothing is written before `finish`, so ESC leaves the file as it was.
    """

    title = "Working"
    works_elsewhere = False
    """The job only watches another process: one look per timer tick leaves Blender free."""
    kept: tuple[Kept, ...] = ()
    """Set by `start`: without these the job has nothing to work for."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Enabled unless a job runs, or there is another reason against it."""
        if running is not None:
            cls.poll_message_set(f"{running.title} is still running")
            return False
        return super().poll(context)

    def start(self, context: bpy.types.Context) -> Job[Any]:
        """The job, made of plain data."""
        raise NotImplementedError

    def finish(self, context: bpy.types.Context, result: Any) -> None:
        """Write the job's result to Blender and report it."""
        raise NotImplementedError

    def after_cancel(self) -> str:
        """What a user who cancelled should know."""
        return "nothing was changed"

    def work(self, context: bpy.types.Context) -> None:
        """Run straight through, as scripts and background mode do."""
        self.finish(context, run(self.start(context), _printer(self.title) if bpy.app.background else None))

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event | None) -> set[str]:
        """Run in the background of the user interface."""
        # Blender never runs modal handlers without a window
        if bpy.app.background or context.window is None:
            return self.execute(context)
        return self.guarded(self._begin, context)

    def _begin(self, context: bpy.types.Context) -> set[str]:
        global running
        upgrade_all()
        self._job = self.start(context)
        manager = context.window_manager
        timer = manager.event_timer_add(0.01, window=context.window)
        give_up = partial(_give_up, self._job, manager, context.workspace, timer)
        running = self._mine = Running(type(self).bl_idname, self.title, give_up=give_up)
        self._drawn = self._left = time.perf_counter()
        manager.progress_begin(0, 100)
        context.window_manager.modal_handler_add(self)
        _show(context)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """One slice of the job."""
        if (
            running is not self._mine
            or self._mine.cancelled
            or (event.type == "ESC" and event.value == "PRESS")
        ):
            self.cancel(context)
            self.tell("INFO", f"{self.title}: cancelled, {self.after_cancel()}")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        return self.guarded(self._slice, context)

    def _slice(self, context: bpy.types.Context) -> set[str]:
        try:
            result = self._advance(context)
            if result is None:
                return {"RUNNING_MODAL"}
            end()
            self.finish(context, result[0])
        except BaseException:
            end()
            raise
        return {"FINISHED"}

    def cancel(self, context: bpy.types.Context) -> None:
        """Give the job up; Blender calls this too when another file is loaded."""
        if running is self._mine:
            end()

    def _advance(self, context: bpy.types.Context) -> tuple[Any] | None:
        for kept in self.kept:
            kept.find()
        start = time.perf_counter()
        stop = start + min(max(start - self._left, SLICE_S[0]), SLICE_S[1])
        while time.perf_counter() < stop:
            try:
                self._mine.fraction, self._mine.message = next(self._job)
            except StopIteration as done:
                return (done.value,)
            if self.works_elsewhere:
                break
        self._left = time.perf_counter()
        if self._left - self._drawn > REDRAW_S:
            self._drawn = self._left
            _show(context)
        return None


class FOOTWORK_OT_cancel_job(FootworkOperator, bpy.types.Operator):
    """Stop the running job; nothing is changed"""

    bl_idname = "footwork.cancel_job"
    bl_label = "Cancel"
    bl_options = {"INTERNAL"}

    @classmethod
    def refusal(cls, context: bpy.types.Context) -> str:
        return "" if running is not None else "Nothing is running"

    def work(self, context: bpy.types.Context) -> None:
        if running is not None:
            running.cancelled = True


def _show(context: bpy.types.Context) -> None:
    percent = round(100 * running.fraction)
    context.window_manager.progress_update(percent)
    context.workspace.status_text_set(f"{running.title}: {percent} %  {running.message}  (ESC cancels)")
    _redraw(context.window_manager)


def _redraw(manager: bpy.types.WindowManager) -> None:
    for window in manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                for region in area.regions:
                    if region.type == "UI":
                        region.tag_redraw()


def _printer(title: str):
    last = ["", -1]

    def tell(fraction: float, message: str) -> None:
        tenth = int(fraction * 10)
        if [message, tenth] != last:
            last[:] = [message, tenth]
            print(f"Footwork: {title}: {fraction:4.0%} {message}", flush=True)

    return tell

"""The modal side of long jobs, with events played to it: background Blender never calls it."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from footwork.core.errors import InputError
from footwork.operators import job_operator
from footwork.operators.job_operator import JobOperator


class Manager:
    """Counts what a job must give back."""

    def __init__(self) -> None:
        self.timers, self.handlers, self.progress, self.windows = 0, 0, False, []

    def event_timer_add(self, step: float, *, window: object) -> object:
        self.timers += 1
        return object()

    def event_timer_remove(self, timer: object) -> None:
        self.timers -= 1

    def modal_handler_add(self, operator: object) -> None:
        self.handlers += 1

    def progress_begin(self, low: int, high: int) -> None:
        self.progress = True

    def progress_update(self, value: int) -> None:
        assert 0 <= value <= 100

    def progress_end(self) -> None:
        self.progress = False


class Counting(JobOperator):
    """Counts to `goal`, then keeps the result."""

    bl_idname, title, goal, fault = "footwork.counting", "Counting", 5, None

    def __init__(self) -> None:
        self.reports, self.result, self.closed = [], None, False

    def report(self, kind: set[str], text: str) -> None:
        self.reports.append((min(kind), text))

    def start(self, context):
        if self.fault == "start":
            raise InputError("bad start")
        return self.count()

    def count(self):
        try:
            for number in range(self.goal):
                if self.fault == number:
                    raise InputError("bad middle")
                yield number / self.goal, f"at {number}"
        finally:
            self.closed = True
        return self.goal

    def finish(self, context, result) -> None:
        if self.fault == "bug":
            raise ZeroDivisionError
        self.result = result


@pytest.fixture
def window(monkeypatch):
    """A context with a window, in a Blender that is not in the background."""
    monkeypatch.setattr(job_operator, "bpy", SimpleNamespace(app=SimpleNamespace(background=False)))
    monkeypatch.setattr(job_operator, "running", None)
    # one step a tick
    monkeypatch.setattr(job_operator, "SLICE_S", (0.0, 0.0))
    manager, status = Manager(), []
    workspace = SimpleNamespace(status_text_set=status.append)
    return SimpleNamespace(window=object(), window_manager=manager, workspace=workspace, status=status)


TIMER = SimpleNamespace(type="TIMER", value="NOTHING")
ESCAPE = SimpleNamespace(type="ESC", value="PRESS")
MOUSE = SimpleNamespace(type="MOUSEMOVE", value="NOTHING")


def drive(operator: Counting, context, ticks: int = 10_000) -> set[str]:
    """Tick until the job ends."""
    for _ in range(ticks):
        answer = operator.modal(context, TIMER)
        if answer != {"RUNNING_MODAL"}:
            return answer
    raise AssertionError("it does not end")


def assert_left_clean(context) -> None:
    assert context.window_manager.timers == 0 and not context.window_manager.progress
    assert context.status[-1:] == [None] and job_operator.running is None


def slices(monkeypatch, seconds: float) -> None:
    monkeypatch.setattr(job_operator, "SLICE_S", (seconds, seconds))


def test_a_job_runs_in_slices_and_finishes_once(window, monkeypatch) -> None:
    slices(monkeypatch, 1e-3)
    operator = Counting()
    operator.goal = 20_000
    assert operator.invoke(window, None) == {"RUNNING_MODAL"}
    assert job_operator.running.operator == "footwork.counting" and "Counting" in window.status[0]
    assert operator.modal(window, MOUSE) == {"PASS_THROUGH"} and operator.result is None
    assert operator.modal(window, TIMER) == {"RUNNING_MODAL"} and 0.0 < job_operator.running.fraction < 1.0
    assert drive(operator, window) == {"FINISHED"} and operator.result == 20_000
    assert_left_clean(window)


@pytest.mark.parametrize("how", ["escape", "button", "file"])
def test_cancelling_closes_the_job_and_writes_nothing(window, how: str) -> None:
    operator = Counting()
    operator.invoke(window, None)
    next(operator._job)
    if how == "escape":
        assert operator.modal(window, ESCAPE) == {"CANCELLED"}
    elif how == "button":
        job_operator.running.cancelled = True
        assert operator.modal(window, MOUSE) == {"CANCELLED"}
    else:
        operator.cancel(window)
    told = [] if how == "file" else [("INFO", "Counting: cancelled, nothing was changed")]
    assert operator.reports == told
    assert operator.closed and operator.result is None
    assert_left_clean(window)


@pytest.mark.parametrize("fault", ["start", 0, 3])
def test_bad_input_is_reported_and_everything_given_back(window, monkeypatch, fault) -> None:
    slices(monkeypatch, 1.0)
    operator = Counting()
    operator.fault = fault
    answer = operator.invoke(window, None)
    if answer == {"RUNNING_MODAL"}:
        answer = drive(operator, window)
        assert_left_clean(window)
    assert answer == {"CANCELLED"} and operator.result is None
    assert [kind for kind, _ in operator.reports] == ["ERROR"]


def test_a_bug_gives_everything_back_and_is_not_hidden(window, monkeypatch) -> None:
    slices(monkeypatch, 1.0)
    operator = Counting()
    operator.fault = "bug"
    operator.invoke(window, None)
    with pytest.raises(ZeroDivisionError):
        drive(operator, window)
    assert_left_clean(window)


def test_slow_drawing_gets_half_of_the_time(window, monkeypatch) -> None:
    clock = [0.0]
    monkeypatch.setattr(job_operator, "SLICE_S", (0.025, 0.25))
    monkeypatch.setattr(job_operator.time, "perf_counter", lambda: clock[0])
    operator = Counting()

    def steps():
        while True:
            clock[0] += 0.01
            yield 0.0, ""

    monkeypatch.setattr(operator, "count", steps)
    operator.invoke(window, None)
    clock[0] += 0.1
    before = clock[0]
    operator.modal(window, TIMER)
    assert clock[0] - before == pytest.approx(0.1, abs=0.011)
    clock[0] += 5.0
    before = clock[0]
    operator.modal(window, TIMER)
    assert clock[0] - before == pytest.approx(0.25, abs=0.011)
    operator.cancel(window)


def test_a_job_that_watches_another_process_is_looked_at_once_a_tick(window, monkeypatch) -> None:
    slices(monkeypatch, 1.0)
    operator = Counting()
    operator.works_elsewhere = True
    operator.invoke(window, None)
    for number in range(operator.goal):
        assert operator.modal(window, TIMER) == {"RUNNING_MODAL"}
        assert job_operator.running.fraction == number / operator.goal
    assert operator.modal(window, TIMER) == {"FINISHED"} and operator.result == operator.goal

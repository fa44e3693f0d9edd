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


def test_nothing_runs_after_the_extension_is_disabled_or_another_file_loaded(window, monkeypatch) -> None:
    for end in (job_operator.end, lambda: job_operator.end_before_load("other.blend", None)):
        operator = Counting()
        operator.invoke(window, None)
        next(operator._job)
        end()
        assert operator.closed and operator.result is None
        assert_left_clean(window)
        # Blender may still tell the operator, which must not stop the next job
        other = Counting()
        other.invoke(window, None)
        operator.cancel(window)
        assert operator.modal(window, TIMER) == {"CANCELLED"} and not other.closed
        slices(monkeypatch, 1.0)
        assert drive(other, window) == {"FINISHED"} and other.result == 5
        slices(monkeypatch, 0.0)


def test_blender_ends_jobs_on_unregister_and_before_a_load(monkeypatch) -> None:
    import bpy
    from footwork import operators

    assert job_operator.end_before_load in bpy.app.handlers.load_pre
    ended = []
    monkeypatch.setattr(job_operator, "end", lambda: ended.append(True))
    operators.unregister()
    assert ended == [True] and job_operator.end_before_load not in bpy.app.handlers.load_pre
    operators.register()
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert ended == [True, True]


@pytest.mark.parametrize("kind", ["object", "scene"])
def test_a_job_ends_when_what_it_works_for_is_deleted(window, kind: str) -> None:
    import bpy
    from footwork.bridge.lookup import keep_object, keep_scene

    scene = bpy.data.scenes.new("Stage")
    obj = bpy.data.objects.new("Hero", None)
    operator = Counting()
    operator.kept = (keep_scene(scene), keep_object(obj))
    operator.invoke(window, None)
    next(operator._job)
    scene.name, obj.name = "Other stage", "Other hero"
    assert operator.modal(window, TIMER) == {"RUNNING_MODAL"}
    if kind == "object":
        bpy.data.objects.remove(obj)
        bpy.data.objects.new("Hero", None)  # of the same name, but not the same
    else:
        bpy.data.scenes.remove(scene)
    assert drive(operator, window) == {"CANCELLED"} and operator.closed and operator.result is None
    name = "Hero" if kind == "object" else "Stage"
    assert operator.reports == [
        ("ERROR", f"{name}: the {kind} is gone since the job was started; start again")
    ]
    assert_left_clean(window)


def test_file_operators_without_a_file_say_so() -> None:
    import bpy

    for name in ("add_takes", "import_take", "load_recording", "add_database"):
        with pytest.raises(RuntimeError) as caught:
            getattr(bpy.ops.footwork, name)()
        assert str(caught.value).strip() == "Error: No file chosen", name

"""Worker processes seen from the batch: each has a thread that hands it tasks, waits for answers, and replaces it."""

from __future__ import annotations

import contextlib
import json
import os
import queue
import subprocess
import sys
import tempfile
import threading
from collections.abc import Generator, Iterator, Sequence
from typing import Any

from ..core.batch.summary import failed_row
from ..core.errors import InputError
from .work import READY, WORKER

Task = dict[str, Any]
Row = dict[str, Any]

_PATIENCE_S = 10.0
"""How long a worker may take to end by itself."""
_ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
"""Sums must not depend on how many workers there are, and workers are there for each core already."""


def worker_command() -> list[str]:
    """What starts a worker: the same Blender, or the same Python."""
    blender = getattr(getattr(sys.modules.get("bpy"), "app", None), "binary_path", "")
    if blender:
        return [blender, "--background", "--command", "footwork", WORKER]
    return [sys.executable, "-m", (__package__ or "").rpartition(".")[0], WORKER]


class Hand:
    """One worker process at a time; a new one takes the place of one that ended."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[str] | None = None
        self._said = tempfile.TemporaryFile("a+b")  # noqa: SIM115 - it lives as long as the hand
        self._closed = False
        self._lock = threading.Lock()

    def do(self, task: Task, timeout: float | None) -> Row:
        """The row of a task, which has failed where its worker ended or took too long.

        Raises:
            InputError: no worker can be started.
        """
        process = self._ready()
        late = threading.Event()
        timer = threading.Timer(timeout or 0.0, self._too_late, [process, late])
        timer.daemon = True
        try:
            assert process.stdin is not None and process.stdout is not None
            os.ftruncate(self._said.fileno(), 0)
            with contextlib.suppress(OSError):
                print(json.dumps(task), file=process.stdin, flush=True)
            if timeout is not None:
                timer.start()
            answer = process.stdout.readline()
        finally:
            timer.cancel()
        if answer.endswith("\n"):
            return json.loads(answer)
        end_process(process)
        recording, name = task["options"]["recording"], task["name"]
        why = f"took longer than {timeout:g} s; give it more time with --timeout, or cut it"
        row = failed_row(recording, name, [why if late.is_set() else self._last_words(process)])
        return {**row, "bytes": task["bytes"]}

    def close(self) -> None:
        """End the worker, cleanly if it can."""
        with self._lock:
            self._closed = True
            process = self._process
        if process is not None:
            end_process(process)

    def _ready(self) -> subprocess.Popen[str]:
        with self._lock:
            if self._closed:
                raise InputError("the worker is closed")
            if self._process is not None and self._process.poll() is None:
                return self._process
            self._process = process = start_process(self._said.fileno())
        assert process.stdout is not None
        for line in process.stdout:
            if line.strip() == READY:
                return process
        end_process(process)
        raise InputError(f"no worker can be started: {self._last_words(process)}")

    def _too_late(self, process: subprocess.Popen[str], late: threading.Event) -> None:
        late.set()
        process.terminate()
        try:
            process.wait(_PATIENCE_S)
        except subprocess.TimeoutExpired:
            process.kill()

    def _last_words(self, process: subprocess.Popen[str]) -> str:
        code = process.wait()
        how = f"signal {-code}" if code < 0 else f"code {code}"
        if code == -9:
            how += ", as the system does where memory runs out"
        self._said.seek(0)
        lines = self._said.read()[-2000:].decode(errors="replace").split("\n")
        said = next((line.strip() for line in reversed(lines) if line.strip()), "")
        return f"its worker ended ({how}){f': {said}' if said else ''}"


def start_process(errors: int) -> subprocess.Popen[str]:
    """A worker that keys pressed here do not reach: the batch ends it."""
    own: dict[str, Any] = {"creationflags": 0x200} if os.name == "nt" else {"start_new_session": True}
    threads = {name: os.environ.get(name, "1") for name in _ONE_THREAD}
    return subprocess.Popen(
        worker_command(),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=errors,
        text=True,
        encoding="utf-8",
        env={**os.environ, **threads},
        **own,
    )


def end_process(process: subprocess.Popen[str]) -> None:
    """End a worker: by its input's end, then by force."""
    with contextlib.suppress(OSError):
        assert process.stdin is not None
        process.stdin.close()
    for end in (process.terminate, process.kill):
        try:
            process.wait(_PATIENCE_S)
            return
        except subprocess.TimeoutExpired:
            end()
    process.wait()


def on_this_machine(tasks: Sequence[Task], workers: int, timeout: float | None) -> Generator[Row]:
    """Rows of tasks as they are done; closing it ends all workers.

    Raises:
        InputError: no worker can be started.
    """
    waiting = iter(tasks)
    lock, closed = threading.Lock(), threading.Event()
    rows: queue.SimpleQueue[Row | BaseException | None] = queue.SimpleQueue()
    hands = [Hand() for _ in range(max(1, min(workers, len(tasks))))]
    threads = [
        threading.Thread(target=_keep_busy, args=(hand, waiting, lock, closed, rows, timeout), daemon=True)
        for hand in hands
    ]
    try:
        for thread in threads:
            thread.start()
        busy = len(threads)
        while busy:
            row = rows.get()
            if row is None:
                busy -= 1
            elif isinstance(row, BaseException):
                raise row
            else:
                yield row
    finally:
        closed.set()
        end_all(hands)


def end_all(hands: Sequence[Hand]) -> None:
    """End the workers of all hands at once: each may take its time."""
    closing = [threading.Thread(target=hand.close, daemon=True) for hand in hands]
    for thread in closing:
        thread.start()
    for thread in closing:
        thread.join()


def _keep_busy(
    hand: Hand,
    waiting: Iterator[Task],
    lock: threading.Lock,
    closed: threading.Event,
    rows: queue.SimpleQueue[Row | BaseException | None],
    timeout: float | None,
) -> None:
    try:
        while not closed.is_set():
            with lock:
                task = next(waiting, None)
            if task is None:
                break
            rows.put(hand.do(task, timeout))
        rows.put(None)
    except BaseException as error:
        rows.put(error)

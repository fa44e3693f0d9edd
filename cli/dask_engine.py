"""The machines of a Dask cluster as hands of a batch.

A Dask worker does no bake itself: each of its threads has a worker process of its own (`hands.Hand`), as on one
machine. So a crash or `--timeout` costs one recording, and Dask replaces only workers that are lost with all they had.
Their tasks are done again elsewhere; since a task writes the same files through a transaction, nothing is lost or
doubled.
"""

from __future__ import annotations

import contextlib
import importlib
import os
import threading
import uuid
from collections.abc import Generator, Iterator, Sequence
from pathlib import Path
from typing import Any

from ..core.batch.summary import failed_row
from ..core.errors import InputError
from .common import needing, tell
from .hands import Hand, Row, Task, end_all

LOCAL = "local"
"""The scheduler that starts its own cluster on this machine."""
NO_DASK = "--scheduler needs Dask: pip install distributed, or leave it out to use this machine alone"
_CONNECT_S = 30.0
_WAITING_FOR_EACH = 4
_FEWEST_WAITING = 64
"""Tasks at the scheduler at once: enough for clusters that grow, few for its memory."""


def _dask() -> Any:
    return importlib.import_module("distributed")


@contextlib.contextmanager
def cluster(address: str, workers: int) -> Generator[Any]:
    """A client of a Dask cluster.

    Args:
        address: of a scheduler ("tcp://host:8786"), its scheduler file, or `LOCAL`.
        workers: processes of a local cluster.

    Raises:
        InputError: Dask is not there, or nobody answers.
    """
    with needing("distributed", NO_DASK):
        distributed = _dask()
    with contextlib.ExitStack() as stack:
        if address == LOCAL:
            own = distributed.LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                memory_limit=None,
                dashboard_address=None,
                silence_logs=50,
            )
            given: dict[str, Any] = {"address": stack.enter_context(own)}
        elif Path(address).is_file():
            given = {"scheduler_file": address}
        else:
            given = {"address": address}
        try:
            client = stack.enter_context(
                distributed.Client(**given, timeout=_CONNECT_S, set_as_default=False)
            )
        except (OSError, ValueError) as error:
            raise InputError(
                f"--scheduler {address}: no Dask scheduler answers ({error}); start one, or check the address"
            ) from None
        yield client


def threads_of(client: Any) -> int:
    """Recordings that a cluster can do at once now, at least 1."""
    return max(1, sum(client.nthreads().values()))


def on_cluster(client: Any, tasks: Sequence[Task], timeout: float | None) -> Generator[Row]:
    """Rows of tasks as they are done; closing it ends all worker processes.

    Raises:
        InputError: the cluster's workers cannot do tasks.
    """
    batch = uuid.uuid4().hex
    waiting = iter(tasks)
    done = _dask().as_completed(loop=client.loop)
    doing: dict[str, Task] = {}
    if not client.nthreads():
        tell("footwork batch: waiting for workers of the cluster")
    try:
        _fill(client, done, doing, waiting, (batch, timeout))
        for future in done:
            yield _row_of(future, doing.pop(future.key))
            future.release()
            _fill(client, done, doing, waiting, (batch, timeout))
    finally:
        done.clear()
        with contextlib.suppress(Exception):  # workers that are gone have no processes either
            client.run(end_hands, batch)


def _fill(
    client: Any, done: Any, doing: dict[str, Task], waiting: Iterator[Task], how: tuple[str, float | None]
) -> None:
    batch, timeout = how
    room = max(_FEWEST_WAITING, _WAITING_FOR_EACH * threads_of(client))
    while len(doing) < room and (task := next(waiting, None)) is not None:
        key = f"footwork-{batch}-{task['name']}"
        doing[key] = task
        done.add(client.submit(do_here, task, batch, timeout, key=key, pure=False))


def _row_of(future: Any, task: Task) -> Row:
    error = future.exception()
    if error is None:
        return future.result()
    if not isinstance(error, _dask().KilledWorker):
        raise InputError(
            f"a worker of the cluster cannot do tasks: {error or repr(error)}; install the same Footwork there"
        )
    why = "every worker of the cluster that had it was lost; look at their logs"
    return {**failed_row(task["options"]["recording"], task["name"], [why]), "bytes": task["bytes"]}


_free: dict[str, list[Hand]] = {}
"""Hands of this Dask worker that wait for a task, by batch."""
_all: dict[str, list[Hand]] = {}
_lock = threading.Lock()


def do_here(task: Task, batch: str, timeout: float | None) -> Row:
    """One task, in a Dask worker: by a worker process that waits there, or by a new one."""
    if not os.path.isdir(task["folder"]):  # noqa: PTH112 - a path of another machine
        why = f"{task['folder']}: a worker has no such folder; all need the same files by the same names"
        return {**failed_row(task["options"]["recording"], task["name"], [why]), "bytes": task["bytes"]}
    with _lock:
        free = _free.setdefault(batch, [])
        if not free:
            free.append(Hand())
            _all.setdefault(batch, []).append(free[-1])
        hand = free.pop()
    row = hand.do(task, timeout)
    with _lock:
        _free[batch].append(hand)
    return row


def end_hands(batch: str) -> None:
    """End the worker processes of a batch in this Dask worker, at once."""
    with _lock:
        hands = _all.pop(batch, [])
    end_all(hands)

"""A worker: a process of its own that bakes one recording after the other, and keeps databases between them.

It is given a task on each line of its standard input, as JSON, and answers each with a line. Whatever Blender prints
goes to standard error. It ends when its input does: at once, also in the middle of a bake, which then leaves nothing.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import queue
import sys
import threading
import time
import traceback
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from .streams import ended_by_sigterm

WORKER = "batch-worker"
"""The one word of its command line."""
READY = "footwork-batch-worker"
"""Its first answer; Blender may have printed lines before."""

Row = dict[str, Any]


def serve() -> int:
    """Do tasks until standard input ends."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    try:
        with ended_by_sigterm():
            from .baking import Library

            library = Library()
            tasks = _tasks()
            print(READY, file=answers, flush=True)
            for task in tasks:
                print(json.dumps(do(task, library)), file=answers, flush=True)
    except (KeyboardInterrupt, BrokenPipeError):
        pass  # nobody is there any more
    return 0


def _tasks() -> Iterator[dict[str, Any]]:
    lines: queue.SimpleQueue[str] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(lines,), daemon=True).start()
    while line := lines.get():
        yield json.loads(line)


def _listen(lines: queue.SimpleQueue[str]) -> None:
    """Pass lines on; their end stops what the main thread does."""
    import _thread

    for line in sys.stdin:
        lines.put(line)
    lines.put("")
    _thread.interrupt_main()


def do(task: dict[str, Any], library: Any) -> Row:
    """One recording, and its row of the summary; doing it again gives the same files.

    Raises:
        KeyboardInterrupt: the worker is to end; nothing is written.
    """
    from ..core.batch.summary import failed_row
    from ..core.errors import InputError

    start = time.perf_counter()
    recording, name = task["options"]["recording"], task["name"]
    try:
        row = _bake(task, library)
    except InputError as error:
        row = failed_row(recording, name, error.lines)
    except MemoryError:
        row = failed_row(recording, name, ["not enough memory; use fewer workers, or cut the recording"])
    except Exception as error:
        trace = traceback.format_exc()
        # Blender's operators turn a cancel into an error of theirs
        if "KeyboardInterrupt" in trace:
            raise KeyboardInterrupt from error
        row = failed_row(recording, name, [f"a bug in Footwork ({error!r}); please report it"], trace)
    return {**row, "spent_s": time.perf_counter() - start, "peak_mb": _peak_mb(), "bytes": task["bytes"]}


def _bake(task: dict[str, Any], library: Any) -> Row:
    from ..core import VERSION, jobs
    from ..core.batch.summary import DONE, row_of
    from ..core.errors import InputError
    from ..core.transaction import Transaction
    from .baking import make
    from .common import report_text, with_bone_maps
    from .repeat import differences, read_earlier

    if task["version"] != VERSION:
        raise InputError(
            f"this worker has Footwork {VERSION}, the batch is of {task['version']}; install the same"
        )
    os.chdir(task["folder"])
    options = argparse.Namespace(**task["options"])
    with with_bone_maps(options), Transaction(task["inputs"]) as outputs:
        outputs.folder(Path(task["report"]).parent)
        for path in (*task["targets"], task["report"]):
            outputs.check(path)
        mark = made_from(options, task["targets"], library)
        kept = _kept(task, options, mark) if task["resume"] else None
        if kept is not None:
            return kept
        report = make(options, task["targets"], outputs, library, jobs.run)
        if options.settings:
            report["warnings"] += differences(read_earlier(options.settings), report)
        sizes = outputs.sizes()
        report["batch"] = {
            "made_from": mark,
            "files": {Path(path).name: sizes[path] for path in task["targets"]},
        }
        text = report_text(report).encode()
        outputs.write(task["report"], lambda file: file.write(text))
    row = row_of(report, task["name"], DONE, report.get("failed", ()))
    return {**row, "bytes_out": sum(sizes.values()) + len(text)}


def made_from(options: argparse.Namespace, targets: list[str], library: Any) -> str:
    """What the outputs of a bake depend on, as a fingerprint: inputs by content, settings, kinds of outputs.

    Names of inputs do not count, but which object of a file is meant does.
    """
    from .baking import bake_options_of, file_of, more_inputs

    inputs = [("recording", options.recording), *(("database", path) for path in options.database)]
    inputs += [*more_inputs(options), *(("bone_map", path) for path in options.bone_map)]
    said: dict[str, Any] = bake_options_of(options)
    for name in ("database", "bone_map", "predictor", "settings", "fail_if"):
        del said[name]
    for name in ("rig", "ground"):
        said[name] = (said[name] or "").removeprefix(file_of(said[name]) or "")
    whole = {
        "options": said,
        "headset": options.predictor == "headset",
        "inputs": [[kind, library.sha256(path)] for kind, path in inputs],
        "kinds": sorted(Path(path).suffix for path in targets),
    }
    return hashlib.sha256(json.dumps(whole, sort_keys=True).encode()).hexdigest()


def _kept(task: dict[str, Any], options: argparse.Namespace, mark: str) -> Row | None:
    """The row of what an earlier run made from the same, whole; None where it has to be made again."""
    from ..core.batch.summary import KEPT, row_of
    from ..core.bounds import REPORT_BYTES
    from ..core.errors import FaultError, InputError
    from ..core.evaluation.limits import failures, parse_limit
    from ..core.json_text import read_json

    path = Path(task["report"])
    try:
        report = read_json(path, "report", REPORT_BYTES)
        sizes = {target: Path(target).stat().st_size for target in task["targets"]}
        made = report["batch"]
        if made["made_from"] != mark or any(
            made["files"][Path(key).name] != size for key, size in sizes.items()
        ):
            return None
        failed = failures(report["metrics"], [parse_limit(text) for text in options.fail_if])
        row = row_of(report, task["name"], KEPT, failed)
        return {**row, "bytes_out": sum(sizes.values()) + path.stat().st_size}
    except (InputError, FaultError, OSError, LookupError, TypeError, AttributeError):
        return None


def _peak_mb() -> float | None:
    """The most memory that this process has had, MB; None where the system does not tell."""
    try:
        import resource
    except ImportError:
        return None
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6

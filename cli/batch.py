"""`batch`: many recordings, on all cores of a machine or on a cluster."""

from __future__ import annotations

import argparse
import contextlib
import os
import time
from collections.abc import Generator
from pathlib import Path
from typing import Any

from ..core.errors import InputError
from ..core.transaction import Transaction
from .bake_options import add_bake_options, only_said
from .common import report_text, say, tell
from .options import InputPath, OutputFolder
from .verb import Report, Verb

SUMMARY = ("summary.html", "summary.json", "summary.csv")
_TOLD_EVERY_S = 2.0
_EPILOG = """
JOBS is a folder (all recordings in it and below), a pattern such as "day?/*.bsor", or a .csv, .toml or .json table with
one row for each recording: the columns recording, output (the name of its outputs) and any option of bake by its name,
which then counts before the same option here. docs/batch.md shows tables.

  footwork batch recordings --database walk.npz -o baked
  footwork batch jobs.csv --database walk.npz --write npz --workers 8 --timeout 600 -o baked --resume

Exit codes: 0 all done, 4 some recordings failed, 3 a limit of --fail-if is passed, 2 bad usage or cancelled, 1 a bug of
ours. What is done stays, the summary tells of it, and --resume does the rest.
"""


def kinds() -> list[str]:
    """What can be written for each recording."""
    from ..bridge.exports import EXPORTS

    return ["blend", *(export.suffix.removeprefix(".") for export in EXPORTS), "npz"]


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = _EPILOG
    parser.add_argument(
        "jobs", type=InputPath, metavar="JOBS", help="a folder, a pattern of names, or a table"
    )
    parser.add_argument(
        "-o",
        "--output",
        type=OutputFolder.of(*SUMMARY),
        required=True,
        metavar="FOLDER",
        help="where the outputs go, a report for each, and the summary",
    )
    parser.add_argument(
        "--write",
        action="append",
        choices=kinds(),
        help="kind of file to write for each recording, npz for the bones' tracks, without Blender (default: blend)"
        "; may be repeated",
    )
    parser.add_argument("--workers", type=int, metavar="N", help="processes (default: one for each core)")
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="use the Dask cluster of this scheduler (tcp://HOST:PORT, or its scheduler file), or with "
        "the word local one that is started here with --workers processes; needs distributed",
    )
    parser.add_argument(
        "--timeout", type=float, metavar="S", help="seconds for one recording, after which it has failed"
    )
    parser.add_argument(
        "--resume",
        action="store_true",
        help="do only what is missing, or whose inputs or settings are no more what its report says",
    )
    add_bake_options(parser)
    only_said(parser)


def _prepare(options: argparse.Namespace) -> None:
    from .tasks import said_for_all

    options.said = said_for_all(options)
    usual = {
        "json": None,
        "write": ["blend"],
        "workers": None,
        "scheduler": None,
        "timeout": None,
        "resume": False,
    }
    for name, value in usual.items():
        if not hasattr(options, name):
            setattr(options, name, value)
    options.write = list(dict.fromkeys(options.write))
    options.workers = _cores() if options.workers is None else options.workers
    if options.workers < 1:
        raise InputError(f"--workers {options.workers}: give at least one")
    if options.scheduler == "":
        raise InputError("--scheduler: give an address, or local")
    if options.timeout is not None and not options.timeout > 0.0:
        raise InputError(f"--timeout {options.timeout:g}: give seconds")
    options.done = ""


def _cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _run(options: argparse.Namespace, outputs: Transaction) -> Report:
    """Many bakes, each with its outputs and report, and their summary."""
    from .tasks import make_tasks

    tasks = make_tasks(options, options.said)
    rows: list[dict[str, Any]] = []
    start = time.monotonic()
    try:
        _follow(tasks, options, start, rows)
    except KeyboardInterrupt:
        # of what is done there is a summary, though nothing else of the verb is written
        if rows:
            with Transaction() as own:
                left = len(tasks) - len(rows)
                _write_summary(
                    _report(rows, options, time.monotonic() - start, left), Path(options.output), own
                )
        raise
    report = _report(rows, options, time.monotonic() - start)
    _write_summary(report, Path(options.output), outputs)
    counts = report["counts"]
    for line in (*report["warnings"], *(f"limit passed: {line}" for line in report["failed"][:20])):
        tell(f"footwork batch: {line}")
    say(
        options,
        f"{Path(options.output) / SUMMARY[0]}: "
        f"{counts['done']} baked, {counts['kept']} kept, {counts['failed']} failed",
    )
    return report


def _report(rows: list[dict[str, Any]], options: argparse.Namespace, wall: float, left: int = 0) -> Report:
    from ..core.batch.summary import batch_report

    baked = sum(row["state"] == "done" for row in rows)
    peaks = [row.pop("peak_mb") for row in rows if row.get("peak_mb")]
    timing = {
        "wall_s": wall,
        "workers": options.workers,
        "per_minute": baked / wall * 60.0 if baked and wall > 0.0 else None,
        "peak_mb": max(peaks, default=None),
    }
    return batch_report(rows, timing, left=left)


def _follow(
    tasks: list[dict[str, Any]], options: argparse.Namespace, start: float, rows: list[dict[str, Any]]
) -> None:
    """Add the rows of all tasks to `rows`, with progress told as they come."""
    from ..core.batch.progress import Progress

    reports = {task["name"]: Path(task["report"]).relative_to(options.output).as_posix() for task in tasks}
    told = start
    with _engine(tasks, options) as (results, options.workers):
        progress = Progress(len(tasks), sum(task["bytes"] for task in tasks), options.workers)
        for row in results:
            rows.append({**row, "report": reports[row["name"]]})
            size, spent = row.pop("bytes"), row.get("spent_s", 0.0)
            progress = progress.after(size, spent, baked=row["state"] == "done")
            options.done = f"; {progress.done} of {progress.total} were done, --resume does the rest"
            if row["state"] == "failed":
                tell(f"footwork batch: {row['name']}: {row['error']}")
            now = time.monotonic()
            if now - told >= _TOLD_EVERY_S or progress.done == progress.total:
                tell(progress.in_words(now - start))
                told = now


@contextlib.contextmanager
def _engine(
    tasks: list[dict[str, Any]], options: argparse.Namespace
) -> Generator[tuple[Generator[dict[str, Any]], int]]:
    """The rows of tasks as they are done, and how many are done at once."""
    from . import dask_engine
    from .hands import on_this_machine

    if options.scheduler is None:
        with contextlib.closing(on_this_machine(tasks, options.workers, options.timeout)) as rows:
            yield rows, options.workers
        return
    with (
        dask_engine.cluster(options.scheduler, options.workers) as client,
        contextlib.closing(dask_engine.on_cluster(client, tasks, options.timeout)) as rows,
    ):
        yield rows, dask_engine.threads_of(client)


def _write_summary(report: Report, folder: Path, outputs: Transaction) -> None:
    from ..core.batch.page import batch_page
    from ..core.batch.summary import to_csv

    texts = zip(SUMMARY, (batch_page(report), report_text(report), to_csv(report)), strict=True)
    for name, text in texts:
        content = text.encode(errors="replace")
        outputs.write(folder / name, lambda file, content=content: file.write(content))


BATCH = Verb(
    "batch",
    "bake many recordings on all cores of a machine, or on a cluster",
    _add_arguments,
    _run,
    prepare=_prepare,
    maps_bones=True,
    when_cancelled=lambda options: getattr(options, "done", ""),
)

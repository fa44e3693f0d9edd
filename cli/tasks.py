"""From the jobs of a batch to tasks: plain values, one for each recording, that any process can take."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from ..core.batch.entries import Entry, find_entries, in_folder, largest_first
from ..core.errors import FaultError, InputError
from ..core.settings import BakeSettings
from .bake_options import Said, bake_defaults, check_complete, paths_from, read_said
from .common import each, run
from .options import InputPath, read_settings
from .repeat import complete_bake
from .starter import use_starter

Task = dict[str, Any]
_MOST_FAULTS = 20


def make_tasks(options: argparse.Namespace, said: Said) -> list[Task]:
    """The tasks of a batch, the largest recordings first.

    Args:
        options: of the verb: `jobs`, `output`, `write`, `resume`.
        said: the options of a bake that are said for all recordings.

    Raises:
        InputError: of the jobs or the options, before any work.
    """
    from ..core import VERSION
    from ..core.evaluation.limits import parse_limit

    if Path(options.jobs).is_dir() and Path(options.output).resolve().is_relative_to(
        Path(options.jobs).resolve()
    ):
        raise InputError(f"{options.output}: is in the folder of recordings; choose another")
    entries = find_entries(options.jobs)
    clash = in_folder(entries, Path(options.output))
    if clash:
        raise InputError(f"{options.output}: holds recordings ({clash.recording}); choose another folder")
    each(said.get("fail_if", []), parse_limit)
    tasks: list[Task] = []
    faults: list[str] = []
    for entry, size in largest_first(entries):
        try:
            bake = _options_of(entry, said)
        except InputError as error:
            faults += [
                line if line.startswith(entry.place) else f"{entry.place}: {line}" for line in error.lines
            ]
            if entry.values:
                continue
            break  # what is wrong with one is wrong with all
        tasks.append(
            {
                "name": entry.name,
                "bytes": size,
                "options": vars(bake),
                "targets": [str(Path(options.output, f"{entry.name}.{kind}")) for kind in options.write],
                "report": str(Path(options.output, f"{entry.name}.json")),
                "inputs": _inputs(bake),
                "resume": options.resume,
                "folder": str(Path.cwd()),
                "version": VERSION,
            }
        )
    if faults:
        raise InputError(*faults[:_MOST_FAULTS])
    _check_shared(tasks)
    if not all(task["options"]["database"] for task in tasks):
        use_starter(run)  # once, not by every worker
    return tasks


def _options_of(entry: Entry, said: Said) -> argparse.Namespace:
    """All options of one bake: its row, over what is said for all, over an earlier report, over the defaults."""
    from ..core.evaluation.limits import parse_limit

    own: Said = {}
    if entry.values:
        try:
            own = paths_from(read_said(entry.values), entry.folder)
        except FaultError as fault:
            raise InputError(f"{entry.place}: {fault}; footwork batch --help lists the options") from None
    bake = argparse.Namespace(recording=InputPath(entry.recording), **own)
    complete_bake(bake, said)
    check_complete(bake)
    read_settings(bake, BakeSettings)
    each(own.get("fail_if", []), parse_limit)
    return bake


def _inputs(bake: argparse.Namespace) -> list[str]:
    given = [
        item for value in vars(bake).values() for item in (value if isinstance(value, list) else [value])
    ]
    return [file for item in given if isinstance(item, InputPath) for file in item.files()]


def _check_shared(tasks: Sequence[Task]) -> None:
    """Raise for a database or the like that is not there: no recording would come out."""
    missing: dict[str, None] = {}
    checked: set[str] = set()
    for path in (path for task in tasks for path in _shared(task["options"])):
        if path not in checked:
            checked.add(path)
            if not any(os.path.exists(file) for file in InputPath(path).files()):  # noqa: PTH110
                missing[path] = None
    if missing:
        raise InputError(*(f"{path}: no such file; check its name" for path in list(missing)[:_MOST_FAULTS]))


def _shared(options: dict[str, Any]) -> Iterator[str]:
    yield from options["database"]
    yield from options["bone_map"]
    for name in ("rig", "ground", "predictor"):
        if options[name] and options[name] != "headset":
            yield options[name]


def said_for_all(options: argparse.Namespace) -> dict[str, Any]:
    """The options of a bake that were said on a batch's command line."""
    return {name: getattr(options, name) for name in bake_defaults() if hasattr(options, name)}

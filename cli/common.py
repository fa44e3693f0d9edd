"""What the verbs of the command line share: reading, progress, output."""

from __future__ import annotations

import argparse
import contextlib
import importlib
import sys
from collections.abc import Callable, Generator, Sequence
from pathlib import Path
from typing import Any

from ..core import jobs
from ..core.bounds import REPORT_BYTES
from ..core.errors import FaultError, InputError, one_line
from .answers import read_take_answers
from .verb import Report

NO_FIGURES = "no figures: they need matplotlib (pip install matplotlib)"


def each(paths: Sequence[str], read: Callable[[str], Any]) -> list[Any]:
    """`read` every path; all faults together in one InputError, a line each."""
    results: list[Any] = []
    faults: list[str] = []
    for path in paths:
        try:
            results.append(read(path))
        except InputError as error:
            faults += error.lines
    if faults:
        raise InputError(*faults)
    return results


def run(job: jobs.Job[Any]) -> Any:
    """Drive a job to its end, telling its progress on standard error."""
    last = ("", -1.0)

    def progress(fraction: float, message: str) -> None:
        nonlocal last
        if message != last[0] or fraction >= last[1] + 0.1:
            tell(f"[{fraction:4.0%}] {message}")
            last = (message, fraction)

    return jobs.run(job, progress)


def report_text(report: Report) -> str:
    """A report as JSON."""
    from ..core.json_text import to_json

    return to_json(report, indent=2) + "\n"


def say(options: argparse.Namespace, *lines: str) -> None:
    """Print lines for people, unless standard output carries the JSON report; names in them as one can show them."""
    if options.json != "-":
        print("\n".join(map(one_line, lines)))


def tell(line: str) -> None:
    """Print a line on standard error, whatever a file or its name put into it."""
    print(one_line(line), file=sys.stderr, flush=True)


@contextlib.contextmanager
def needing(library: str, otherwise: str) -> Generator[None]:
    """For imports: InputError that says `otherwise` where a library that they need is not there."""
    try:
        yield
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != library:
            raise
        raise InputError(otherwise) from error


def drawing() -> Any:
    """The module `figures`; InputError where matplotlib is missing."""
    with needing("matplotlib", NO_FIGURES):
        return importlib.import_module(".figures", __package__)


def read_scene(path: str) -> Any:
    """A take from a file that Blender's importers read; InputError where there is no Blender."""
    from ..core.mocap.containers import NO_BLENDER

    with needing("bpy", f"{path}: {NO_BLENDER}"):
        from ..bridge.importing import read_scene_take
    return read_scene_take(path)


def load_recording(path: str, answers: Any) -> Any:
    """A recording from a file or folder; from animated objects where Blender has to read it."""
    from pathlib import Path

    from ..core.mocap.containers import container_of
    from ..core.recording.read import is_blend, read_recording

    if not Path(path).is_dir():
        container = container_of(path)
        if is_blend(path) or (container is not None and container.read is None):
            with needing(
                "bpy", f"{path}: objects of scenes are read in Blender: run it there, or install bpy"
            ):
                from ..bridge.importing import read_scene_recording
            return read_scene_recording(path, answers)
    return read_recording(path, answers)


def load_takes(options: argparse.Namespace, paths: Sequence[str], fps: float | None = None) -> list[Any]:
    """Takes, read as the flags say, with their doubts told on standard error."""
    from ..core.mocap.take import repeated
    from ..core.mocap.takes import load_take

    answers = read_take_answers(options)
    takes = each(paths, lambda path: load_take(path, fps, answers, read_scene))
    for take in takes:
        for line in take.doubts:
            tell(f"{take.file}: doubtful: {line}")
    for line in repeated(takes):
        tell(f"doubtful: {line}")
    return takes


def read_report(path: str) -> Report:
    """A report of evaluate or bake; InputError where the file is none."""
    from ..core.evaluation.compare import check_report
    from ..core.json_text import read_json

    try:
        return check_report(read_json(path, "report", REPORT_BYTES))
    except FaultError as fault:
        raise InputError(f"{path}: {fault}; give a report of evaluate or bake") from None


def load_databases(paths: Sequence[str]) -> list[Any]:
    """Motion databases, all faults told together."""
    from ..core.database.sidecar import load_database

    return each(paths, lambda path: load_database(Path(path)))


def choose_predictor(name: str | None) -> Callable[[Any], Any]:
    """The function from recording to body orientation that `--predictor` names; what ships by default."""
    from ..core.recording.body_estimate import HEADSET
    from ..nn.predictor import headset_forward, load_predictor, predict, shipped_predictor

    if name == HEADSET:
        return headset_forward
    predictor = load_predictor(name) if name else shipped_predictor()
    return lambda recording: predict(predictor, recording)


def with_bone_maps(options: argparse.Namespace) -> contextlib.AbstractContextManager[None]:
    """The time in which the bone maps on the command line count; InputError for one that cannot be used."""
    maps: list[str] = getattr(options, "bone_map", [])
    if not maps:
        return contextlib.nullcontext()
    from ..core.mocap.families import KIND, read_family
    from ..core.presets import given_presets

    each(maps, read_family)
    return given_presets(KIND, maps)

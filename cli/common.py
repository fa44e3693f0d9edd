"""What the verbs of the command line share: options made from settings, reading, progress, output."""

from __future__ import annotations

import argparse
import contextlib
import importlib
import json
import os
import sys
from collections.abc import Callable, Generator, Sequence
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any

from ..core import jobs
from ..core.errors import InputError
from ..core.files import check_target, write_atomically
from ..core.settings import BakeSettings, check

Report = dict[str, Any]
_INPUTS = (
    "files",
    "takes",
    "take",
    "recording",
    "database",
    "predictor",
    "rig",
    "ground",
    "train_on",
    "against",
    "skeleton",
    "old",
    "new",
)
"""Options that name files to read."""
NO_FIGURES = "no figures: they need matplotlib (pip install matplotlib)"


def add_bake_options(parser: argparse.ArgumentParser) -> None:
    """The options of a bake."""
    add_database(parser)
    parser.add_argument(
        "--predictor", metavar="P.npz", help='body-orientation weights, or "headset" for none'
    )
    add_settings(parser, BakeSettings)


def add_database(parser: argparse.ArgumentParser) -> None:
    """The option for one or more databases."""
    parser.add_argument(
        "--database",
        action="append",
        required=True,
        metavar="DB.npz",
        help="a motion database; may be repeated",
    )


def add_settings(parser: argparse.ArgumentParser, settings: type, skip: Sequence[str] = ()) -> None:
    """One flag for each field of a settings dataclass, under its field name."""
    for item in fields(settings):
        if item.name in skip:
            continue
        meta, flag = item.metadata, "--" + item.name.replace("_", "-")
        assert item.default is not MISSING
        if isinstance(item.default, bool):
            parser.add_argument(
                flag,
                action=argparse.BooleanOptionalAction,
                default=item.default,
                help=f"{meta['help']} (default: {'on' if item.default else 'off'})",
            )
            continue
        unit = f" {meta['unit']}" if meta["unit"] else ""
        shown = f"{item.default:g}" if isinstance(item.default, float) else str(item.default)
        choices = "".join(f"; {name}: {tip}" for name, tip in (meta["choices"] or {}).items())
        parser.add_argument(
            flag,
            type=type(item.default),
            default=item.default,
            choices=list(meta["choices"]) if meta["choices"] else None,
            metavar=None if meta["choices"] else meta["unit"].upper().replace("/", "_PER_") or "N",
            help=f"{meta['help']}{choices} (default: {shown}{unit})".replace("%", "%%"),
        )


def read_settings(options: argparse.Namespace, settings: type, **fixed: Any) -> Any:
    """The checked settings dataclass that the flags say, with `fixed` fields from elsewhere."""
    names = [item.name for item in fields(settings) if item.name not in fixed]
    made = settings(**{name: getattr(options, name) for name in names}, **fixed)
    check(made)
    return made


def check_outputs(options: argparse.Namespace) -> None:
    """Raise InputError, before any work, where what a verb is to write cannot be written or is one of its inputs."""
    outputs = [options.output, *getattr(options, "export", ())] if options.writes else []
    if outputs and Path(outputs[0]).suffix.lower() != options.writes:
        raise InputError(
            f"{outputs[0]}: cannot write this kind of file; let its name end in {options.writes}"
        )
    plot = getattr(options, "plot", None)
    if plot is not None:
        if Path(plot).suffix.lower() != ".png":
            raise InputError(f"{plot}: figures are PNG; let its name end in .png")
        outputs.append(plot)
    if options.json not in (None, "-"):
        outputs.append(options.json)
    inputs = {Path(path).resolve() for path in _inputs(options)}
    targets: set[Path] = set()
    for path in outputs:
        target = check_target(path)
        if target in inputs:
            raise InputError(f"{path}: is one of the files to read; write to another one")
        if target in targets:
            raise InputError(f"{path}: is to be written twice; give each output a name of its own")
        targets.add(target)


def _inputs(options: argparse.Namespace) -> list[str]:
    """Every file that a verb is to read."""
    paths: list[str] = []
    for name in _INPUTS:
        value = getattr(options, name, None) or []
        paths += [value] if isinstance(value, str) else value
    # of FILE:OBJECT the file, too
    return paths + [path.rpartition(":")[0] for path in paths if ":" in path]


def each(paths: Sequence[str], read: Callable[[str], Any]) -> list[Any]:
    """`read` every path; all faults together in one InputError, a line each."""
    results: list[Any] = []
    faults: list[str] = []
    for path in paths:
        try:
            results.append(read(path))
        except InputError as error:
            faults.append(str(error))
    if faults:
        raise InputError("\n".join(faults))
    return results


def run(job: jobs.Job[Any]) -> Any:
    """Drive a job to its end, telling its progress on standard error."""
    last = ("", -1.0)

    def tell(fraction: float, message: str) -> None:
        nonlocal last
        if message != last[0] or fraction >= last[1] + 0.1:
            print(f"[{fraction:4.0%}] {message}", file=sys.stderr, flush=True)
            last = (message, fraction)

    return jobs.run(job, tell)


def write_report(report: Report, target: str) -> None:
    """JSON to a file, or to standard output for "-"."""
    text = json.dumps(report, indent=2, ensure_ascii=False) + "\n"
    if target == "-":
        sys.stdout.write(text)
        return
    write_atomically(target, lambda file: file.write(text.encode()))


@contextlib.contextmanager
def quiet_stdout(wanted: bool) -> Generator[None]:
    """While it lasts, and if `wanted`, whatever Blender prints goes to standard error, not into a report."""
    if not wanted:
        yield
        return
    sys.stdout.flush()
    kept = os.dup(1)
    os.dup2(2, 1)
    try:
        yield
    finally:
        sys.stdout.flush()
        os.dup2(kept, 1)
        os.close(kept)


def say(options: argparse.Namespace, text: str) -> None:
    """Print for people, unless standard output carries the JSON report."""
    if options.json != "-":
        print(text)


def drawing() -> Any:
    """The module `figures`; InputError where matplotlib is missing."""
    try:
        return importlib.import_module(".figures", __package__)
    except ModuleNotFoundError as error:
        if (error.name or "").split(".")[0] != "matplotlib":
            raise
        raise InputError(NO_FIGURES) from error


def load_takes(paths: Sequence[str], fps: float | None = None) -> list[Any]:
    """Takes with their doubts told on standard error."""
    from ..core.mocap.takes import load_take

    takes = each(paths, lambda path: load_take(path, fps))
    for take in takes:
        for doubt in take.doubts:
            print(f"{take.file}: doubtful: {doubt}", file=sys.stderr)
    return takes


def load_databases(paths: Sequence[str]) -> list[Any]:
    """Motion databases, all faults told together."""
    from ..core.database.sidecar import load_database

    return each(paths, lambda path: load_database(Path(path)))


def choose_predictor(name: str | None) -> Callable[[Any], Any]:
    """The function from recording to body orientation that `--predictor` names; what ships by default."""
    from ..core.recording.orientation import HEADSET
    from ..nn.predictor import headset_forward, load_predictor, predict, shipped_predictor

    if name == HEADSET:
        return headset_forward
    predictor = load_predictor(name) if name else shipped_predictor()
    return lambda recording: predict(predictor, recording)

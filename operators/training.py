"""The Python that trains, which needs PyTorch, and the training in a process of its own."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import lru_cache
from pathlib import Path

import bpy

from ..core.bounds import REPORT_BYTES
from ..core.errors import InputError
from ..core.jobs import Job
from ..core.json_text import parse_json
from ..core.mocap.answers import NO_ANSWERS, TakeAnswers
from ..core.mocap.bvh import write_bvh
from ..core.mocap.containers import container_of
from ..core.mocap.export import to_bvh
from ..core.staging import recover
from ..nn.settings import TrainSettings
from ..properties.preferences import preferences_of
from .rows import read_take

PACKAGE_FOLDER = Path(__file__).parents[1]
GET_TORCH = "-m pip install torch"
LOOK_AGAIN_S = 10.0
"""A Python that could not train is looked at again after this long: PyTorch may have come."""
NO_WINDOW = getattr(subprocess, "CREATE_NO_WINDOW", 0)

_LACKS = """
import importlib.util, sys
old = sys.version_info < (3, 11)
print("Python 3.11" if old else next((n for n in ("numpy", "torch") if importlib.util.find_spec(n) is None), ""))
"""
_COMMAND_LINE = """
import importlib.util, os, sys
folder = sys.argv[1]
spec = importlib.util.spec_from_file_location(
    "footwork", os.path.join(folder, "__init__.py"), submodule_search_locations=[folder])
sys.modules["footwork"] = module = importlib.util.module_from_spec(spec)
spec.loader.exec_module(module)
from footwork.cli import main
sys.exit(main(sys.argv[2:]))
"""


@dataclass(frozen=True, slots=True)
class Trainer:
    """The Python to train with."""

    python: str
    missing: str
    """Why it cannot train, with what to do; "" where it can."""


def find_trainer(context: bpy.types.Context) -> Trainer:
    """The Python that the preferences name, or else Blender's own."""
    preferences = preferences_of(context)
    said = "" if preferences is None else preferences.training_python
    if said:
        return named_trainer(bpy.path.abspath(said))
    if importlib.util.find_spec("torch") is not None:
        return Trainer(sys.executable, "")
    return Trainer(
        sys.executable,
        f"Training needs PyTorch; get it with: {sys.executable} {GET_TORCH} "
        "or name a Python that has it in the preferences. Everything else works without it",
    )


def named_trainer(python: str) -> Trainer:
    """Whether a Python outside Blender can train."""
    lacks = _lacks(python, int(time.monotonic() / LOOK_AGAIN_S))
    if not lacks:
        return Trainer(python, "")
    if lacks == "torch":
        return Trainer(python, f"{python} has no PyTorch; get it with: {python} {GET_TORCH}")
    if lacks == "numpy":
        return Trainer(python, f"{python} has no numpy; get it with: {python} -m pip install numpy")
    return Trainer(python, f"{python}: {lacks}; choose another one in the preferences")


_able: set[str] = set()


@lru_cache(maxsize=1)
def _lacks(python: str, _period: int) -> str:
    """What a Python lacks to train, "" for nothing; one that could once is not asked again."""
    if python in _able:
        return ""
    try:
        answer = subprocess.run(
            [python, "-I", "-c", _LACKS],
            capture_output=True,
            text=True,
            timeout=20.0,
            check=True,
            env=_bare_environment(),
            creationflags=NO_WINDOW,
        ).stdout.strip()
    except FileNotFoundError:
        return "no such file"
    except (OSError, subprocess.SubprocessError):
        return "it is no Python that runs"
    if answer == "Python 3.11":
        return "Python 3.11 or newer is needed"
    if not answer:
        _able.add(python)
    return answer


def flags_of(settings: TrainSettings) -> list[str]:
    """The command line's flags for everything that is not at its default."""
    flags: list[str] = []
    for item in fields(settings):
        value, flag = getattr(settings, item.name), item.name.replace("_", "-")
        if value == item.default:
            continue
        if isinstance(value, bool):
            flags.append(f"--{flag}" if value else f"--no-{flag}")
        else:
            flags += [f"--{flag}", str(value)]
    return flags


def train(
    python: str, takes: Sequence[tuple[str, TakeAnswers]], output: Path, settings: TrainSettings
) -> Job[dict]:
    """Train on takes in a process of its own; closing the generator ends that, and its checkpoint stays.

    Takes that only Blender reads, or of which something was said by hand, are handed over as BVH.

    Yields the fraction done and the last line said, with loss and held-out error.

    Returns:
        The report of `train-predictor`.

    Raises:
        InputError: what the training said of its input.
    """
    with tempfile.TemporaryDirectory() as folder:
        log, report = Path(folder) / "log", Path(folder) / "report.json"
        files: list[str] = []
        for number, (path, answers) in enumerate(takes):
            yield 0.0, f"Reading {Path(path).name}"
            files.append(_as_bvh(path, answers, Path(folder) / str(number)))
        arguments = ["train-predictor", "-o", str(output.absolute()), *flags_of(settings)]
        with log.open("wb") as sink:
            process = subprocess.Popen(
                [
                    python,
                    "-B",
                    "-P",
                    "-c",
                    _COMMAND_LINE,
                    str(PACKAGE_FOLDER),
                    *arguments,
                    "--json",
                    str(report),
                    "--",
                    *files,
                ],
                stdin=subprocess.DEVNULL,
                stdout=sink,
                stderr=sink,
                env=_own_environment() if python == sys.executable else _bare_environment(),
                creationflags=NO_WINDOW,
            )
        try:
            with log.open(encoding="utf-8", errors="replace") as lines:
                fraction, message = 0.0, "Starting"
                while process.poll() is None:
                    for line in lines:
                        fraction, message = progress(line, fraction, message)
                    yield fraction, message
                    time.sleep(0.01)
        finally:
            if process.poll() is None:
                process.kill()
                process.wait()
                recover(output.parent)
        if process.returncode != 0:
            raise InputError(_fault(log) or f"training ended with code {process.returncode}; try again")
        return parse_json(report.read_bytes(), REPORT_BYTES)


def _as_bvh(path: str, answers: TakeAnswers, folder: Path) -> str:
    """A file that any Python reads as it stands: the take's own, or a BVH of its motion in a new folder."""
    # what cannot be read the training says itself
    found = container_of(path) if Path(path).is_file() else None
    if answers == NO_ANSWERS and (found is None or found.read is not None):
        return path
    take = read_take(path, answers)
    folder.mkdir()
    made = folder / f"{take.name}.bvh"
    write_bvh(made, to_bvh(take.motion, take.name))
    return str(made)


def progress(line: str, fraction: float, message: str) -> tuple[float, str]:
    """A line of the command line's progress, "[ 12%] message"; the old values where it is something else."""
    head, bracket, rest = line.partition("%]")
    if bracket and head.lstrip("[ ").isdigit():
        return int(head.lstrip("[ ")) / 100.0, rest.strip()
    return fraction, message


def _fault(log: Path) -> str:
    """The last line that a training in vain wrote."""
    lines = [line for line in log.read_text(encoding="utf-8", errors="replace").splitlines() if line]
    return lines[-1].removeprefix("footwork train-predictor: ") if lines else ""


def _own_environment() -> dict[str, str]:
    """Blender's own Python finds what Blender finds."""
    return {**os.environ, "PYTHONUTF8": "1", "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}


def _bare_environment() -> dict[str, str]:
    """Another Python finds what it finds by itself."""
    kept = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "PYTHONHOME")}
    return {**kept, "PYTHONUTF8": "1"}

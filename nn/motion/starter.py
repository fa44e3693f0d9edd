"""Starter databases: motion databases from the starter takes, made on first use and kept for the user."""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from pathlib import Path

from ...core import VERSION
from ...core.body.motion import Motion
from ...core.database.build import build_database
from ...core.database.motion_database import MotionDatabase
from ...core.database.sidecar import load_database, save_database
from ...core.errors import InputError
from ...core.files import sha256_of
from ...core.jobs import Job, part
from ...core.mocap.take import Take
from ...core.presets import user_folder
from ...core.settings import DatabaseSettings
from ...core.transaction import Transaction
from .decoder import read_model
from .takes import FPS, WEIGHTS, starter_takes


@dataclass(frozen=True, slots=True)
class Recipe:
    """How one starter database is made."""

    name: str
    takes: tuple[str, ...]
    body_height: float
    """Share of the standing eye height that the takes are brought to."""
    height_range: tuple[float, float]


_MOVES = ("stand", "walk", "crab", "side_steps", "back", "turn")
_UPRIGHT = (
    *("stand", "stand_play", "walk", "walk_other", "curves", "crab", "side_steps", "back", "turn"),
    *("jog", "jog_other", "roam", "roam_other"),
)
RECIPES = (
    Recipe("starter_upright", _UPRIGHT, 1.0, (0.82, 1.03)),
    Recipe("starter_crouched", (*_MOVES, "crouch"), 0.78, (0.68, 0.82)),
    Recipe("starter_low", (*_MOVES, "crouch"), 0.63, (0.0, 0.68)),
    Recipe("starter_tiptoe", _MOVES, 1.04, (1.03, 2.0)),
)


def starter_folder() -> Path:
    """Where the user's starter databases are kept."""
    return user_folder("starter")


def make_databases(takes: Sequence[tuple[str, Motion]], tag: str) -> Job[list[MotionDatabase]]:
    """One database for each recipe; `tag` is kept in it."""
    by_name = {name: Take(name, f"{name}.bvh", _sha256(motion), motion, {}, ()) for name, motion in takes}
    made: list[MotionDatabase] = []
    for n, recipe in enumerate(RECIPES):
        low, high = recipe.height_range
        settings = DatabaseSettings(
            fps=FPS, mirror=True, body_height=recipe.body_height, height_low=low, height_high=high
        )
        job = build_database(
            [by_name[name] for name in recipe.takes], settings, name=recipe.name, tags=("starter", tag)
        )
        made.append((yield from _told(part(job, n / len(RECIPES), (n + 1) / len(RECIPES)), recipe.name)))
    return made


def _told(job: Job[MotionDatabase], name: str) -> Job[MotionDatabase]:
    """The job, with one message in place of its own."""
    while True:
        try:
            fraction, _ = next(job)
        except StopIteration as end:
            return end.value
        yield fraction, f"starter motion: {name}"


def starter_databases(
    folder: Path | None = None, load: Callable[[Path], MotionDatabase] = load_database
) -> Job[tuple[list[Path], list[MotionDatabase], list[str]]]:
    """The files of the starter databases, made first where they are missing, damaged or of another version.

    Args:
        folder: where they are kept; the user's by default.
        load: what reads a file, for callers that keep what is read.

    Returns:
        Their paths, what is in them, and a line where older ones were replaced.

    Raises:
        InputError: the model is damaged, or the folder cannot be written; one line.
    """
    folder = folder or starter_folder()
    tag = fingerprint()
    paths = [folder / f"{recipe.name}.npz" for recipe in RECIPES]
    found, why = _found(paths, tag, load)
    if why is None:
        return paths, found, []
    yield 0.0, "making the starter motion, once"
    takes = yield from part(starter_takes(read_model(WEIGHTS)), 0.0, 0.4)
    databases = yield from part(make_databases(takes, tag), 0.4, 0.95)
    with keeping(folder) as outputs:
        for path, database in zip(paths, databases, strict=True):
            save_database(path, database, outputs)
    return paths, [load(path) for path in paths], [why] if why else []


@contextlib.contextmanager
def keeping(folder: Path) -> Generator[Transaction]:
    """The time in which files are written into the starter folder; all of them or none.

    Raises:
        InputError: they cannot be; one line.
    """
    try:
        with Transaction() as outputs:
            outputs.folder(folder)
            yield outputs
    except InputError as error:
        told = f"the starter motion cannot be kept: {error.lines[0]}"
        raise InputError(f"{told}; or set FOOTWORK_PRESETS to another folder, or name databases") from error


def fingerprint() -> str:
    """What starter databases are kept for: this Footwork and its motion model."""
    return f"footwork {VERSION} {sha256_of(WEIGHTS)[:12]}"


def _found(
    paths: Sequence[Path], tag: str, load: Callable[[Path], MotionDatabase]
) -> tuple[list[MotionDatabase], str | None]:
    """What is in the files, and why they cannot be used: a line, "" where there are none, None where they can."""
    found: list[MotionDatabase] = []
    if not any(path.exists() for path in paths):
        return found, ""
    for path in paths:
        try:
            found.append(load(path))
        except InputError as error:
            return found, f"the starter motion was made again: {error}"
        if tag not in found[-1].tags:
            return found, f"the starter motion was made again: {path} is of another version"
    return found, None


def _sha256(motion: Motion) -> str:
    return hashlib.sha256(motion.positions.tobytes("C") + motion.rotations.tobytes("C")).hexdigest()

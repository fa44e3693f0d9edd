"""`starter`: the starter takes and databases, and what a bake without a database uses."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..core.transaction import Transaction
from .common import run, say, tell
from .options import OutputFolder
from .verb import Report, Verb


def starter_paths(run: Callable[[Any], Any]) -> list[str]:
    """The databases that a bake uses where none is named; `run` drives the job that makes them on first use."""
    from ..nn.motion.starter import starter_databases

    paths, notes = run(starter_databases())
    for note in notes:
        tell(f"footwork: {note}")
    return [str(path) for path in paths]


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    from ..nn.motion.starter import RECIPES
    from ..nn.motion.takes import SCRIPTS

    certain = [*(f"{name}.bvh" for name, *_ in SCRIPTS), *(f"{recipe.name}.npz" for recipe in RECIPES)]
    parser.add_argument(
        "-o",
        "--output",
        type=OutputFolder.of(*certain),
        required=True,
        metavar="FOLDER",
        help="where takes (.bvh) and databases (.npz) are written; is made where it is missing",
    )


def _run(options: argparse.Namespace, outputs: Transaction) -> Report:
    """Takes and databases of the motion model that ships."""
    from ..core.database.sidecar import save_database
    from ..core.jobs import part
    from ..core.mocap.bvh import write_bvh
    from ..core.mocap.export import to_bvh
    from ..nn.motion.decoder import read_model
    from ..nn.motion.starter import fingerprint, make_databases
    from ..nn.motion.takes import WEIGHTS, starter_takes

    folder = Path(options.output)
    outputs.folder(folder)
    model = read_model(WEIGHTS)
    takes = run(part(starter_takes(model), 0.0, 0.4))
    databases = run(part(make_databases(takes, fingerprint()), 0.4, 1.0))
    for name, motion in takes:
        write_bvh(folder / f"{name}.bvh", to_bvh(motion, name), outputs)
    for database in databases:
        save_database(folder / f"{database.name}.npz", database, outputs)
    seconds = sum(len(motion) / motion.fps for _, motion in takes)
    say(options, f"{folder}: {len(takes)} takes, {seconds:.0f} s")
    for database in databases:
        low, high = database.height_range
        say(
            options,
            f"  {database.name}.npz: {len(database)} frames, for headset heights {low:g} to {high:g}",
        )
    return {
        "folder": str(folder),
        "takes": [{"name": name, "seconds": len(motion) / motion.fps} for name, motion in takes],
        "databases": [
            {"name": database.name, "frames": len(database), "height_range": list(database.height_range)}
            for database in databases
        ],
        "model": dict(model.provenance),
    }


STARTER = Verb("starter", "write the starter motion: takes and databases", _add_arguments, _run)

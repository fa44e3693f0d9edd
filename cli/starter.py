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


def use_starter(run: Callable[[Any], Any], load: Callable[[Path], Any] | None = None) -> list[Any]:
    """The databases of a bake that names none; `run` drives what makes them on first use, `load` reads them."""
    from ..nn.motion.starter import starter_databases

    _, databases, notes = run(starter_databases(load=load) if load else starter_databases())
    for note in notes:
        tell(f"footwork: {note}")
    return databases


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    from ..nn.motion.example import NAME
    from ..nn.motion.starter import RECIPES
    from ..nn.motion.takes import SCRIPTS

    takes, databases = (f"{name}.bvh" for name, *_ in SCRIPTS), (f"{recipe.name}.npz" for recipe in RECIPES)
    certain = [f"{NAME}.csv", *takes, *databases]
    parser.add_argument(
        "-o",
        "--output",
        type=OutputFolder.of(*certain),
        required=True,
        metavar="FOLDER",
        help="where takes (.bvh), databases (.npz) and an example recording (.csv) go; is made where it is missing",
    )


def _run(options: argparse.Namespace, outputs: Transaction) -> Report:
    """Takes, databases and a recording of the motion model that ships."""
    from ..core.database.sidecar import save_database
    from ..core.jobs import part
    from ..core.mocap.bvh import write_bvh
    from ..core.mocap.export import to_bvh
    from ..core.recording.csv_format import write_csv
    from ..nn.motion.decoder import read_model
    from ..nn.motion.example import NAME, example_recording
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
    recording = example_recording(model)
    write_csv(folder / f"{NAME}.csv", recording, outputs)
    seconds = sum(len(motion) / motion.fps for _, motion in takes)
    say(options, f"{folder}: {len(takes)} takes, {seconds:.0f} s")
    for database in databases:
        low, high = database.height_range
        say(
            options,
            f"  {database.name}.npz: {len(database)} frames, for headset heights {low:g} to {high:g}",
        )
    say(options, f"  {NAME}.csv: a recording of {recording.times[-1]:.0f} s to try them with")
    return {
        "folder": str(folder),
        "takes": [{"name": name, "seconds": len(motion) / motion.fps} for name, motion in takes],
        "databases": [
            {"name": database.name, "frames": len(database), "height_range": list(database.height_range)}
            for database in databases
        ],
        "model": dict(model.provenance),
    }


STARTER = Verb(
    "starter", "write the starter motion: takes, databases and an example recording", _add_arguments, _run
)

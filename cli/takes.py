"""`inspect` and `simulate-recording`: what is in takes and recordings, and a recording from a take."""

from __future__ import annotations

import argparse
from typing import Any

from ..core.errors import InputError
from ..core.transaction import Transaction
from .answers import add_answers, add_take_answers, read_answers, read_take_answers
from .common import each, load_recording, load_takes, read_scene, say, tell
from .options import InputPath, add_output
from .verb import Report, Verb


def _add_inspect(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("files", type=InputPath, nargs="+", metavar="FILE", help="takes or recordings")
    add_answers(parser, "takes and recordings")


def _inspect(options: argparse.Namespace, outputs: Transaction) -> Report:
    """What is in takes and recordings, and what is doubtful."""
    from ..core.mocap.families import families
    from ..core.mocap.takes import is_take, load_take
    from ..core.recording.layouts import layouts

    def read(path: str) -> Any:
        if is_take(path):
            try:
                return load_take(path, None, read_take_answers(options), read_scene)
            except InputError as error:
                if "skeleton" not in str(error):
                    raise
                # objects that move may be trackers
                try:
                    return load_recording(path, read_answers(options))
                except InputError:
                    raise error from None
        return load_recording(path, read_answers(options))

    def look(path: str) -> Report:
        found = read(path)
        say(options, path)
        for name, value in found.found.items():
            say(options, f"  {name:<16} {value}")
        for doubt in found.doubts:
            say(options, f"  doubtful         {doubt}")
        report = {"file": path, "sha256": found.sha256, "found": found.found, "doubts": list(found.doubts)}
        if hasattr(found, "extra"):
            report["other_trackers"] = [
                {"name": item.name, "tracked": float(item.valid.mean())} for item in found.extra
            ]
        return report

    report = {"files": each(options.files, look)}
    skipped = [*families().skipped, *layouts().skipped]
    for line in skipped:
        tell(f"doubtful: {line}")
    return {**report, "skipped_presets": skipped}


def _add_simulate(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("take", type=InputPath, metavar="TAKE", help="a take")
    add_take_answers(parser)
    add_output(parser, "R.csv", "the recording to write")


def _simulate(options: argparse.Namespace, outputs: Transaction) -> Report:
    """A recording with virtual trackers from a take."""
    from ..core.recording.csv_format import write_csv
    from ..core.recording.simulate import simulate_recording

    (take,) = load_takes(options, [options.take])
    recording = simulate_recording(take.motion, take.name)
    write_csv(options.output, recording, outputs)
    say(options, f"{options.output}: {recording.times[-1]:.1f} s at {recording.fps:g} per second")
    return {"file": options.output, "seconds": float(recording.times[-1]), "fps": recording.fps}


INSPECT = Verb(
    "inspect",
    "show what is found in takes or recordings, and what is doubtful",
    _add_inspect,
    _inspect,
    maps_bones=True,
)
SIMULATE_RECORDING = Verb(
    "simulate-recording",
    "make a recording with virtual trackers from a take",
    _add_simulate,
    _simulate,
    maps_bones=True,
)

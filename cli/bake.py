"""`bake`: an animated rig from a recording."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Any

from ..core.errors import InputError
from ..core.files import sha256_of
from ..core.settings import BakeSettings
from ..core.transaction import Transaction
from .answers import add_answers, read_answers
from .common import choose_predictor, each, load_databases, needing, run, say, tell
from .options import InputPath, OutputPath, add_database, add_output, add_settings, read_settings
from .verb import Report, Verb

NO_BPY = "bake writes Blender files: run it in Blender, or install the Python module bpy"


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    from ..bridge import exports

    parser.add_argument(
        "recording", type=InputPath, metavar="RECORDING", help="the three trackers, in any known format"
    )
    parser.add_argument(
        "--rig",
        type=InputPath,
        metavar="FILE[:OBJECT]",
        help=".blend, .fbx, .glb or .vrm; default: the database's skeleton",
    )
    parser.add_argument(
        "--ground",
        type=InputPath,
        metavar="FILE.blend[:NAME]",
        help="what the feet stand on: an object or collection of a .blend, or all of it; comes into the output, too",
    )
    add_output(parser, "OUT.blend", "the file to write")
    parser.add_argument(
        "--export",
        type=OutputPath,
        action="append",
        default=[],
        metavar="FILE",
        help=f"also write {exports.in_words()}",
    )
    add_answers(parser)
    parser.add_argument(
        "--fps", type=float, metavar="N", help="frame rate of the scene (default: the database's)"
    )
    _add_part(parser)
    add_database(parser)
    parser.add_argument(
        "--predictor", type=InputPath, metavar="P.npz", help='body-orientation weights, or "headset" for none'
    )
    parser.add_argument(
        "--fit-range",
        action=argparse.BooleanOptionalAction,
        help="make the scene's range that of the bake (default: unless the rig is in a .blend, which keeps its range "
        "and gets the bake from the range's first frame on)",
    )
    parser.add_argument(
        "--fail-if",
        action="append",
        default=[],
        metavar="CONDITION",
        help='end with code 3 where a metric is so, as in "foot_skate_cm_s.mean > 2"; may be repeated',
    )
    add_settings(parser, BakeSettings)


def _add_part(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--from",
        dest="start",
        type=float,
        default=0.0,
        metavar="S",
        help="second of the recording to start at (default: its start)",
    )
    parser.add_argument(
        "--to",
        dest="stop",
        type=float,
        default=math.inf,
        metavar="S",
        help="second of the recording to stop at (default: its end)",
    )


def _run(options: argparse.Namespace, outputs: Transaction) -> Report:
    """An animated rig from a recording, written as a Blender file."""
    with needing("bpy", NO_BPY):
        from ..bridge import load, targets
    from ..bridge import exports
    from ..core.evaluation.limits import failures, parse_limit
    from ..core.measure.words import report_in_words
    from ..core.pipeline import bake

    settings = read_settings(options, BakeSettings)
    limits = each(options.fail_if, parse_limit)
    exports.check_targets(options.export)
    if options.fps is not None and not 1.0 <= options.fps <= 1000.0:
        raise InputError(f"--fps {options.fps:g}: give frames per second, such as 24")
    recording = _read_recording(options)
    databases = load_databases(options.database)
    predict = choose_predictor(options.predictor)
    target = targets.open_target(options.rig, databases[0].fps, options.fps, options.fit_range)
    fps = target.fps
    for doubt in target.doubts:
        tell(f"{target.name}: doubtful: {doubt}")
    ground = target.ground(options.ground) if options.ground else None
    result = run(bake(recording, databases, predict, target.rig, settings, output_fps=fps, ground=ground))
    rig, ground_file = (load.split_rig(path)[0] if path else None for path in (options.rig, options.ground))
    result.report["inputs"] += _more_inputs(options.predictor, rig, ground_file)
    target.write(result, Path(options.recording).stem)
    target.save(options.output, options.export, outputs)
    if limits:
        result.report["limits"] = [limit.text for limit in limits]
        result.report["failed"] = failures(result.report["metrics"], limits)
    failed = [f"failed: {line}" for line in result.report.get("failed", [])]
    for line in (*result.report["warnings"], *failed):
        tell(f"footwork bake: {line}")
    say(options, *report_in_words(result.report))
    say(
        options,
        f"{options.output}: {target.name}, {len(result.tracks.rotations)} frames at {fps:g} per second",
    )
    return result.report


def _read_recording(options: argparse.Namespace) -> Any:
    """The recording, or the part of it that is asked for."""
    from ..core.recording.cut import cut
    from ..core.recording.read import read_recording

    recording = read_recording(options.recording, read_answers(options))
    if options.start > 0.0 or options.stop < math.inf:
        recording = cut(recording, options.start, options.stop)
    return recording


def _more_inputs(
    predictor: str | None, rig: str | Path | None, ground: str | Path | None
) -> list[dict[str, str]]:
    """The files that a bake read besides what core knows of, for the report."""
    from ..core.recording.body_estimate import HEADSET

    read = {"predictor": None if predictor == HEADSET else predictor, "rig": rig, "ground": ground}
    return [
        {"kind": kind, "name": str(path), "sha256": sha256_of(path)} for kind, path in read.items() if path
    ]


BAKE = Verb(
    "bake",
    "turn a recording into an animated rig",
    _add_arguments,
    _run,
    maps_bones=True,
)

"""The command line: `blender --command footwork VERB`, and `python -m footwork VERB` where bpy is a Python module.

Exit codes: 0 done, 1 our bug, 2 bad usage or bad input, 3 a limit of --fail-if is passed.
"""

from __future__ import annotations

import argparse
import math
import os
import sys
import traceback
from collections.abc import Callable, Sequence
from pathlib import Path

from ..bridge import exports
from ..core.errors import InputError
from ..core.files import sha256_of, write_atomically
from ..core.settings import BakeSettings, DatabaseSettings
from ..nn.checkpoint import checkpoint_path
from ..nn.settings import TrainSettings
from . import evaluate as evaluation
from .common import (
    Report,
    add_bake_options,
    add_settings,
    check_outputs,
    choose_predictor,
    drawing,
    each,
    load_databases,
    load_takes,
    quiet_stdout,
    read_settings,
    run,
    say,
    write_report,
)

DONE, BUG, BAD_INPUT, LIMIT = 0, 1, 2, 3
LOST = {"none": (), "left": ("left",), "right": ("right",), "both": ("left", "right")}
"""What `--lost` says, as names of trackers."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one verb and return its exit code; nothing but the code says that it failed to a caller in Blender."""
    parser = make_parser()
    try:
        options = parser.parse_args(argv)
    except SystemExit as end:
        return int(end.code or 0)
    try:
        check_outputs(options)
        with quiet_stdout(options.json == "-"):
            report = options.run(options)
        if options.json is not None:
            write_report(report, options.json)
    except InputError as error:
        for line in str(error).splitlines():
            print(f"footwork {options.verb}: {line}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        return _cancelled(options)
    except BrokenPipeError:  # whoever read our output has read enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except Exception:
        # Blender's operators turn a cancel into an error of theirs
        if "KeyboardInterrupt" in traceback.format_exc():
            return _cancelled(options)
        traceback.print_exc()
        print(
            f"footwork {options.verb}: this is a bug in Footwork; please report the lines above",
            file=sys.stderr,
        )
        return BUG
    else:
        return LIMIT if report.get("failed") else DONE
    return DONE


def _cancelled(options: argparse.Namespace) -> int:
    hint = ""
    if options.verb == "train-predictor" and checkpoint_path(options.output).is_file():
        hint = f"; add --resume to go on from {checkpoint_path(options.output)}"
    print(f"footwork {options.verb}: cancelled{hint}", file=sys.stderr)
    return BAD_INPUT


def make_parser() -> argparse.ArgumentParser:
    """The parser of all verbs, with help made from `core.settings`."""
    parser = argparse.ArgumentParser(
        prog="footwork",
        description="Full-body animation from a VR headset and two hand controllers.",
        epilog="footwork VERB --help tells what a verb can do. Exit codes: 0 done, 2 bad usage or bad input (nothing "
        "written), 3 a limit of --fail-if is passed, 1 a bug of ours.",
    )
    verbs = parser.add_subparsers(dest="verb", metavar="VERB", required=True)

    def verb(
        name: str, run: Callable[[argparse.Namespace], Report], help: str, writes: str = ""
    ) -> argparse.ArgumentParser:
        """A verb; `writes` is the suffix of the one file that it must write, if it does."""
        sub = verbs.add_parser(name, help=help, description=help[0].upper() + help[1:] + ".")
        sub.set_defaults(run=run, writes=writes)
        sub.add_argument(
            "--json", metavar="FILE", help="write a machine-readable report, - for standard output"
        )
        return sub

    sub = verb("inspect", inspect, "show what is found in takes or recordings, and what is doubtful")
    sub.add_argument("files", nargs="+", metavar="FILE", help="BVH takes or recordings")
    _add_build(verb("build-database", build, "build a motion database from takes", ".npz"))
    sub = verb("database-info", info, "show a database's contents, coverage and provenance")
    sub.add_argument("database", metavar="DB.npz", help="a motion database")

    sub = verb("train-predictor", train, "train a body-orientation predictor on takes (needs torch)", ".npz")
    sub.add_argument("takes", nargs="+", metavar="TAKE", help="BVH takes")
    sub.add_argument("-o", "--output", required=True, metavar="P.npz", help="the weights to write")
    add_settings(sub, TrainSettings)

    sub = verb("evaluate-predictor", evaluate_predictor, "orientation errors beside the headset's forward")
    sub.add_argument("takes", nargs="+", metavar="TAKE", help="BVH takes, each the user once")
    sub.add_argument(
        "--predictor",
        action="append",
        metavar="P.npz",
        help="weights; may be repeated (default: everything that ships)",
    )
    sub.add_argument(
        "--lost", choices=LOST, default="none", help="controllers that sleep all the time (default: none)"
    )
    sub.add_argument(
        "--plot", metavar="FILE.png", help="draw the errors: by minute, and how often they are small"
    )

    sub = verb("simulate-recording", simulate, "make a recording with virtual trackers from a take", ".csv")
    sub.add_argument("take", metavar="TAKE", help="a BVH take")
    sub.add_argument("-o", "--output", required=True, metavar="R.csv", help="the recording to write")
    _add_bake(verb("bake", bake, "turn a recording into an animated rig", ".blend"))
    evaluation.add_verbs(verb)
    return parser


def _add_build(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("takes", nargs="+", metavar="TAKE", help="BVH takes")
    sub.add_argument("-o", "--output", required=True, metavar="DB.npz", help="the database to write")
    sub.add_argument(
        "--height-range",
        nargs=2,
        type=float,
        metavar=("LO", "HI"),
        default=(0.0, 2.0),
        help="headset heights over standing eye height for which it is meant (default: 0 2; with --body-height up to "
        "or from halfway to standing)",
    )
    sub.add_argument(
        "--tag", action="append", default=[], metavar="T", help="a word to find it by; may be repeated"
    )
    sub.add_argument(
        "--exclude",
        action="append",
        default=[],
        metavar="TAKE:FROM-TO",
        help="seconds of a take to leave out; may be repeated",
    )
    sub.add_argument(
        "--contact",
        action="append",
        default=[],
        metavar="TAKE:FOOT:STATE:FROM-TO",
        help="seconds of a take in which a foot, L or R, is planted or lifted, whatever is detected, such as "
        "walk:L:planted:1.2-1.65; may be repeated",
    )
    sub.add_argument(
        "--skeleton",
        metavar="DB.npz",
        help="build on this database's skeleton, so that a bake can use both (default: the first take's)",
    )
    add_settings(sub, DatabaseSettings, skip=("height_low", "height_high"))


def _add_bake(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("recording", metavar="RECORDING", help="the three trackers, in any known format")
    sub.add_argument(
        "--rig", metavar="FILE[:OBJECT]", help=".blend, .fbx, .glb or .vrm; default: the database's skeleton"
    )
    sub.add_argument(
        "--ground",
        metavar="FILE.blend[:NAME]",
        help="what the feet stand on: an object or collection of a .blend, or all of it; comes into the output, too",
    )
    sub.add_argument("-o", "--output", required=True, metavar="OUT.blend", help="the file to write")
    sub.add_argument(
        "--export", action="append", default=[], metavar="FILE", help=f"also write {exports.in_words()}"
    )
    sub.add_argument(
        "--eye-height", type=float, metavar="M", help="standing eye height, m (default: the recording's)"
    )
    sub.add_argument(
        "--fps", type=float, metavar="N", help="frame rate of the scene (default: the database's)"
    )
    sub.add_argument(
        "--from",
        dest="start",
        type=float,
        default=0.0,
        metavar="S",
        help="second of the recording to start at (default: its start)",
    )
    sub.add_argument(
        "--to",
        dest="stop",
        type=float,
        default=math.inf,
        metavar="S",
        help="second of the recording to stop at (default: its end)",
    )
    add_bake_options(sub)


def inspect(options: argparse.Namespace) -> Report:
    """What is in takes and recordings, and what is doubtful."""
    from ..core.mocap.takes import load_take
    from ..core.recording.read import read_recording

    def look(path: str) -> Report:
        found = load_take(path) if path.lower().endswith(".bvh") else read_recording(path)
        say(options, path)
        for name, value in found.found.items():
            say(options, f"  {name:<16} {value}")
        for doubt in found.doubts:
            say(options, f"  doubtful         {doubt}")
        return {"file": path, "sha256": found.sha256, "found": found.found, "doubts": list(found.doubts)}

    return {"files": each(options.files, look)}


def build(options: argparse.Namespace) -> Report:
    """A motion database from takes."""
    from ..core.database.build import build_database
    from ..core.database.clips import parse_exclusion
    from ..core.database.contact_edits import parse_contact_edit
    from ..core.database.describe import describe_database
    from ..core.database.sidecar import load_database, save_database

    low, high = options.height_range
    settings = read_settings(options, DatabaseSettings, height_low=low, height_high=high)
    if not low < high:
        raise InputError(f"--height-range {low:g} {high:g}: the first must be less than the second")
    skeleton = load_database(options.skeleton).skeleton if options.skeleton else None
    takes = load_takes(options.takes, settings.fps)
    job = build_database(
        takes,
        settings,
        name=Path(options.output).stem,
        tags=tuple(options.tag),
        exclude=[parse_exclusion(text) for text in options.exclude],
        contact_edits=[parse_contact_edit(text) for text in options.contact],
        skeleton=skeleton,
    )
    database = run(job)
    save_database(Path(options.output), database)
    report = describe_database(database)
    for line in report["provenance"]["skipped"]:
        print(f"footwork build-database: left out: {line}", file=sys.stderr)
    say(options, f"{options.output}: {len(database)} frames in {len(database.clips)} clips")
    if settings.body_height != 1.0:
        low, high = database.height_range
        say(
            options,
            f"  for headset heights {low:g} to {high:g}; an upright database needs a --height-range beside that",
        )
    return report


def info(options: argparse.Namespace) -> Report:
    """What a database holds."""
    from ..core.database.describe import describe_database
    from ..core.database.sidecar import load_database

    report = describe_database(load_database(Path(options.database)))
    low, high = report["height_range"]
    say(
        options,
        f"{report['name']}: {report['frames']} frames, {report['seconds']:.1f} s, {report['joints']} joints",
    )
    say(
        options,
        f"  headset heights  {low:g} to {high:g}; the takes suggest {report['suggested_height_range']}",
    )
    if report["body_height"] != 1.0:
        say(options, f"  body height      {report['body_height']:g}")
    say(options, f"  tags             {', '.join(report['tags']) or 'none'}")
    for clip in report["clips"]:
        mirrored = " mirrored" if clip["mirrored"] else ""
        say(options, f"  {clip['seconds']:8.1f} s       {clip['name']}{mirrored}")
    return report


def train(options: argparse.Namespace) -> Report:
    """A body-orientation predictor from takes."""
    from ..nn.settings import TrainSettings
    from ..nn.train import train_predictor

    settings = read_settings(options, TrainSettings)
    takes = load_takes(options.takes)
    return run(train_predictor(takes, settings, Path(options.output)))


def evaluate_predictor(options: argparse.Namespace) -> Report:
    """Orientation errors of predictors beside the headset's forward."""
    from ..nn.evaluate import errors_in_words, evaluate_predictors
    from ..nn.predictor import load_predictor, shipped_predictors

    figures = drawing() if options.plot else None
    if options.predictor:
        paths = list(dict.fromkeys(options.predictor))
        stems = [Path(path).stem for path in paths]
        names = stems if len(set(stems)) == len(stems) else paths
        predictors = dict(zip(names, each(paths, load_predictor), strict=True))
    else:
        predictors = shipped_predictors()
    report = evaluate_predictors(load_takes(options.takes), predictors, LOST[options.lost])
    say(options, errors_in_words(report))
    if figures is not None:
        write_atomically(options.plot, lambda file: file.write(figures.draw_predictors(report)))
    return report


def simulate(options: argparse.Namespace) -> Report:
    """A recording with virtual trackers from a take."""
    from ..core.recording.csv_format import write_csv
    from ..core.recording.simulate import simulate_recording

    (take,) = load_takes([options.take])
    recording = simulate_recording(take.motion, take.name)
    write_csv(options.output, recording)
    say(options, f"{options.output}: {recording.times[-1]:.1f} s at {recording.fps:g} per second")
    return {"file": options.output, "seconds": float(recording.times[-1]), "fps": recording.fps}


def bake(options: argparse.Namespace) -> Report:
    """An animated rig from a recording, written as a Blender file."""
    from ..core.pipeline import bake as bake_job
    from ..core.pipeline import report_in_words
    from ..core.recording.cut import cut
    from ..core.recording.read import read_recording

    try:
        from ..bridge import load, targets
    except ModuleNotFoundError as error:
        if error.name != "bpy":
            raise
        raise InputError(
            "bake writes Blender files: run it in Blender, or install the Python module bpy"
        ) from error
    settings = read_settings(options, BakeSettings)
    exports.check_targets(options.export)
    if options.fps is not None and not 1.0 <= options.fps <= 1000.0:
        raise InputError(f"--fps {options.fps:g}: give frames per second, such as 24")
    recording = read_recording(options.recording, options.eye_height)
    if options.start > 0.0 or options.stop < math.inf:
        recording = cut(recording, options.start, options.stop)
    databases = load_databases(options.database)
    predict = choose_predictor(options.predictor)
    fps = options.fps or databases[0].fps
    target = targets.open_target(options.rig, fps)
    for doubt in target.doubts:
        print(f"{target.name}: doubtful: {doubt}", file=sys.stderr)
    ground = target.ground(options.ground) if options.ground else None
    result = run(bake_job(recording, databases, predict, target.rig, settings, output_fps=fps, ground=ground))
    for kind, path in (
        ("predictor", None if options.predictor == "hmd" else options.predictor),
        ("rig", load.split_rig(options.rig)[0] if options.rig else None),
        ("ground", load.split_rig(options.ground)[0] if options.ground else None),
    ):
        if path:
            result.report["inputs"].append({"kind": kind, "name": str(path), "sha256": sha256_of(path)})
    target.write(result, Path(options.recording).stem)
    target.save(options.output, options.export)
    say(options, report_in_words(result.report))
    say(
        options,
        f"{options.output}: {target.name}, {len(result.tracks.rotations)} frames at {fps:g} per second",
    )
    return result.report

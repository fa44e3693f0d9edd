"""The command line: `blender --command footwork VERB`, and `python -m footwork VERB` where bpy is a Python module.

Exit codes: 0 done, 1 our bug, 2 bad usage or bad input, 3 a limit of --fail-if is passed.
"""

from __future__ import annotations

import argparse
import json
import sys
import traceback
from collections.abc import Callable, Sequence
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any

from .core import jobs
from .core.errors import InputError
from .core.files import write_atomically
from .core.settings import BakeSettings, DatabaseSettings, check

DONE, BUG, BAD_INPUT, LIMIT = 0, 1, 2, 3
Report = dict[str, Any]


def main(argv: Sequence[str] | None = None) -> int:
    """Run one verb and return its exit code; nothing but the code says that it failed to a caller in Blender."""
    parser = make_parser()
    try:
        options = parser.parse_args(argv)
    except SystemExit as end:
        return int(end.code or 0)
    try:
        report = options.run(options)
        if options.json is not None:
            write_report(report, options.json)
    except InputError as error:
        for line in str(error).splitlines():
            print(f"footwork {options.verb}: {line}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        print(f"footwork {options.verb}: cancelled, nothing written", file=sys.stderr)
        return BAD_INPUT
    except Exception:
        traceback.print_exc()
        print(
            f"footwork {options.verb}: this is a bug in Footwork; please report the lines above",
            file=sys.stderr,
        )
        return BUG
    return LIMIT if report.get("failed") else DONE


def make_parser() -> argparse.ArgumentParser:
    """The parser of all verbs, with help made from `core.settings`."""
    parser = argparse.ArgumentParser(
        prog="footwork", description="Full-body animation from a VR headset and two hand controllers."
    )
    verbs = parser.add_subparsers(dest="verb", metavar="VERB", required=True)

    def verb(name: str, run: Callable[[argparse.Namespace], Report], help: str) -> argparse.ArgumentParser:
        sub = verbs.add_parser(name, help=help, description=help[0].upper() + help[1:] + ".")
        sub.set_defaults(run=run)
        sub.add_argument(
            "--json", metavar="FILE", help="write a machine-readable report, - for standard output"
        )
        return sub

    sub = verb("inspect", inspect, "show what is found in takes or recordings, and what is doubtful")
    sub.add_argument("files", nargs="+", metavar="FILE", help="BVH takes or recordings")

    sub = verb("build-database", build, "build a motion database from takes")
    sub.add_argument("takes", nargs="+", metavar="TAKE", help="BVH takes")
    sub.add_argument("-o", "--output", required=True, metavar="DB.npz", help="the database to write")
    sub.add_argument(
        "--height-range",
        nargs=2,
        type=float,
        metavar=("LO", "HI"),
        default=(0.0, 2.0),
        help="headset heights over standing eye height for which it is meant (default: 0 2)",
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
    add_settings(sub, DatabaseSettings, skip=("height_low", "height_high"))

    sub = verb("database-info", info, "show a database's contents, coverage and provenance")
    sub.add_argument("database", metavar="DB.npz")

    sub = verb("train-predictor", train, "train a body-orientation predictor on takes (needs torch)")
    sub.add_argument("takes", nargs="+", metavar="TAKE", help="BVH takes")
    sub.add_argument("-o", "--output", required=True, metavar="P.npz", help="the weights to write")
    from .nn.settings import TrainSettings

    add_settings(sub, TrainSettings)

    sub = verb("evaluate-predictor", evaluate_predictor, "orientation errors beside the headset's forward")
    sub.add_argument("takes", nargs="+", metavar="TAKE", help="BVH takes, each the user once")
    sub.add_argument("--predictor", action="append", metavar="P.npz", help="default: everything that ships")

    sub = verb("simulate-recording", simulate, "make a recording with virtual trackers from a take")
    sub.add_argument("take", metavar="TAKE")
    sub.add_argument("-o", "--output", required=True, metavar="R.csv", help="the recording to write")

    sub = verb("bake", bake, "turn a recording into an animated rig")
    sub.add_argument("recording", metavar="RECORDING")
    sub.add_argument(
        "--rig", metavar="FILE[:OBJECT]", help=".blend, .fbx, .glb or .vrm; default: the database's skeleton"
    )
    sub.add_argument("-o", "--output", required=True, metavar="OUT.blend", help="the file to write")
    sub.add_argument(
        "--export", action="append", default=[], metavar="FILE", help="also write .fbx, .glb or .bvh"
    )
    sub.add_argument(
        "--eye-height", type=float, metavar="M", help="standing eye height, m (default: the recording's)"
    )
    sub.add_argument(
        "--fps", type=float, metavar="N", help="frame rate of the scene (default: the database's)"
    )
    add_bake_options(sub)

    # only here: it uses this module's helpers
    from . import cli_evaluate

    cli_evaluate.add_verbs(verb)
    return parser


def add_bake_options(parser: argparse.ArgumentParser) -> None:
    """The options of a bake."""
    add_database(parser)
    parser.add_argument("--predictor", metavar="P.npz", help='body-orientation weights, or "hmd" for none')
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
                flag, action=argparse.BooleanOptionalAction, default=item.default, help=meta["help"]
            )
            continue
        unit = f" {meta['unit']}" if meta["unit"] else ""
        shown = f"{item.default:g}" if isinstance(item.default, float) else str(item.default)
        parser.add_argument(
            flag,
            type=type(item.default),
            default=item.default,
            choices=list(meta["choices"]) if meta["choices"] else None,
            metavar=None if meta["choices"] else meta["unit"].upper().replace("/", "_PER_") or "N",
            help=f"{meta['help']} (default: {shown}{unit})".replace("%", "%%"),
        )


def read_settings(options: argparse.Namespace, settings: type, **fixed: Any) -> Any:
    """The checked settings dataclass that the flags say, with `fixed` fields from elsewhere."""
    names = [item.name for item in fields(settings) if item.name not in fixed]
    made = settings(**{name: getattr(options, name) for name in names}, **fixed)
    check(made)
    return made


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


def say(options: argparse.Namespace, text: str) -> None:
    """Print for people, unless standard output carries the JSON report."""
    if options.json != "-":
        print(text)


def inspect(options: argparse.Namespace) -> Report:
    """What is in takes and recordings, and what is doubtful."""
    from .core.mocap.takes import load_take
    from .core.recording.read import read_recording

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
    from .core.database.build import build_database
    from .core.database.clips import parse_exclusion
    from .core.database.describe import describe_database
    from .core.database.sidecar import save_database

    low, high = options.height_range
    settings = read_settings(options, DatabaseSettings, height_low=low, height_high=high)
    if not low < high:
        raise InputError(f"--height-range {low:g} {high:g}: the first must be less than the second")
    takes = load_takes(options.takes, settings.fps)
    job = build_database(
        takes,
        settings,
        name=Path(options.output).stem,
        tags=tuple(options.tag),
        exclude=[parse_exclusion(text) for text in options.exclude],
    )
    database = run(job)
    save_database(Path(options.output), database)
    report = describe_database(database)
    say(options, f"{options.output}: {len(database)} frames in {len(database.clips)} clips")
    return report


def info(options: argparse.Namespace) -> Report:
    """What a database holds."""
    from .core.database.describe import describe_database
    from .core.database.sidecar import load_database

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
    say(options, f"  tags             {', '.join(report['tags']) or 'none'}")
    for clip in report["clips"]:
        mirrored = " mirrored" if clip["mirrored"] else ""
        say(options, f"  {clip['seconds']:8.1f} s       {clip['name']}{mirrored}")
    return report


def load_takes(paths: Sequence[str], fps: float | None = None) -> list[Any]:
    """Takes with their doubts told on standard error."""
    from .core.mocap.takes import load_take

    takes = each(paths, lambda path: load_take(path, fps))
    for take in takes:
        for doubt in take.doubts:
            print(f"{take.file}: doubtful: {doubt}", file=sys.stderr)
    return takes


def train(options: argparse.Namespace) -> Report:
    """A body-orientation predictor from takes."""
    from .nn.settings import TrainSettings
    from .nn.train import train_predictor

    settings = read_settings(options, TrainSettings)
    takes = load_takes(options.takes)
    return run(train_predictor(takes, settings, Path(options.output)))


def evaluate_predictor(options: argparse.Namespace) -> Report:
    """Orientation errors of predictors beside the headset's forward."""
    from .nn.evaluate import errors_in_words, evaluate_predictors
    from .nn.predictor import load_predictor, shipped_predictors

    if options.predictor:
        predictors = {Path(p).stem: p for p in options.predictor}
        predictors = dict(zip(predictors, each(list(predictors.values()), load_predictor), strict=True))
    else:
        predictors = shipped_predictors()
    report = evaluate_predictors(load_takes(options.takes), predictors)
    say(options, errors_in_words(report))
    return report


def simulate(options: argparse.Namespace) -> Report:
    """A recording with virtual trackers from a take."""
    from .core.recording.csv_format import write_csv
    from .core.recording.simulate import simulate_recording

    (take,) = load_takes([options.take])
    recording = simulate_recording(take.motion, take.name)
    write_csv(options.output, recording)
    say(options, f"{options.output}: {recording.times[-1]:.1f} s at {recording.fps:g} per second")
    return {"file": options.output, "seconds": float(recording.times[-1]), "fps": recording.fps}


def choose_predictor(name: str | None) -> Callable[[Any], Any]:
    """The function from recording to body yaws that `--predictor` names; what ships by default."""
    from .nn.predictor import hmd_forward, load_predictor, predict_yaw, shipped_predictor

    if name == "hmd":
        return hmd_forward
    predictor = load_predictor(name) if name else shipped_predictor()
    return lambda recording: predict_yaw(predictor, recording)


def load_databases(paths: Sequence[str]) -> list[Any]:
    """Motion databases, all faults told together."""
    from .core.database.sidecar import load_database

    return each(paths, lambda path: load_database(Path(path)))


def bake(options: argparse.Namespace) -> Report:
    """An animated rig from a recording, written as a Blender file."""
    from .core.pipeline import bake as bake_job
    from .core.pipeline import report_in_words
    from .core.recording.read import read_recording

    try:
        from .bridge import files
    except ModuleNotFoundError as error:
        if error.name != "bpy":
            raise
        raise InputError(
            "bake writes Blender files: run it in Blender, or install the Python module bpy"
        ) from error
    settings = read_settings(options, BakeSettings)
    files.check_targets([options.output, *options.export])
    recording = read_recording(options.recording, options.eye_height)
    databases = load_databases(options.database)
    predict = choose_predictor(options.predictor)
    fps = options.fps or databases[0].fps
    target = files.open_target(options.rig, fps)
    result = run(bake_job(recording, databases, predict, target.rig, settings, output_fps=fps))
    target.write(result, Path(options.recording).stem)
    target.save(options.output, options.export)
    say(options, report_in_words(result.report))
    say(
        options,
        f"{options.output}: {target.name}, {len(result.tracks.rotations)} frames at {fps:g} per second",
    )
    return result.report

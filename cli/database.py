"""`build-database` and `database-info`."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..core.errors import InputError
from ..core.settings import DatabaseSettings
from ..core.transaction import Transaction
from .answers import add_take_answers
from .common import load_takes, run, say, tell
from .options import InputPath, add_output, add_settings, read_settings
from .verb import Report, Verb


def _add_build(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "takes", type=InputPath, nargs="+", metavar="TAKE", help="takes: BVH, MVNX, FBX, glTF"
    )
    add_output(parser, "DB.npz", "the database to write")
    parser.add_argument(
        "--height-range",
        nargs=2,
        type=float,
        metavar=("LO", "HI"),
        default=(0.0, 2.0),
        help="headset heights over standing eye height for which it is meant (default: 0 2; with --body-height up to "
        "or from halfway to standing)",
    )
    parser.add_argument(
        "--tag", action="append", default=[], metavar="T", help="a word to find it by; may be repeated"
    )
    parser.add_argument(
        "--exclude",
        action="append",
        default=[],
        metavar="TAKE:FROM-TO",
        help="seconds of a take to leave out; may be repeated",
    )
    parser.add_argument(
        "--contact",
        action="append",
        default=[],
        metavar="TAKE:FOOT:STATE:FROM-TO",
        help="seconds of a take in which a foot, L or R, is planted or lifted, whatever is detected, such as "
        "walk:L:planted:1.2-1.65; may be repeated",
    )
    parser.add_argument(
        "--skeleton",
        type=InputPath,
        metavar="DB.npz",
        help="build on this database's skeleton, so that a bake can use both (default: the first take's)",
    )
    add_take_answers(parser)
    add_settings(parser, DatabaseSettings, skip=("height_low", "height_high"))


def _build(options: argparse.Namespace, outputs: Transaction) -> Report:
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
    takes = load_takes(options, options.takes, settings.fps)
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
    save_database(options.output, database, outputs)
    report = describe_database(database)
    for line in report["provenance"]["skipped"]:
        tell(f"footwork build-database: left out: {line}")
    say(options, f"{options.output}: {len(database)} frames in {len(database.clips)} clips")
    if settings.body_height != 1.0:
        low, high = database.height_range
        say(
            options,
            f"  for headset heights {low:g} to {high:g}; an upright database needs a --height-range beside that",
        )
    return report


def _add_info(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("database", type=InputPath, metavar="DB.npz", help="a motion database")


def _info(options: argparse.Namespace, outputs: Transaction) -> Report:
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


BUILD_DATABASE = Verb(
    "build-database",
    "build a motion database from takes",
    _add_build,
    _build,
    maps_bones=True,
)
DATABASE_INFO = Verb(
    "database-info",
    "show a database's contents, coverage and provenance",
    _add_info,
    _info,
)

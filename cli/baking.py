"""One bake from its options to its files, and what several bakes of one process share."""

from __future__ import annotations

import argparse
import functools
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from ..core.errors import InputError
from ..core.files import sha256_of
from ..core.settings import BakeSettings
from ..core.transaction import Transaction
from .answers import read_answers
from .bake_options import bake_defaults, part_of, setting_names
from .common import choose_predictor, each, load_recording, needing, tell
from .options import read_settings
from .starter import use_starter
from .verb import Report

NO_BPY = "bake writes Blender files: run it in Blender, or install the Python module bpy"
TRACKS = ".npz"
"""The kind of output that needs no Blender."""
_KEPT = 8


class Library:
    """Databases, predictors and fingerprints, read once and kept as long as their files stay the same."""

    def __init__(self) -> None:
        self._database = functools.lru_cache(_KEPT)(_load_database)
        self._predictor = functools.lru_cache(_KEPT)(lambda path, stamp: choose_predictor(path))
        self._sha256 = functools.lru_cache(_KEPT * 8)(lambda path, stamp: sha256_of(path))

    def database(self, path: str | Path) -> Any:
        """A motion database."""
        return self._database(str(path), _stamp(path))

    def databases(self, paths: Sequence[str]) -> list[Any]:
        """Motion databases, all faults told together."""
        return each(paths, self.database)

    def predictor(self, name: str | None) -> Callable[[Any], Any]:
        """The function from recording to body estimate that `--predictor` names."""
        return self._predictor(name, _stamp(name) if name else None)

    def sha256(self, path: str | Path) -> str:
        """Fingerprint of a file; InputError where it cannot be read."""
        return self._sha256(str(path), _stamp(path))


def _stamp(path: str | Path) -> tuple[int, int] | None:
    try:
        found = os.stat(path)  # noqa: PTH116 - "headset" and the like are no paths
    except (OSError, ValueError):
        return None
    return found.st_mtime_ns, found.st_size


def _load_database(path: str, stamp: object) -> Any:
    from ..core.database.sidecar import load_database

    return load_database(Path(path))


def make(
    options: argparse.Namespace,
    targets: Sequence[str],
    outputs: Transaction,
    library: Library,
    run: Callable[[Any], Any],
) -> Report:
    """Bake a recording and put the result into the transaction.

    Args:
        options: complete (`bake_options.completed`).
        targets: the files to write, of the kinds of `bridge.exports`, .blend, or `TRACKS`.
        outputs: where they go.
        library: where databases and predictors come from.
        run: drives a job to its end.

    Returns:
        The report, with `frames`, `rate_fps` and `object` of what was written.

    Raises:
        InputError: anything that is not as it must be.
    """
    from ..core.evaluation.limits import failures, parse_limit
    from ..core.pipeline import bake

    settings = read_settings(options, BakeSettings)
    limits = each(options.fail_if, parse_limit)
    _check_kinds(targets)
    if options.fps is not None and not 1.0 <= options.fps <= 1000.0:
        raise InputError(f"--fps {options.fps:g}: give frames per second, such as 24")
    scene = _scene(options, targets)
    recording = _read_recording(options)
    databases = (
        library.databases(options.database) if options.database else use_starter(run, library.database)
    )
    predict = library.predictor(options.predictor)
    target = scene and scene(options.rig, databases[0].fps, options.fps, options.fit_range)
    for doubt in target.doubts if target else ():
        tell(f"{target.name}: doubtful: {doubt}")
    ground = target.ground(options.ground) if target and options.ground else None
    place = target.place(options.at) if target else None
    if target:
        target.write_as, target.blend = options.layer, options.blend
        target.body, target.fewer_keys = options.body, options.fewer_keys
        target.for_engine(options.engine or "", options.travel, options.deform_only)
        target.check()
    fps = target.fps if target else options.fps or databases[0].fps
    rig = target.rig if target else None
    result = run(
        bake(recording, databases, predict, rig, settings, output_fps=fps, ground=ground, place=place)
    )
    if target:
        target.write(result, Path(options.recording).stem)
        target.save([path for path in targets if not _is_tracks(path)], outputs)
    _write_tracks(result, [path for path in targets if _is_tracks(path)], outputs)
    report = _told(result.report, options, library)
    if limits:
        report["limits"] = [limit.text for limit in limits]
        report["failed"] = failures(report["metrics"], limits)
    report["written"] = {
        "object": target.name if target else result.rig.name,
        "frames": len(result.tracks.rotations),
        "fps": fps,
    }
    return report


def _is_tracks(path: str) -> bool:
    return Path(path).suffix.lower() == TRACKS


def _check_kinds(targets: Sequence[str]) -> None:
    from ..bridge import exports

    exports.check_targets([path for path in targets if Path(path).suffix.lower() not in (".blend", TRACKS)])


def _scene(options: argparse.Namespace, targets: Sequence[str]) -> Any:
    """What opens the scene to write into; None where no Blender is needed."""
    if all(map(_is_tracks, targets)) and not options.rig and not options.ground:
        return None
    with needing("bpy", NO_BPY):
        from ..bridge.targets import open_target
    return open_target


def _write_tracks(result: Any, paths: Sequence[str], outputs: Transaction) -> None:
    from ..core.rig.tracks_file import write_tracks

    for path in paths:
        outputs.write(path, lambda file: write_tracks(file, result.rig, result.tracks))


def _read_recording(options: argparse.Namespace) -> Any:
    """The recording, or the part of it that is asked for."""
    from ..core.recording.cut import cut

    recording = load_recording(options.recording, read_answers(options))
    part = part_of(options)
    return recording if part is None else cut(recording, *part)


def _told(report: Report, options: argparse.Namespace, library: Library) -> Report:
    """A bake's report with what it takes to repeat it."""
    from ..core import VERSION

    report["inputs"] += [
        {"kind": kind, "name": path, "sha256": library.sha256(path)} for kind, path in more_inputs(options)
    ]
    left_out = {*setting_names(), "settings", "fail_if", "recording"}
    said = {name: value for name, value in bake_options_of(options).items() if name not in left_out}
    return {
        **report,
        "producer": f"footwork {VERSION}",
        "recording": options.recording,
        "options": {name: value for name, value in said.items() if value not in (None, [], "")},
    }


def bake_options_of(options: argparse.Namespace) -> dict[str, Any]:
    """The options of a bake among all of a verb, by name."""
    return {name: getattr(options, name) for name in bake_defaults()}


def more_inputs(options: argparse.Namespace) -> list[tuple[str, str]]:
    """Kind and path of the files that a bake reads besides recording and databases."""
    from ..core.recording.body_estimate import HEADSET

    read = {
        "predictor": None if options.predictor == HEADSET else options.predictor,
        "rig": file_of(options.rig),
        "ground": file_of(options.ground),
    }
    return [(kind, path) for kind, path in read.items() if path]


def file_of(spec: str | None) -> str | None:
    """The file of FILE:OBJECT."""
    if not spec or Path(spec).is_file():
        return spec
    return spec.rpartition(":")[0] or spec

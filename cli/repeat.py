"""`--settings REPORT.json`: an earlier bake repeated, and what is not as it was."""

from __future__ import annotations

import argparse
import functools
from collections.abc import Mapping
from typing import Any

from ..core.bounds import REPORT_BYTES
from ..core.errors import FaultError, InputError
from .bake_options import Said, completed, read_said, setting_names
from .options import InputPath
from .verb import Report


def complete_bake(options: argparse.Namespace, *layers: Said) -> None:
    """Fill in all options of a bake: what was said, then what an earlier report says, then the defaults.

    Args:
        options: what was said; is changed.
        layers: what else was said, before the report.

    Raises:
        InputError: the report cannot be read, or is none of a bake.
    """
    completed_from = {name: value for layer in reversed(layers) for name, value in layer.items()}
    path = getattr(options, "settings", completed_from.get("settings"))
    earlier = _said_by_file(path) if path else {}
    completed(options, *layers, earlier)
    if not getattr(options, "recording", None):
        options.recording = earlier.get("recording")


@functools.lru_cache(16)
def _said_by_file(path: str) -> dict[str, Any]:
    """What a report says; the rows of a batch may have it in common."""
    return said_by(path, read_earlier(path))


def read_earlier(path: str) -> Report:
    """An earlier bake's report.

    Raises:
        InputError: it cannot be read, or says nothing of settings.
    """
    from ..core.json_text import read_json

    try:
        report = read_json(path, "report", REPORT_BYTES)
    except FaultError as fault:
        raise InputError(f"{path}: {fault}; give a report of bake") from None
    if not isinstance(report, dict) or not isinstance(report.get("settings"), dict):
        raise InputError(f"{path}: has no settings of a bake; give a report of bake")
    return report


def said_by(path: str, report: Mapping[str, Any]) -> dict[str, Any]:
    """What a report says of the bake that it is of.

    Settings that this Footwork does not know any more are left to `differences`.

    Raises:
        InputError: a value that the option cannot have.
    """
    options = report.get("options", {})
    known = {name: value for name, value in report["settings"].items() if name in setting_names()}
    try:
        if not isinstance(options, dict):
            raise FaultError("its options are none")
        said = read_said({**options, **known})
        recording = report.get("recording")
        if recording is not None:
            if not isinstance(recording, str):
                raise FaultError("its recording is no name of a file")
            said["recording"] = InputPath(recording)
    except FaultError as fault:
        raise InputError(f"{path}: {fault}; give a report of bake") from None
    return said


def differences(earlier: Mapping[str, Any], now: Mapping[str, Any]) -> list[str]:
    """Why a repeated bake may not give what the earlier one gave, a line each.

    Args:
        earlier: the report that was repeated.
        now: the report of the repetition.
    """
    lines: list[str] = []
    if earlier.get("producer") != now["producer"]:
        lines.append(
            f"not the same: made by {earlier.get('producer', 'an older footwork')}, now by {now['producer']}"
        )
    before, after = _inputs(earlier), _inputs(now)
    if "options" in earlier:
        for key in {**before, **after}:
            lines += _difference(key[0], before.get(key), after.get(key))
    else:
        lines.append("not the same: the earlier report does not say what its bake was made from")
    unknown = sorted(set(earlier["settings"]) - setting_names())
    if unknown:
        lines.append(f"not the same: this version has no setting {', '.join(unknown)}")
    new = sorted(setting_names() - set(earlier["settings"]))
    if new:
        lines.append(f"not the same: the earlier version had no setting {', '.join(new)}")
    return lines


def _difference(kind: str, before: Mapping[str, str] | None, after: Mapping[str, str] | None) -> list[str]:
    if before is None or after is None:
        row = before or after
        return [
            f"not the same: {kind} {row['name'] if row else ''} {'is new' if before is None else 'is missing'}"
        ]
    if before["sha256"] == after["sha256"]:
        return []
    return [f"not the same: {kind} {after['name']} has other content than {before['name']} had"]


def _inputs(report: Mapping[str, Any]) -> dict[tuple[str, int], Mapping[str, str]]:
    """Inputs by kind and their place among those of their kind."""
    found: dict[tuple[str, int], Mapping[str, str]] = {}
    rows = report.get("inputs", [])
    for row in rows if isinstance(rows, list) else []:
        if isinstance(row, dict) and all(isinstance(row.get(key), str) for key in ("kind", "name", "sha256")):
            number = sum(kind == row["kind"] for kind, _ in found)
            found[row["kind"], number] = row
    return found

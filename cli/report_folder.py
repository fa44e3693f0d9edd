"""The folder of a report: its page, the report itself and its figures."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from ..core.errors import InputError
from ..core.files import write_atomically
from .common import drawing, write_report
from .verb import Report


def report_folder(path: str | None) -> Path | None:
    """The folder for the report, which is made when there is something to write."""
    if path is None:
        return None
    folder = Path(path)
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{path}: is a file; give a folder for the report")
    return folder


def make(folder: Path) -> Path:
    """The folder, made where it is missing."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made ({error.strerror}); choose another folder") from error
    return folder


def write_folder(folder: Path, report: Report, plots: dict[str, list[Any]]) -> None:
    """The page, the report and the figures; without matplotlib the page has tables alone."""
    from ..core.evaluation.page import page

    make(folder)
    figures: dict[str, list[tuple[str, bytes]]] = {}
    notes: list[str] = []
    try:
        figure = drawing()
    except InputError as error:
        notes.append(str(error))
        print(f"footwork evaluate: {error}", file=sys.stderr)
    else:
        figures = {name: [(plot.title, figure.draw(plot)) for plot in some] for name, some in plots.items()}
        figures |= {entry["take"]: [("over time", figure.draw_series(entry))] for entry in report["takes"]}
    for name, drawn in figures.items():
        for i, (_, png) in enumerate(drawn):
            target = folder / f"{Path(name).stem}{f'-{i + 1}' if len(drawn) > 1 else ''}.png"
            write_atomically(target, lambda file, png=png: file.write(png))
    text = page(report, figures, notes)
    write_atomically(folder / "report.html", lambda file: file.write(text.encode()))
    write_report(report, str(folder / "report.json"))
    print(f"{folder / 'report.html'} written", file=sys.stderr)

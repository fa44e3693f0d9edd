"""The folder of a report: its page, the report itself and its figures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..core.errors import InputError
from ..core.transaction import Transaction
from .common import drawing, report_text, tell
from .verb import Report

PAGE, REPORT = CERTAIN = ("report.html", "report.json")
"""The files that are always in it; the figures' names depend on the takes."""


def write_folder(folder: Path, report: Report, plots: dict[str, list[Any]], outputs: Transaction) -> None:
    """The page, the report and the figures; without matplotlib the page has tables alone."""
    from ..core.evaluation.page import page

    outputs.folder(folder)
    figures: dict[str, list[tuple[str, bytes]]] = {}
    notes: list[str] = []
    try:
        figure = drawing()
    except InputError as error:
        notes.append(str(error))
        tell(f"footwork evaluate: {error}")
    else:
        figures = {name: [(plot.title, figure.draw(plot)) for plot in some] for name, some in plots.items()}
        figures |= {entry["take"]: [("over time", figure.draw_series(entry))] for entry in report["takes"]}
    for name, drawn in figures.items():
        for i, (_, png) in enumerate(drawn):
            target = folder / f"{Path(name).stem}{f'-{i + 1}' if len(drawn) > 1 else ''}.png"
            outputs.write(target, lambda file, png=png: file.write(png))
    for name, text in ((PAGE, page(report, figures, notes)), (REPORT, report_text(report))):
        outputs.write(folder / name, lambda file, text=text: file.write(text.encode(errors="replace")))
    place = folder / PAGE
    outputs.afterwards(lambda: tell(f"{place} written"))

"""Experiments as text for a terminal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .page import shown


def experiment_in_words(entry: Mapping[str, Any]) -> list[str]:
    """Title, table and relations of one experiment's report, line by line."""
    cells = [entry["columns"], *([shown(cell) for cell in row] for row in entry["rows"])]
    widths = [max(len(row[i]) for row in cells) for i in range(len(cells[0]))]
    lines = [f"{entry['name']}: {entry['title']}"]
    for row in cells:
        first = f"  {row[0]:<{widths[0]}}"
        lines.append(first + "".join(f"  {cell:>{w}}" for cell, w in zip(row[1:], widths[1:], strict=True)))
    for relation in entry["relations"]:
        mark = "holds" if relation["holds"] else "DOES NOT HOLD"
        lines.append(f"  {mark}: {relation['claim']} ({relation['figures']})")
    return [*lines, *(f"  note: {note}" for note in entry["notes"])]

"""The formats that recordings come in: to read another one, add an entry to FORMATS.

A table of another recorder with one row a frame needs no entry but a layout in JSON (`layouts.py`).
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass

from . import aframe, bsor, csv_format, layouts
from .raw import RawRecording
from .reading import columns, objects, osc, unreadable


@dataclass(frozen=True, slots=True)
class Format:
    """One file format that recordings come in."""

    name: str
    """For people, e.g. in the list of known formats."""
    recognise: Callable[[bytes], bool]
    """Whether a file's content looks like this format, whole or not."""
    read: Callable[[bytes, str], RawRecording]
    """Content and file name to samples; raises InputError with the place of the fault."""
    suffixes: tuple[str, ...]
    """Endings of its files' names, with the dot, for file dialogs and dropped files alone: content tells."""
    table: bool = False
    """Whether it is a table of text, which `reading.dress` may have to put in plain dress first."""


FORMATS = (
    Format("Footwork CSV", csv_format.recognise, csv_format.read_csv, (".csv",), table=True),
    Format("Beat Saber replay (BSOR)", bsor.recognise, bsor.read_bsor, (".bsor",)),
    Format("A-Frame motion-capture JSON", aframe.recognise, aframe.read_aframe, (".json",)),
)
"""Formats with a reader of their own, those that are told apart most surely first."""

UNKNOWN = (
    Format("XROR (not read)", unreadable.is_xror, unreadable.refuse_xror, ()),
    Format(osc.NAME, osc.recognise, osc.read, (".osc", ".log")),
    Format(columns.NAME, columns.recognise, columns.read, (".csv", ".tsv", ".txt", ".gz"), table=True),
    Format(objects.NAME, objects.recognise, objects.read, (".json", ".jsonl")),
)
"""What no format or layout claims, read by what the names in it say."""


KEPT = Format("table of known columns", columns.is_kept, columns.read, (), table=True)
"""Tables of which a person has said what their columns are (`reading.kept`)."""


def formats() -> tuple[Format, ...]:
    """Every format, in the order in which they are asked: FORMATS, tables that a person mapped, tables with a layout,
    any other file."""
    tables = (
        Format(
            layout.name,
            functools.partial(layouts.recognise, layout=layout),
            functools.partial(layouts.read_table, layout=layout),
            (".csv",),
            table=True,
        )
        for layout in layouts.layouts().entries
    )
    return (*FORMATS, KEPT, *tables, *UNKNOWN)


def suffixes() -> tuple[str, ...]:
    """The endings of all formats' file names, each once."""
    return tuple(dict.fromkeys(suffix for form in formats() for suffix in form.suffixes))

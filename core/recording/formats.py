"""The formats that recordings come in: to read another one, add an entry to FORMATS.

A table of another recorder with one row a frame needs no entry but a layout in JSON (`layouts.py`).
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass

from . import aframe, bsor, csv_format, layouts
from .raw import RawRecording


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


FORMATS = (
    Format("Footwork CSV", csv_format.recognise, csv_format.read_csv, (".csv",)),
    Format("Beat Saber replay (BSOR)", bsor.recognise, bsor.read_bsor, (".bsor",)),
    Format("A-Frame motion-capture JSON", aframe.recognise, aframe.read_aframe, (".json",)),
)
"""Formats with a reader of their own, those that are told apart most surely first."""


def formats() -> tuple[Format, ...]:
    """Every format that can be read: FORMATS, then the tables with a layout; the first to recognise a file reads it."""
    tables = (
        Format(
            layout.name,
            functools.partial(layouts.recognise, layout=layout),
            functools.partial(layouts.read_table, layout=layout),
            (".csv",),
        )
        for layout in layouts.layouts().entries
    )
    return (*FORMATS, *tables)


def suffixes() -> tuple[str, ...]:
    """The endings of all formats' file names, each once."""
    return tuple(dict.fromkeys(suffix for form in formats() for suffix in form.suffixes))

"""Paths of files: chosen in a dialog, kept in a .blend, suggested beside it."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import bpy

from ..core.errors import InputError


def chosen(operator: Any) -> list[str]:
    """Absolute paths that a file operator was given: several files of a folder, or one path.

    Raises:
        InputError: none was given.
    """
    names = [item.name for item in getattr(operator, "files", ()) if item.name]
    if names:
        return [str(Path(bpy.path.abspath(operator.directory)) / name) for name in names]
    if not operator.filepath:
        raise InputError("No file chosen")
    return [bpy.path.abspath(operator.filepath)]


def stored(path: str) -> str:
    """A path as it is kept in the .blend: relative to it where it is saved on the same drive."""
    if not bpy.data.filepath:
        return path
    try:
        return bpy.path.relpath(path)
    except ValueError:
        return path


def absolute(path: str) -> str:
    """A stored path as the one that every other way to the same file gives, too."""
    return os.path.normpath(bpy.path.abspath(path))


def beside_blend(name: str) -> str:
    """A path for a new file: in the .blend's folder, or in the home folder while it is not saved."""
    folder = Path(bpy.data.filepath).parent if bpy.data.filepath else Path.home()
    return str(folder / name)


def output(said: str, kind: str) -> Path:
    """Where the next .npz of a kind is written: as said, or a name after the .blend beside it."""
    if said:
        return Path(bpy.path.abspath(said)).with_suffix(".npz")
    stem = Path(bpy.data.filepath).stem if bpy.data.filepath else "footwork"
    return Path(beside_blend(f"{stem}_{kind}.npz"))

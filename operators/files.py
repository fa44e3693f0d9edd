"""What operators on files and lists share."""

import os
from pathlib import Path

import bpy


def chosen(operator) -> list[str]:
    """Absolute paths that a file operator was given: several files of a folder, or one path."""
    names = [item.name for item in operator.files if item.name]
    if names:
        return [str(Path(bpy.path.abspath(operator.directory)) / name) for name in names]
    return [bpy.path.abspath(operator.filepath)] if operator.filepath else []


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


def told(source) -> tuple[str, str]:
    """What a take or recording says of itself: found and doubts, a line each."""
    found = "\n".join(f"{name}\t{value}" for name, value in source.found.items())
    return found, "\n".join(source.doubts)


def poll_active(operator, rows, what: str) -> bool:
    """Poll for operators on a list's active row."""
    if not rows:
        operator.poll_message_set(f"There is no {what} in the list")
    return bool(rows)


def remove_active(rows, index: int) -> int:
    """Remove a row and give the index of the one to show next."""
    rows.remove(min(max(index, 0), len(rows) - 1))
    return min(max(index, 0), max(len(rows) - 1, 0))


def move_active(rows, index: int, step: int) -> int:
    """Move a row by `step` within the list and give its new index."""
    target = min(max(index + step, 0), len(rows) - 1)
    rows.move(index, target)
    return target


def select_only(context, obj: bpy.types.Object) -> None:
    """Make an object the only selected one and the active one."""
    for other in context.view_layer.objects:
        other.select_set(False)
    obj.select_set(True)
    context.view_layer.objects.active = obj


def active(rows, index: int):
    """The active row of a list; None where the list is empty."""
    return rows[min(max(index, 0), len(rows) - 1)] if rows else None


def listed(text: str) -> list[str]:
    """The parts of a text that are separated by commas."""
    return [part.strip() for part in text.split(",") if part.strip()]


def typed(value: float) -> float:
    """A number as it was typed: Blender's properties hold single precision."""
    return float(f"{value:.7g}")

"""JSON of any shape as rows: lists of frames, frames under numbers, columns as lists, lists of devices."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, cast

from .meaning import TIME, whose, words_of
from .rows import spread

DEVICE = "device"
"""Name of what tells whose pose a row is, where every device has rows of its own."""
_DEEP = 6
_LEAST = 4
"""Frames, or columns, that make a table."""
_KEY = re.compile(r"[A-Za-z_ -]*?(\d+(?:\.\d+)?)")
_TEXT_KEYS = (
    "role",
    "name",
    "device",
    "handedness",
    "hand",
    "side",
    "type",
    "source",
    "tracker",
    "id",
    "label",
)


def rows_of(data: Any) -> list[dict[str, Any]]:
    """Frames as flat rows, or one row a device under `DEVICE`; empty where a value has none."""
    devices = _devices(data)
    if devices:
        return [{DEVICE: name, **dict(flat(row))} for name, rows in devices for row in rows]
    frames = _frames(data)
    return [dict(flat(frame)) for frame in frames] if frames else _columns(data)


def flat(value: Any, name: str = "", depth: int = 0) -> Iterator[tuple[str, Any]]:
    """Every number and text of a frame under the names that lead to it."""
    if depth > _DEEP:
        return
    if isinstance(value, dict):
        for key, child in cast(dict[str, Any], value).items():
            yield from flat(child, f"{name}.{key}" if name else str(key), depth + 1)
    elif isinstance(value, list):
        for number, child in enumerate(cast(list[Any], value)[:26]):
            # what an item says of itself is its name
            yield from flat(child, f"{name}.{_label(child) or number}", depth + 1)
    elif isinstance(value, str) and value[-1:] in (")", "]", "}"):
        parts = spread(value)
        yield from ((f"{name}.{suffix}", float(text)) for suffix, text in parts)
        if not parts:
            yield name, value
    elif not isinstance(value, bool):
        yield name, value


def _label(item: Any) -> str:
    """The words by which an object names a tracker, "" for none."""
    if not isinstance(item, dict):
        return ""
    found = cast(dict[str, Any], item)
    keys = {key.lower(): key for key in found}
    texts = [found[keys[key]] for key in _TEXT_KEYS if key in keys and isinstance(found[keys[key]], str)]
    label = " ".join(texts)
    return label.replace(".", " ") if whose(words_of(label))[0] else ""


def _devices(data: Any, depth: int = 0) -> list[tuple[str, list[Any]]]:
    """Devices with lists of samples of their own, the headset among them."""
    if depth > 3 or not isinstance(data, dict | list):
        return []
    children: list[tuple[str, Any]] = (
        list(cast(dict[str, Any], data).items())[:40]
        if isinstance(data, dict)
        else [(_label(item), item) for item in cast(list[Any], data)[:40]]
    )
    found: list[tuple[str, list[Any]]] = []
    for name, child in children:
        if whose(words_of(name))[0]:
            samples = _frames(child) or _timed_columns(child)
            if len(samples) >= _LEAST:
                found.append((name, samples))
    if len(found) > 1 and any(whose(words_of(name))[0] == "head" for name, _ in found):
        return found
    deeper = (_devices(child, depth + 1) for _, child in children if isinstance(child, dict | list))
    return next((devices for devices in deeper if devices), list[tuple[str, list[Any]]]())


def _frames(data: Any, depth: int = 0) -> list[Any]:
    """The longest list of objects in a value, or of objects under numbers."""
    if depth > _DEEP:
        return []
    if isinstance(data, list):
        items = cast(list[Any], data)
        if len(items) > 1 and all(isinstance(item, dict) for item in items[:3]):
            return items
        if len(items) > _LEAST and isinstance(items[0], list):
            names = cast(list[Any], items[0])
            if len(names) > 1 and all(isinstance(cell, str) for cell in names):
                return _under(names, items[1:])
        children: Sequence[Any] = items[:20]
    elif isinstance(data, dict):
        found = cast(dict[str, Any], data)
        if isinstance(found.get("columns"), list) and isinstance(found.get("data"), list):
            return _under(found["columns"], found["data"])
        keyed = _keyed(found)
        if keyed:
            return keyed
        children = list(found.values())[:100]
    else:
        return []
    return max((_frames(child, depth + 1) for child in children), key=len, default=list[Any]())


def _under(names: Any, rows: Sequence[Any]) -> list[Any]:
    """Rows of cells under names; empty where they are none."""
    if not isinstance(names, list) or not all(isinstance(row, list) for row in rows[:3]):
        return []
    heads = [str(name) for name in cast(list[Any], names)]
    return [
        dict(zip(heads, cast(list[Any], row), strict=False)) if isinstance(row, list) else {} for row in rows
    ]


def _keyed(data: Mapping[str, Any]) -> list[Any]:
    """Objects under their numbers or times, which they get as a value."""
    if len(data) < _LEAST or not all(isinstance(child, dict) for child in data.values()):
        return []
    numbers = [_KEY.fullmatch(key) for key in data]
    if not all(numbers) or not any(
        isinstance(part, dict | list) for part in next(iter(data.values())).values()
    ):
        return []
    values = [float(found[1]) for found in numbers if found]
    name = "frame" if all(value == int(value) for value in values) else "time"
    # rows may have times of their own, which come first
    rows = [{**child, name: value} for value, child in zip(values, data.values(), strict=True)]
    return sorted(rows, key=lambda row: row[name])


def _columns(data: Any) -> list[dict[str, Any]]:
    """Rows of columns that are lists of equal length, however deep they lie."""
    columns = dict(_lists(data))
    lengths = [len(column) for column in columns.values()]
    length = max(set(lengths), key=lengths.count, default=0)
    columns = {name: column for name, column in columns.items() if len(column) == length}
    if length < _LEAST or len(columns) < 2:
        return []
    return [
        {key: value for name, column in columns.items() for key, value in flat(column[row], name)}
        for row in range(length)
    ]


def _timed_columns(data: Any) -> list[dict[str, Any]]:
    """Rows of columns with times among them: without, they are a part of a larger table."""
    rows = _columns(data)
    return rows if rows and any(TIME & set(words_of(name)) for name in rows[0]) else []


def _lists(value: Any, name: str = "", depth: int = 0) -> Iterator[tuple[str, list[Any]]]:
    """Lists of values or of short lists, under the names that lead to them."""
    if depth > _DEEP:
        return
    if isinstance(value, list):
        items = cast(list[Any], value)
        if len(items) >= _LEAST and not any(isinstance(item, dict) for item in items[:3]):
            yield name, items
    elif isinstance(value, dict):
        found = cast(dict[str, Any], value)
        if len(found) >= _LEAST and all(key.isdecimal() for key in found):
            yield name, list(found.values())
            return
        for key, child in found.items():
            yield from _lists(child, f"{name}.{key}" if name else key, depth + 1)

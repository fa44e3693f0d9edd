"""The kinds of files that takes come in, told by content: to read another one, add an entry to CONTAINERS."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from ..errors import InputError
from . import bvh, mvnx
from .bvh import BvhFile

_LOOKED_AT = 1 << 16
_GLTF = re.compile(rb'"asset"\s*:\s*\{[^{}]*"version"')

SceneReader = Callable[[str], BvhFile]
"""Reads a file of Blender's importers."""


@dataclass(frozen=True, slots=True)
class Container:
    """One kind of file that takes come in."""

    name: str
    recognise: Callable[[bytes], bool]
    """Whether the first bytes of a file look like it, whole or not."""
    read: Callable[[str, float | None], BvhFile] | None
    """File name and stated rate to a take; None where Blender reads it."""
    suffixes: tuple[str, ...]
    """Endings of its files' names, for file dialogs and dropped files alone."""


def _is_fbx(head: bytes) -> bool:
    return head.startswith((b"Kaydara FBX Binary", b"; FBX "))


def _is_gltf(head: bytes) -> bool:
    return head.startswith(b"glTF") or (head.lstrip().startswith(b"{") and _GLTF.search(head) is not None)


CONTAINERS = (
    Container("BVH", bvh.recognise, bvh.read_bvh, (".bvh",)),
    Container("MVNX", mvnx.recognise, mvnx.read_mvnx, (".mvnx",)),
    Container("FBX", _is_fbx, None, (".fbx",)),
    Container("glTF", _is_gltf, None, (".glb", ".gltf", ".vrma")),
)
SUFFIXES = tuple(suffix for container in CONTAINERS for suffix in container.suffixes)
NO_BLENDER = "FBX and glTF takes are read in Blender: run it there, or install the Python module bpy"


def container_of(path: str | os.PathLike[str]) -> Container | None:
    """The kind of a file, None for none of takes; InputError where it cannot be read."""
    try:
        with Path(path).open("rb") as stream:
            head = stream.read(_LOOKED_AT)
            # what a glTF file says of itself may stand at its end
            size = stream.seek(0, os.SEEK_END)
            stream.seek(max(size - _LOOKED_AT, len(head)))
            tail = stream.read(_LOOKED_AT)
    except IsADirectoryError:
        raise InputError(f"{path}: is a folder; give a file") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); check its name and rights") from error
    found = next((container for container in CONTAINERS if container.recognise(head)), None)
    if found is None and head.lstrip().startswith(b"{") and _is_gltf(b"{" + tail):
        return CONTAINERS[-1]
    return found


def read_container(
    path: str | os.PathLike[str], rate: float | None = None, scenes: SceneReader | None = None
) -> BvhFile:
    """A take as its file has it.

    Args:
        path: a file of one of `CONTAINERS`.
        rate: frames per second, in place of the file's.
        scenes: reads FBX and glTF; None where there is no Blender.

    Raises:
        InputError: missing, of another kind, or broken.
    """
    found = container_of(path)
    if found is None:
        # says of an empty or foreign file what it lacks
        return bvh.read_bvh(path, rate)
    if found.read is not None:
        return found.read(str(path), rate)
    if scenes is None:
        raise InputError(f"{path}: {NO_BLENDER}")
    take = scenes(str(path))
    return take if rate is None else replace(take, frame_time=1.0 / rate)

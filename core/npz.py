"""Arrays in `.npz` files without pickles: one reader for files from anywhere, and one writer.

What a file says of itself is compared with its bytes before memory is set aside for it: the size of every member with
its array's shape and kind, and all members that are asked for with a budget. Members that nobody asks for are not read.
"""

from __future__ import annotations

import contextlib
import math
import os
import re
import zipfile
import zlib
from collections.abc import Generator, Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO, cast

import numpy as np
from numpy.typing import NDArray

from .bounds import EXPANDED_BYTES, EXPANDED_TIMES, NPZ_BYTES, NPZ_DIRECTORY_BYTES, NPZ_DIRECTORY_ENTRIES
from .errors import FaultError, InputError

Array = NDArray[Any]

_HEADER_BYTES = 4096
"""Arrays of few dimensions take a hundred or two."""
_HEADER = re.compile(
    r"\{\s*'descr':\s*'(?P<kind>[<>|=]?(?:b1|[iu][1248]|f[248]|U\d{1,7}))',"
    r"\s*'fortran_order':\s*(?P<fortran>True|False),"
    r"\s*'shape':\s*\((?P<shape>(?:\d{1,12},\s?)*(?:\d{1,12})?)\),?\s*\}\s*"
)
"""What numpy writes above an array of truth values, whole numbers, numbers or texts."""
_CHUNK = 1 << 20
_DAMAGE = (ValueError, EOFError, KeyError, IndexError, RuntimeError, OverflowError, NotImplementedError)
"""What zipfile raises over damaged bytes, besides errors of its own."""


class Npz(Mapping[str, Array]):
    """The arrays of an open file by name; each is read when it is asked for.

    Asking raises FaultError where the array is damaged, or of another kind than truth values, numbers and texts.
    """

    def __init__(self, archive: zipfile.ZipFile, size: int) -> None:
        self._archive = archive
        self._most = max(EXPANDED_BYTES, EXPANDED_TIMES * size)
        """Bytes of all arrays together."""
        if sum(member.file_size for member in archive.infolist()) > self._most:
            raise FaultError(f"unpacks to more than {self._most >> 20} MB, far too much for its size")
        self._members: dict[str, zipfile.ZipInfo] = {}
        self._twice: set[str] = set()
        for member in archive.infolist():
            name = member.filename.removesuffix(".npy")
            if name in self._members:
                self._twice.add(name)
            self._members[name] = member

    def __getitem__(self, name: str) -> Array:
        return self.read(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._members)

    def __len__(self) -> int:
        return len(self._members)

    def read(self, name: str, most: int | None = None) -> Array:
        """One array of `most` elements at most; KeyError where there is none of this name."""
        member = self._members[name]
        with _damage(f"{name!r} cannot be read"):
            if name in self._twice:
                raise FaultError(f"has the array {name!r} twice")
            if member.flag_bits & 1 or member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
                raise FaultError(f"{name!r} is packed in a way that is not known here")
            with self._archive.open(member) as stream:
                return self._array(cast("BinaryIO", stream), name, member.file_size, most)

    def _array(self, stream: BinaryIO, name: str, size: int, most: int | None) -> Array:
        start, kind, shape, fortran = _read_header(stream, name)
        count, width = math.prod(shape), kind.itemsize
        if start + count * width != size:
            raise FaultError(f"{name!r} has {size} bytes for {_words(shape)} of {kind}")
        # texts of no length are numbers of elements that cost no bytes
        if count > self._most or (most is not None and count > most):
            raise FaultError(f"{name!r} is too large, {_words(shape)} of {kind}")
        content = np.empty(count * width, np.uint8)
        at = 0
        while at < len(content):
            got = stream.read(min(_CHUNK, len(content) - at))
            if not got:
                raise FaultError(f"{name!r} ends early")
            content[at : at + len(got)] = np.frombuffer(got, np.uint8)
            at += len(got)
        if stream.read(1):  # the end compares the checksum, too
            raise FaultError(f"{name!r} is longer than it says")
        if width == 0:
            return np.zeros(shape, kind)
        if kind.kind == "b" and content.size and content.max() > 1:
            raise FaultError(f"{name!r} holds truth values that are neither true nor false")
        if kind.kind == "U":
            _check_text(content.view(kind.byteorder.replace("=", "").replace("|", "") + "u4"), name)
        return content.view(kind).reshape(shape, order="F" if fortran else "C")


@contextlib.contextmanager
def open_npz(path: str | os.PathLike[str]) -> Generator[Npz]:
    """The arrays of a file, as long as it lasts.

    Raises:
        InputError: there is no such file, or it cannot be read.
        FaultError: it is no whole `.npz`, or its arrays together are too large for it.
    """
    try:
        file = Path(path).open("rb")  # noqa: SIM115 - the errors of what is done with it are none of its own
    except FileNotFoundError:
        raise InputError(f"{path}: cannot be read, there is no such file; check its name") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{path}: cannot be read ({reason}); check its name and rights") from error
    with file:
        with _damage("is cut short, or no .npz file at all"):
            size = os.fstat(file.fileno()).st_size
            if size > NPZ_BYTES:
                raise FaultError(f"has {size} bytes, more than {NPZ_BYTES}")
            guard = _Guard(file)
            archive = zipfile.ZipFile(cast("BinaryIO", guard))
            if len(archive.infolist()) > NPZ_DIRECTORY_ENTRIES:
                raise FaultError("has far too many members")
            guard.most = _CHUNK * 2
            arrays = Npz(archive, size)
        with archive:
            yield arrays


def write_npz(file: BinaryIO, arrays: Mapping[str, Any], *, compressed: bool = False) -> None:
    """As `numpy.savez` does, but with the same bytes from every numpy and on every day."""
    with zipfile.ZipFile(file, "w") as archive:
        for name, array in arrays.items():
            info = zipfile.ZipInfo(f"{name}.npy")
            info.compress_type = zipfile.ZIP_DEFLATED if compressed else zipfile.ZIP_STORED
            with archive.open(info, "w", force_zip64=True) as member:
                np.lib.format.write_array(member, np.asarray(array), allow_pickle=False)


class _Guard:
    """A file that never gives more than `most` bytes at once, whatever a directory says of its own size."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self.most = NPZ_DIRECTORY_BYTES
        self.seek, self.tell, self.seekable = file.seek, file.tell, file.seekable

    def read(self, size: int = -1) -> bytes:
        """Up to `size` bytes, or all that are left."""
        if size > self.most:
            raise FaultError("has a directory that is far too large")
        found = self._file.read(size if size >= 0 else self.most + 1)
        if len(found) > self.most:
            raise FaultError("has a directory that is far too large")
        return found


@contextlib.contextmanager
def _damage(otherwise: str) -> Generator[None]:
    """Whatever damaged bytes make zipfile raise, as a FaultError."""
    try:
        yield
    except FaultError:  # a ValueError, too
        raise
    except (zipfile.BadZipFile, zlib.error, OSError, MemoryError, *_DAMAGE) as error:
        raise FaultError(otherwise) from error


def _read_header(stream: BinaryIO, name: str) -> tuple[int, np.dtype[Any], tuple[int, ...], bool]:
    """Of an array in numpy's format: where its numbers start, their kind, the shape, and whether columns come first."""
    magic = stream.read(8)
    width = 2 if magic[6:7] == b"\x01" else 4
    length = stream.read(width)
    if magic[:6] != b"\x93NUMPY" or magic[6:8] not in (b"\x01\x00", b"\x02\x00", b"\x03\x00"):
        raise FaultError(f"{name!r} is no array of numpy's")
    size = int.from_bytes(length, "little")
    if len(length) < width or size > _HEADER_BYTES:
        raise FaultError(f"{name!r} has a header that cannot be read")
    found = _HEADER.fullmatch(stream.read(size).decode("latin-1"))
    if found is None:
        raise FaultError(f"{name!r} cannot be read: only truth values, numbers and texts can")
    shape = tuple(int(part) for part in found["shape"].split(",") if part.strip())
    return len(magic) + width + size, np.dtype(found["kind"]), shape, found["fortran"] == "True"


def _check_text(codes: Array, name: str) -> None:
    """Raise for what is no text: numbers that stand for no letter, or for half of one."""
    if (codes > 0x10FFFF).any() or ((codes >= 0xD800) & (codes < 0xE000)).any():
        raise FaultError(f"{name!r} holds what is no text")


def _words(shape: tuple[int, ...]) -> str:
    return " x ".join(map(str, shape)) if shape else "one"

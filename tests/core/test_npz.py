"""One reader for arrays from anywhere: whatever is wrong is one fault, and costs no memory."""

from __future__ import annotations

import io
import struct
import tracemalloc
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from footwork.core.errors import FaultError, InputError
from footwork.core.npz import open_npz, write_npz
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

KINDS = st.sampled_from(["?", "<i2", ">i8", "|u1", "<f4", ">f8", "<U3", ">U1"])
GROWTH = 16 << 20
"""Bytes that a refusal may cost."""


def npy(header: bytes, content: bytes = b"", version: bytes = b"\x01\x00") -> bytes:
    """A member in numpy's format with any header."""
    size = struct.pack("<H" if version[0] == 1 else "<I", len(header))
    return b"\x93NUMPY" + version + size + header + content


def described(descr: str, shape: str) -> bytes:
    return f"{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}\n".encode()


def archive(path: Path, members: Mapping[str, bytes], method: int = zipfile.ZIP_STORED) -> Path:
    with zipfile.ZipFile(path, "w", method) as file:
        for name, content in members.items():
            file.writestr(name, content)
    return path


def fault(path: Path, name: str = "a", most: int | None = None) -> str:
    """What reading one array is refused with, at no cost."""
    tracemalloc.start()
    try:
        with pytest.raises(FaultError) as caught, open_npz(path) as arrays:
            arrays.read(name, most)
        assert tracemalloc.get_traced_memory()[1] < GROWTH
    finally:
        tracemalloc.stop()
    return str(caught.value)


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(array=hnp.arrays(KINDS, hnp.array_shapes(min_dims=0, max_dims=3)), fortran=st.booleans())
def test_what_numpy_writes_is_read_as_numpy_reads_it(
    tmp_path: Path, array: np.ndarray, fortran: bool
) -> None:
    path = tmp_path / "a.npz"
    np.savez_compressed(path, a=np.asarray(array, order="F" if fortran else "C"))
    with np.load(path) as theirs, open_npz(path) as ours:
        expected, found = theirs["a"], ours["a"]
    assert (found.dtype, found.shape) == (expected.dtype, expected.shape)
    np.testing.assert_array_equal(found, expected)
    assert found.flags.writeable


@pytest.mark.parametrize("compressed", [False, True])
def test_numpy_reads_what_is_written(tmp_path: Path, compressed: bool) -> None:
    arrays = {"x": np.arange(6.0).reshape(2, 3), "name": np.array("walk"), "none": np.zeros((0, 4), ">f4")}
    files = [io.BytesIO(), io.BytesIO()]
    for file in files:
        write_npz(file, arrays, compressed=compressed)
    assert files[0].getvalue() == files[1].getvalue()
    files[0].seek(0)
    with np.load(files[0]) as found:
        assert list(found) == list(arrays)
        for name, array in arrays.items():
            np.testing.assert_array_equal(found[name], array)


HEADERS = {
    "no header": b"",
    "an open bracket": b"{'descr': '<f8', 'shape': (" + b"(" * 300,
    "other words": b"__import__('os').getcwd()",
    "not closed": b"{'descr': '<f8', 'fortran_order': False, 'shape': (1",
    "a pickle": described("'|O'", "(1,)"),
    "a record": described("[('a', '<f8')]", "(1,)"),
    "long doubles": described("'<f16'", "(1,)"),
    "complex numbers": described("'<c16'", "(1,)"),
    "dates": described("'<M8[s]'", "(1,)"),
    "a shape of 2^70": described("'<f8'", f"({2**70},)"),
    "a shape below zero": described("'<f8'", "(-1,)"),
    "a shape of gigabytes": described("'<f8'", "(1000000000,)"),
    "nothing, a million million times": described("'<U0'", "(999999999999,)"),
    "too long": described("'<f8'", "(1,)") + b" " * 5000,
}


@pytest.mark.parametrize("case", HEADERS)
def test_a_header_that_is_none_is_a_fault(tmp_path: Path, case: str) -> None:
    path = archive(tmp_path / "a.npz", {"a.npy": npy(HEADERS[case], b"\0" * 8)})
    assert "'a'" in fault(path)


@pytest.mark.parametrize("content", [b"", b"raw bytes", b"\x93NUMPY\x09\x00" + b"\0" * 40])
@pytest.mark.parametrize("name", ["a", "a.npy"])
def test_members_that_are_no_arrays(tmp_path: Path, name: str, content: bytes) -> None:
    assert "no array of numpy's" in fault(archive(tmp_path / "a.npz", {name: content}))


def test_more_and_fewer_numbers_than_the_shape_says(tmp_path: Path) -> None:
    for count in (1, 3):
        content = npy(described("'<f8'", "(2,)"), b"\0" * 8 * count)
        assert "bytes for 2 of float64" in fault(archive(tmp_path / "a.npz", {"a.npy": content}))


def test_what_is_no_text_or_no_truth_value(tmp_path: Path) -> None:
    for code in (0x110000, 0xD800, 0xFFFFFFFF):
        content = npy(described("'<U2'", "(1,)"), struct.pack("<II", 65, code))
        assert "no text" in fault(archive(tmp_path / "a.npz", {"a.npy": content}))
    content = npy(described("'|b1'", "(2,)"), b"\x01\x07")
    assert "neither true nor false" in fault(archive(tmp_path / "a.npz", {"a.npy": content}))


def bomb(path: Path, megabytes: int) -> Path:
    """A small file whose array "a" is large."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file, file.open("a.npy", "w") as member:
        member.write(npy(described("'|u1'", f"({megabytes << 20},)")))
        for _ in range(megabytes):
            member.write(bytes(1 << 20))
    return path


def test_a_small_file_does_not_become_large(tmp_path: Path) -> None:
    path = bomb(tmp_path / "a.npz", 80)
    assert path.stat().st_size < 200_000
    assert "far too much for its size" in fault(path)


def test_arrays_that_nobody_asks_for_are_not_read(tmp_path: Path) -> None:
    path = bomb(tmp_path / "a.npz", 60)
    with zipfile.ZipFile(path, "a") as file:
        file.writestr("b.npy", npy(described("'<f8'", "()"), struct.pack("<d", 2.5)))
        file.writestr("c.npy", b"no array")
    tracemalloc.start()
    try:
        with open_npz(path) as arrays:
            assert arrays["b"] == 2.5 and set(arrays) == {"a", "b", "c"}
        assert tracemalloc.get_traced_memory()[1] < GROWTH
    finally:
        tracemalloc.stop()


def test_many_arrays_share_one_budget(tmp_path: Path) -> None:
    content = npy(described("'|u1'", f"({1 << 24},)"), bytes(1 << 24))
    path = archive(tmp_path / "a.npz", {f"{i}.npy": content for i in range(5)}, zipfile.ZIP_DEFLATED)
    assert "far too much for its size" in fault(path)


def test_a_reader_may_bound_an_array_by_itself(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", a=np.zeros((10, 3)))
    assert "too large" in fault(tmp_path / "a.npz", most=29)
    with open_npz(tmp_path / "a.npz") as arrays:
        assert arrays.read("a", 30).shape == (10, 3)


def test_a_name_twice(tmp_path: Path) -> None:
    content = npy(described("'<f8'", "()"), bytes(8))
    assert "twice" in fault(archive(tmp_path / "a.npz", {"a.npy": content, "a": content}))


@pytest.mark.parametrize("method", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_packings_that_numpy_does_not_write(tmp_path: Path, method: int) -> None:
    content = npy(described("'<f8'", "()"), bytes(8))
    assert "packed" in fault(archive(tmp_path / "a.npz", {"a.npy": content}, method))


def test_a_directory_of_very_many_members(tmp_path: Path) -> None:
    path = archive(tmp_path / "a.npz", {f"{i}": b"" for i in range(21_000)})
    assert "far too many" in fault(path)


@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_any_damage_is_a_fault_or_does_no_harm(tmp_path: Path, data: Any) -> None:
    arrays = {"x": np.arange(7.0), "name": np.array(["left", "right"])}
    file = io.BytesIO()
    write_npz(file, arrays, compressed=data.draw(st.booleans()))
    content = bytearray(file.getvalue())
    for _ in range(data.draw(st.integers(1, 3))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    (tmp_path / "a.npz").write_bytes(content)
    try:
        with open_npz(tmp_path / "a.npz") as found:
            for name in set(found) & set(arrays):
                np.testing.assert_array_equal(found[name], arrays[name])
    except (FaultError, InputError):
        pass

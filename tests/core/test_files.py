from __future__ import annotations

import hashlib
from pathlib import Path

import pytest
from footwork.core.errors import InputError
from footwork.core.files import remove_parts, sha256_of, write_atomically, write_together


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_writes_and_replaces(tmp_path: Path) -> None:
    target = tmp_path / "a.bin"
    write_atomically(target, lambda file: file.write(b"one"))
    write_atomically(str(target), lambda file: file.write(b"two"))
    assert target.read_bytes() == b"two"
    assert names(tmp_path) == ["a.bin"]


def test_new_file_has_ordinary_rights(tmp_path: Path) -> None:
    (tmp_path / "plain").write_bytes(b"")
    write_atomically(tmp_path / "ours", lambda file: file.write(b""))
    assert (tmp_path / "ours").stat().st_mode == (tmp_path / "plain").stat().st_mode


@pytest.mark.parametrize("fault", [ValueError("ours"), OSError(28, "No space left on device")])
def test_failure_keeps_the_old_file_and_leaves_nothing(tmp_path: Path, fault: Exception) -> None:
    target = tmp_path / "a.bin"
    target.write_bytes(b"old")

    def fail(file: object) -> None:
        raise fault

    expected = InputError if isinstance(fault, OSError) else ValueError
    with pytest.raises(expected) as caught:
        write_atomically(target, fail)
    assert target.read_bytes() == b"old"
    assert names(tmp_path) == ["a.bin"]
    if expected is InputError:
        assert "No space left" in str(caught.value)


def test_follows_links(tmp_path: Path) -> None:
    real = tmp_path / "real.bin"
    real.write_bytes(b"old")
    (tmp_path / "link.bin").symlink_to(real)
    write_atomically(tmp_path / "link.bin", lambda file: file.write(b"new"))
    assert real.read_bytes() == b"new"
    assert (tmp_path / "link.bin").is_symlink()


def test_faults_are_one_line(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_bytes(b"")
    for path, word in [
        (tmp_path / "none" / "a.bin", "there is no folder"),
        (tmp_path / "folder", "is a folder"),
        (tmp_path / "file" / "a.bin", "there is no folder"),
        (tmp_path / ("x" * 300), "cannot be written"),
        (Path("/proc/a.bin"), "cannot be written"),
    ]:
        with pytest.raises(InputError) as caught:
            write_atomically(path, lambda file: file.write(b"x"))
        assert word in str(caught.value)
        assert str(path)[:100] in str(caught.value)
        assert "\n" not in str(caught.value)


def test_what_a_killed_process_left_is_removed_and_nothing_else(tmp_path: Path) -> None:
    kept = ["a.npz", ".a.npz.b.12.part", ".b.npz.12.part", ".a.npz.part"]
    for name in [*kept, ".a.npz.12.part", ".a.npz.7.part"]:
        (tmp_path / name).touch()
    remove_parts(tmp_path / "a.npz")
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(kept)


def test_sha256(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"abc" * 100_000)
    assert sha256_of(tmp_path / "a") == hashlib.sha256(b"abc" * 100_000).hexdigest()
    with pytest.raises(InputError, match="cannot be read"):
        sha256_of(tmp_path / "missing")
    with pytest.raises(InputError, match="cannot be read"):
        sha256_of(tmp_path)


def test_files_written_together_are_all_there_or_none(tmp_path: Path) -> None:
    def write(path: Path) -> None:
        path.write_text(path.name)

    def cancel(path: Path) -> None:
        path.write_text("half")
        raise KeyboardInterrupt

    (tmp_path / "sub").mkdir()
    (tmp_path / "a").write_text("old")
    with pytest.raises(KeyboardInterrupt):
        write_together({tmp_path / "a": write, tmp_path / "sub" / "b": write, tmp_path / "c": cancel})
    assert (tmp_path / "a").read_text() == "old"
    assert names(tmp_path) == ["a", "sub"] and names(tmp_path / "sub") == []
    with pytest.raises(InputError, match="no folder"):
        write_together({tmp_path / "a": write, tmp_path / "none" / "b": write})
    assert names(tmp_path) == ["a", "sub"]
    write_together({tmp_path / "a": write, tmp_path / "sub" / "b": write})
    assert (tmp_path / "a").read_text() == "a" and (tmp_path / "sub" / "b").read_text() == "b"
    assert names(tmp_path) == ["a", "sub"]

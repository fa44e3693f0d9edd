from __future__ import annotations

import hashlib
from pathlib import Path

import pytest
from footwork.core.errors import InputError
from footwork.core.files import check_target, followed, sha256_of


def test_a_target_is_looked_at_before_it_is_written(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_bytes(b"")
    (tmp_path / "circle").symlink_to(tmp_path / "ring")
    (tmp_path / "ring").symlink_to(tmp_path / "circle")
    for path, word in [
        (tmp_path / "none" / "a.bin", "there is no folder"),
        (tmp_path / "folder", "is a folder"),
        (tmp_path / "file" / "a.bin", "there is no folder"),
        (tmp_path / ("x" * 300), "cannot be written"),
        (tmp_path / "circle", "leads back to itself"),
        (tmp_path / "circle" / "a.bin", "leads back to itself"),
        (Path("/proc/a.bin"), "cannot be written"),
        (Path("/dev/null"), "no ordinary file"),
    ]:
        with pytest.raises(InputError) as caught:
            check_target(path)
        assert word in str(caught.value)
        assert str(path)[:100] in str(caught.value)
        assert "\n" not in str(caught.value)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["circle", "file", "folder", "ring"]


def test_links_are_followed_to_files_that_are_not_there_yet(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(tmp_path / "sub" / "file")
    (tmp_path / "sub").mkdir()
    assert followed(tmp_path / "link") == check_target(tmp_path / "link") == tmp_path / "sub" / "file"


def test_sha256(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"abc" * 100_000)
    assert sha256_of(tmp_path / "a") == hashlib.sha256(b"abc" * 100_000).hexdigest()
    with pytest.raises(InputError, match="cannot be read"):
        sha256_of(tmp_path / "missing")
    with pytest.raises(InputError, match="cannot be read"):
        sha256_of(tmp_path)

"""Starter databases: made on first use, kept, and made again only where they must be."""

from __future__ import annotations

import errno
import itertools
import os
from collections.abc import Generator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from footwork.core.database.motion_database import MotionDatabase
from footwork.core.database.sidecar import load_database, save_database
from footwork.core.errors import InputError
from footwork.core.jobs import run
from footwork.nn.motion import starter
from footwork.nn.motion.starter import RECIPES, starter_databases


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("kept") / "starter"
    heard: list[float] = []
    paths, _, notes = run(starter_databases(folder), lambda fraction, _: heard.append(fraction))
    assert [path.parent for path in paths] == [folder] * len(RECIPES)
    assert notes == []
    assert heard == sorted(heard)
    assert len(heard) > 10
    return folder


def times(folder: Path) -> dict[str, int]:
    return {path.name: path.stat().st_mtime_ns for path in folder.iterdir()}


def test_ranges_of_height_leave_no_gap_and_one_body_has_them_all(folder: Path) -> None:
    databases = sorted(
        (load_database(folder / f"{recipe.name}.npz") for recipe in RECIPES), key=lambda d: d.height_range
    )
    ends = [database.height_range for database in databases]
    assert ends[0][0] == 0.0
    assert ends[-1][1] == 2.0
    assert all(a[1] == b[0] for a, b in itertools.pairwise(ends))
    for database in databases[1:]:
        assert np.array_equal(database.skeleton.offsets, databases[0].skeleton.offsets)


def test_heads_are_as_high_as_their_ranges(folder: Path) -> None:
    from footwork.core.body.forward_kinematics import forward

    shares: dict[str, float] = {}
    for recipe in RECIPES:
        database = load_database(folder / f"{recipe.name}.npz")
        hips = database.poses.hips_positions
        positions, _ = forward(
            hips, database.poses.rotations, database.skeleton.offsets, database.skeleton.parents
        )
        head = positions[:, database.skeleton.joint("head"), 2]
        shares[recipe.name] = float(np.median(head)) / starter_standing(folder)
    for recipe in RECIPES:
        low, high = recipe.height_range
        assert low - 0.02 <= shares[recipe.name] <= high, shares


def starter_standing(folder: Path) -> float:
    return load_database(folder / "starter_upright.npz").head_height


def test_a_second_use_makes_nothing(folder: Path) -> None:
    before = times(folder)
    assert list(starter_databases(folder)) == []
    assert times(folder) == before


def test_a_damaged_file_is_made_again_as_it_was_and_nothing_else_is_touched(folder: Path) -> None:
    own, path = folder / "mine.txt", folder / "starter_crouched.npz"
    own.write_text("mine")
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    *_, notes = run(starter_databases(folder))
    (line,) = notes
    assert "starter_crouched.npz" in line
    assert "\n" not in line
    assert path.read_bytes() == whole
    assert own.read_text() == "mine"
    own.unlink()


def test_databases_of_another_version_are_made_again(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = folder / "starter_upright.npz"
    database = load_database(path)
    save_database(path, replace(database, tags=("starter", "footwork 0.0.1 0123456789ab")))
    *_, notes = run(starter_databases(folder))
    assert len(notes) == 1
    assert "another version" in notes[0]
    assert load_database(path).tags == database.tags


def test_a_folder_that_cannot_be_made_and_damaged_weights_are_told_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("a file")
    monkeypatch.setattr(starter, "starter_takes", lambda model: iter(()))
    monkeypatch.setattr(starter, "make_databases", lambda takes, tag: iter(()))
    with pytest.raises(InputError, match=r"cannot be kept: .*file is a file") as told:
        run(starter_databases(tmp_path / "file" / "starter"))
    assert len(told.value.lines) == 1
    (tmp_path / "weights.npz").write_bytes(b"PK nothing")
    monkeypatch.setattr(starter, "WEIGHTS", tmp_path / "weights.npz")
    with pytest.raises(InputError, match=r"weights\.npz: is damaged") as told:
        run(starter_databases(tmp_path / "kept"))
    assert len(told.value.lines) == 1
    assert not (tmp_path / "kept").exists()


def test_a_full_disk_is_told_in_one_line_and_leaves_nothing(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    databases = [load_database(folder / f"{recipe.name}.npz") for recipe in RECIPES]

    def made(*_: object) -> Generator[tuple[float, str], None, list[object]]:
        yield 0.5, "making"
        return [*databases]

    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(starter, "starter_takes", made)
    monkeypatch.setattr(starter, "make_databases", made)
    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(InputError, match=r"No space left on device.*FOOTWORK_PRESETS") as told:
        run(starter_databases(tmp_path / "kept"))
    assert len(told.value.lines) == 1
    assert not [path for path in tmp_path.rglob("*") if path.is_file()]


def test_each_file_is_read_once(folder: Path) -> None:
    read: list[str] = []

    def load(path: Path) -> MotionDatabase:
        read.append(path.name)
        return load_database(path)

    _, databases, _ = run(starter_databases(folder, load))
    assert read == [f"{recipe.name}.npz" for recipe in RECIPES]
    assert [database.name for database in databases] == [recipe.name for recipe in RECIPES]

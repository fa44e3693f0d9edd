from __future__ import annotations

import errno
import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from footwork.core import staging
from footwork.core.errors import InputError
from footwork.core.staging import is_staging, recover
from footwork.core.transaction import Transaction, write_atomically

POSIX = pytest.mark.skipif(os.name == "nt", reason="modes, links and signals are those of POSIX")
TARGETS = ("a.txt", "sub/b.txt", "sub/made/deeper/c.txt", "d.txt")
OLD = {"a.txt": "old a", "d.txt": "old d"}

WRITE = """
import os, signal, sys
from pathlib import Path
from footwork.core.transaction import Transaction
folder, at, number, only = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]), sys.argv[4]
count = 0
CHANGES = {"open", "os.mkdir", "os.rename", "os.link", "os.remove", "os.rmdir", "os.chmod", "os.listdir"}

def hook(event, arguments):
    global count
    if event not in CHANGES or str(folder) not in str(arguments[0]):
        return
    if only and event != only:
        return
    count += 1
    if count == at:
        os.kill(os.getpid(), number)

sys.addaudithook(hook)
try:
    with Transaction() as outputs:
        outputs.folder(folder / "sub" / "made" / "deeper")
        for name in sys.argv[5:]:
            outputs.write(folder / name, lambda file, name=name: file.write(f"new {name}".encode()))
except KeyboardInterrupt:
    sys.exit(2)
print(count)
"""


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def tree(folder: Path) -> dict[str, str]:
    """All files by name, but for staging folders."""
    return {
        path.relative_to(folder).as_posix(): path.read_text()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and not any(is_staging(part) for part in path.parts)
    }


def left(folder: Path) -> list[Path]:
    return [path for path in folder.rglob(".*") if is_staging(path.name)]


def put(outputs: Transaction, path: Path, text: str) -> None:
    outputs.write(path, lambda file: file.write(text.encode()))


@pytest.fixture
def place(tmp_path: Path) -> Path:
    (tmp_path / "sub").mkdir()
    for name, text in OLD.items():
        (tmp_path / name).write_text(text)
    return tmp_path


@contextmanager
def umask(mask: int) -> Iterator[None]:
    kept = os.umask(mask)
    try:
        yield
    finally:
        os.umask(kept)


def test_one_file_is_written_and_replaced(tmp_path: Path) -> None:
    target = tmp_path / "a.bin"
    write_atomically(target, lambda file: file.write(b"one"))
    write_atomically(str(target), lambda file: file.write(b"two"))
    assert target.read_bytes() == b"two"
    assert names(tmp_path) == ["a.bin"]


def test_all_files_come_together_at_the_end(place: Path) -> None:
    with Transaction() as outputs:
        outputs.folder(place / "sub" / "made" / "deeper")
        for name in TARGETS:
            put(outputs, place / name, f"new {name}")
            assert tree(place) == OLD
        calls: list[dict[str, str]] = []
        outputs.afterwards(lambda: calls.append(tree(place)))
        assert not outputs.committed
    assert tree(place) == {name: f"new {name}" for name in TARGETS} == calls[0]
    assert outputs.committed and left(place) == []


@pytest.mark.parametrize("fault", [ValueError("ours"), OSError(errno.ENOSPC, "No space left on device")])
def test_a_fault_leaves_everything_as_it_was(place: Path, fault: Exception) -> None:
    def fail(file: object) -> None:
        raise fault

    expected = InputError if isinstance(fault, OSError) else ValueError
    with pytest.raises(expected) as caught, Transaction() as outputs:
        outputs.folder(place / "made")
        put(outputs, place / "a.txt", "new")
        put(outputs, place / "made" / "b.txt", "new")
        outputs.write(place / "d.txt", fail)
    assert tree(place) == OLD and names(place) == ["a.txt", "d.txt", "sub"]
    if expected is InputError:
        assert str(caught.value).startswith(f"{place / 'd.txt'}: cannot be written (No space left on device)")


@pytest.mark.parametrize("at", range(1, 6))
def test_a_rename_that_fails_undoes_those_before_it(
    place: Path, monkeypatch: pytest.MonkeyPatch, at: int
) -> None:
    replace, count = Path.replace, 0

    def failing(path: Path, target: Path) -> Path:
        nonlocal count
        count += 1
        if count == at:
            raise OSError(errno.ENOSPC, "No space left on device")
        return replace(path, target)

    monkeypatch.setattr(Path, "replace", failing)
    with pytest.raises(InputError, match="No space left"), Transaction() as outputs:
        outputs.folder(place / "sub" / "made" / "deeper")
        for name in TARGETS:
            put(outputs, place / name, f"new {name}")
    assert tree(place) == OLD and left(place) == [] and names(place / "sub") == []


def test_without_hard_links_the_older_file_is_set_aside(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise OSError(errno.EPERM, "Operation not permitted")

    monkeypatch.setattr(os, "link", refuse)
    with Transaction() as outputs:
        put(outputs, place / "a.txt", "new")
    assert (place / "a.txt").read_text() == "new"
    with pytest.raises(InputError, match="directory"), Transaction() as outputs:
        put(outputs, place / "a.txt", "newer")
        put(outputs, place / "e.txt", "newer")
        (place / "e.txt").mkdir()
    assert (place / "a.txt").read_text() == "new" and left(place) == []


@POSIX
def test_modes_are_kept_and_new_files_have_the_ordinary_one(tmp_path: Path) -> None:
    with umask(0o027):
        (tmp_path / "plain").touch()
        for name, mode in (("secret", 0o600), ("open", 0o664), ("tool", 0o755)):
            (tmp_path / name).touch(mode=mode)
            (tmp_path / name).chmod(mode)
        with Transaction() as outputs:
            for name in ("secret", "open", "tool", "fresh"):
                put(outputs, tmp_path / name, "x")
            (folder,) = left(tmp_path)
            assert folder.stat().st_mode & 0o777 == 0o700
    modes = {path.name: path.stat().st_mode & 0o777 for path in tmp_path.iterdir()}
    assert modes == {"plain": 0o640, "fresh": 0o640, "secret": 0o600, "open": 0o664, "tool": 0o755}


@POSIX
def test_a_links_target_is_replaced_and_another_name_of_the_file_is_not(tmp_path: Path) -> None:
    (tmp_path / "far").mkdir()
    real = tmp_path / "far" / "real.txt"
    real.write_text("old")
    os.link(real, tmp_path / "other name")
    (tmp_path / "link").symlink_to("far/real.txt")
    write_atomically(tmp_path / "link", lambda file: file.write(b"new"))
    assert real.read_text() == "new" and (tmp_path / "link").is_symlink()
    assert (tmp_path / "other name").read_text() == "old"
    assert names(tmp_path) == ["far", "link", "other name"] and names(tmp_path / "far") == ["real.txt"]


@pytest.mark.parametrize("name", ["n" * 255, "é" * 127, "a." + "s" * 253, "a\nb", " ", "-", ".x"])
def test_every_name_that_the_file_system_takes_will_do(tmp_path: Path, name: str) -> None:
    for content in (b"one", b"two"):
        write_atomically(tmp_path / name, lambda file, content=content: file.write(content))
    assert (tmp_path / name).read_bytes() == b"two" and names(tmp_path) == [name]


def test_the_new_file_keeps_its_suffix_and_has_a_folder_that_cannot_be_guessed(tmp_path: Path) -> None:
    seen: set[Path] = set()
    for _ in range(3):
        with Transaction() as outputs:
            with outputs.staging(tmp_path / "scene.blend") as new:
                assert new.suffix == ".blend" and not new.exists()
                new.write_text("x")
            seen.add(new.parent)
    assert len(seen) == 3 and all(is_staging(path.name) for path in seen)


def test_a_file_that_no_writer_made_is_a_fault(tmp_path: Path) -> None:
    expected = pytest.raises(InputError, match=r"a\.blend: cannot be written")
    with expected, Transaction() as outputs, outputs.staging(tmp_path / "a.blend"):
        pass
    assert names(tmp_path) == []


def test_inputs_are_never_overwritten(tmp_path: Path) -> None:
    (tmp_path / "takes").mkdir()
    (tmp_path / "in.txt").write_text("in")
    (tmp_path / "link").symlink_to("in.txt")
    (tmp_path / "linked").symlink_to("takes")
    for inputs, output in (
        (["in.txt"], "in.txt"),
        (["in.txt"], "link"),
        (["link"], "in.txt"),
        (["in.txt"], "takes/../in.txt"),
        (["takes"], "takes/new.txt"),
        (["linked"], "takes/new.txt"),
        (["takes"], "linked/new.txt"),
    ):
        outputs = Transaction(tmp_path / name for name in inputs)
        with pytest.raises(InputError, match="one of the files to read"), outputs:
            put(outputs, tmp_path / output, "x")
    assert tree(tmp_path)["in.txt"] == "in" and names(tmp_path / "takes") == []


def test_a_folder_to_be_made_may_not_be_a_file(place: Path) -> None:
    for path in (place / "a.txt", place / "a.txt" / "more"):
        with pytest.raises(InputError, match="is a file; choose another folder"), Transaction() as outputs:
            outputs.folder(path)


def run_killed(folder: Path, at: int, number: int, only: str = "") -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", WRITE, str(folder), str(at), str(number), only, *TARGETS]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)


@POSIX
def test_a_process_killed_at_any_step_leaves_the_old_or_the_new_files(tmp_path: Path) -> None:
    def fresh(number: int) -> Path:
        folder = tmp_path / str(number)
        (folder / "sub").mkdir(parents=True)
        for name, text in OLD.items():
            (folder / name).write_text(text)
        return folder

    steps = int(run_killed(fresh(0), 0, signal.SIGKILL).stdout)
    new = {name: f"new {name}" for name in TARGETS}
    seen: list[bool] = []
    for step in range(1, steps + 1):
        folder = fresh(step)
        assert run_killed(folder, step, signal.SIGKILL).returncode == -signal.SIGKILL
        for parent in (folder, folder / "sub"):
            recover(parent)
        found = tree(folder)
        assert found in (OLD, new), step
        assert left(folder) == [], step
        assert found == new or not (folder / "sub" / "made").exists()
        seen.append(found == new)
    # old until the journal is there, new from then on
    assert seen == sorted(seen) and {*seen} == {False, True}


@POSIX
def test_the_next_run_over_one_of_the_files_ends_what_was_cut_short(place: Path) -> None:
    # killed at the second of its renames into place: the journal's is the first
    assert run_killed(place, 3, signal.SIGKILL, "os.rename").returncode == -signal.SIGKILL
    assert len(left(place)) == 2
    with pytest.raises(InputError, match="files to read"), Transaction([place / "sub" / "b.txt"]) as outputs:
        put(outputs, place / "sub" / "b.txt", "next")
    assert tree(place) == {name: f"new {name}" for name in TARGETS} and left(place) == []


@POSIX
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_waits_for_the_renames(place: Path, number: signal.Signals) -> None:
    command = WRITE.replace("try:\n", "signal.signal(signal.SIGTERM, signal.default_int_handler)\ntry:\n", 1)
    done = subprocess.run(
        [sys.executable, "-c", command, str(place), "3", str(int(number)), "os.rename", *TARGETS],
        timeout=60,
        check=False,
    )
    assert done.returncode == 2
    assert tree(place) == {name: f"new {name}" for name in TARGETS} and left(place) == []


@POSIX
def test_what_cannot_be_completed_is_undone(place: Path) -> None:
    assert run_killed(place, 3, signal.SIGKILL, "os.rename").returncode == -signal.SIGKILL
    (place / "d.txt").unlink()
    (place / "d.txt").mkdir()
    recover(place)
    assert tree(place) == {"a.txt": "old a"} and left(place / "sub") == [] == left(place)


@POSIX
def test_what_can_neither_be_completed_nor_undone_is_told_and_kept(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(path: Path, target: Path) -> Path:
        raise OSError(errno.EROFS, "Read-only file system")

    assert run_killed(place, 3, signal.SIGKILL, "os.rename").returncode == -signal.SIGKILL
    with monkeypatch.context() as patch:
        patch.setattr(Path, "replace", refuse)
        with pytest.raises(InputError, match="neither be completed nor undone"):
            recover(place)
    recover(place)
    assert tree(place) == {name: f"new {name}" for name in TARGETS} and left(place) == []


@POSIX
def test_what_a_living_process_has_is_left_alone(place: Path) -> None:
    with Transaction() as outputs:
        put(outputs, place / "a.txt", "new")
        other = "import sys, pathlib; from footwork.core import staging; staging.recover(pathlib.Path(sys.argv[1]))"
        subprocess.run([sys.executable, "-c", other, str(place)], check=True, timeout=60)
        assert len(left(place)) == 1
    assert (place / "a.txt").read_text() == "new"


@POSIX
def test_folders_that_are_not_ours_are_left_alone(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def plant(name: str, journal: object = None, mode: int = 0o700) -> Path:
        folder = place / name
        folder.mkdir()
        (folder / "new-0").write_text("planted")
        if journal is not None:
            (folder / "journal").write_text(json.dumps(journal))
        folder.chmod(mode)
        return folder

    plant(".footwork-notes")
    plant(".footwork-00000000000000ff", mode=0o777)
    (place / ".footwork-00000000000000aa").symlink_to(place / "sub")
    recover(place)
    assert [path.name for path in left(place)] == [".footwork-00000000000000aa", ".footwork-00000000000000ff"]
    # a journal reaches no further than the folder that it lies in
    far = place / "sub" / "victim"
    far.write_text("safe")
    outside = {"changes": [["new-0", "../../victim", False]], "made": []}
    folder = place / "sub" / "deep"
    folder.mkdir()
    plant("sub/deep/.footwork-00000000000000bb", outside)
    recover(folder)
    assert far.read_text() == "safe" and names(folder) == []
    for content in ("[", "{}", "[" * 100_000, '{"changes": [[1, 2]], "made": []}', '{"changes": 3}'):
        plant("sub/deep/.footwork-00000000000000cc")
        (folder / ".footwork-00000000000000cc" / "journal").write_text(content)
        recover(folder)
        assert names(folder) == []
    monkeypatch.setattr(os, "geteuid", lambda: os.getuid() + 1)
    plant("sub/deep/.footwork-00000000000000dd")
    recover(folder)
    assert names(folder) == [".footwork-00000000000000dd"]


def test_a_file_system_without_locks_will_do(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(staging, "_lock", lambda file: None)
    with Transaction() as outputs:
        put(outputs, place / "a.txt", "new")
        recover(place)
    assert tree(place) == {**OLD, "a.txt": "new"} and left(place) == []

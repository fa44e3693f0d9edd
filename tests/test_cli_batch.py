"""`batch`: worker processes, faults, limits, resuming, and what a signal leaves."""

from __future__ import annotations

import importlib.util
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from footwork.cli import main
from footwork.core.staging import is_staging

COMMON = ("--write", "npz", "--search", "greedy", "--to", "4")


@pytest.fixture(scope="module")
def made(demo: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a database, and another of three recordings and a broken one."""
    folder = tmp_path_factory.mktemp("made")
    assert main(["build-database", str(demo / "walk.bvh"), "-o", str(folder / "db.npz")]) == 0
    (folder / "r" / "sub").mkdir(parents=True)
    for name, take in (("a", "visit"), ("b", "turn"), ("sub/c", "sidestep")):
        out = folder / "r" / f"{name}.csv"
        assert main(["simulate-recording", str(demo / f"{take}.bvh"), "-o", str(out)]) == 0
    return folder


def batch(made: Path, jobs: Path, out: Path, *more: str) -> int:
    words = ["batch", str(jobs), "--database", str(made / "db.npz"), *COMMON, "-o", str(out), *more]
    return main(words)


def files(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def tracks(folder: Path) -> dict[str, bytes]:
    return {name: content for name, content in files(folder).items() if name.endswith(".npz")}


def test_a_bad_recording_stops_no_other_and_tracks_are_those_of_bake(tmp_path: Path, made: Path) -> None:
    jobs = tmp_path / "r"
    shutil.copytree(made / "r", jobs)
    (jobs / "bad.csv").write_text("nothing\n")
    out = tmp_path / "out"
    assert batch(made, jobs, out, "--workers", "2") == 4
    summary = json.loads((out / "summary.json").read_text())
    assert summary["counts"] == {"done": 3, "kept": 0, "failed": 1, "left": 0} and summary["unfinished"] == [
        "bad"
    ]
    assert set(files(out)) == {
        *("a.npz", "a.json", "b.npz", "b.json", "sub/c.npz", "sub/c.json"),
        *("summary.json", "summary.csv", "summary.html"),
    }
    alone = tmp_path / "alone.npz"
    words = ["bake", str(jobs / "a.csv"), "--database", str(made / "db.npz"), *COMMON[2:], "-o", str(alone)]
    assert main(words) == 0
    assert alone.read_bytes() == (out / "a.npz").read_bytes()


def test_resuming_does_only_what_is_missing_or_changed(tmp_path: Path, made: Path) -> None:
    jobs, out = tmp_path / "r", tmp_path / "out"
    shutil.copytree(made / "r", jobs)

    def states(*more: str) -> dict[str, str]:
        assert batch(made, jobs, out, "--workers", "1", "--resume", *more) == 0
        report = json.loads((out / "summary.json").read_text())
        return {row["name"]: row["state"] for row in report["recordings"]}

    assert set(states().values()) == {"done"}
    before = tracks(out)
    assert states() == dict.fromkeys(("a", "b", "sub/c"), "kept")
    (out / "a.npz").unlink()
    assert states() == {"a": "done", "b": "kept", "sub/c": "kept"}
    assert tracks(out) == before
    shutil.copy(jobs / "a.csv", jobs / "b.csv")
    assert states() == {"a": "kept", "b": "done", "sub/c": "kept"}
    assert set(states("--alpha", "0.2").values()) == {"done"}
    assert batch(made, jobs, out, "--alpha", "0.2", "--resume", "--fail-if", "poses_used > 2") == 3
    report = json.loads((out / "summary.json").read_text())
    assert report["counts"]["kept"] == 3 and len(report["failed"]) == 3


def test_rows_say_options_of_their_own(
    tmp_path: Path, made: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = tmp_path / "jobs.csv"
    table.write_text(
        f"recording,output,alpha,arms\n{made / 'r' / 'a.csv'},x/one,0.15,no\n{made / 'r' / 'b.csv'},,,\n"
    )
    assert batch(made, table, tmp_path / "out", "--alpha", "0.4", "--workers", "1") == 0
    one, two = (json.loads((tmp_path / "out" / name).read_text()) for name in ("x/one.json", "b.json"))
    assert [(r["settings"]["alpha"], r["settings"]["arms"]) for r in (one, two)] == [
        (0.15, False),
        (0.4, True),
    ]
    for content, said in (
        ("recording,speed\na.csv,3\n", "line 2: there is no option 'speed'"),
        ("recording,alpha\na.csv,900\n", "line 2: alpha"),
        ("recording,database\na.csv,no.npz\n", "no.npz: no such file"),
    ):
        table.write_text(content)
        assert batch(made, table, tmp_path / "none") == 2
        assert said in capsys.readouterr().err
    assert batch(made, made / "r", made / "r" / "out") == 2
    assert not (tmp_path / "none").exists()


@pytest.mark.skipif(importlib.util.find_spec("bpy") is None, reason="bpy is not installed as a module")
def test_every_kind_of_file_is_written(tmp_path: Path, made: Path) -> None:
    kinds = [word for kind in ("blend", "fbx", "glb", "bvh") for word in ("--write", kind)]
    assert batch(made, made / "r" / "s*" / "*.csv", tmp_path / "out", "--workers", "1", *kinds) == 0
    written = {Path(name).suffix for name in files(tmp_path / "out") if Path(name).stem == "c"}
    assert written == {".blend", ".fbx", ".glb", ".bvh", ".npz", ".json"}


def test_a_recording_that_takes_too_long_has_failed(tmp_path: Path, made: Path) -> None:
    assert batch(made, made / "r", tmp_path / "out", "--workers", "1", "--timeout", "0.001") == 4
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert all("took longer than 0.001 s" in row["error"] for row in summary["recordings"])
    assert not tracks(tmp_path / "out")


@pytest.mark.skipif(os.name == "nt", reason="signals are those of POSIX")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_a_batch_that_is_stopped_goes_on_with_nothing_lost_or_doubled(
    tmp_path: Path, made: Path, number: signal.Signals
) -> None:
    jobs, out = tmp_path / "r", tmp_path / "out"
    jobs.mkdir()
    for i in range(12):
        shutil.copy(made / "r" / "a.csv", jobs / f"{i}.csv")
    words = ["batch", str(jobs), "--database", str(made / "db.npz"), "--write", "npz", "-o", str(out)]
    command = [sys.executable, "-m", "footwork", *words, "--workers", "2"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 120.0
    while len(list(out.glob("*.npz"))) < 3 and process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.01)
    process.send_signal(number)
    said = process.communicate(timeout=120)[1]
    if number != signal.SIGKILL and process.returncode != 0:
        assert process.returncode == 2 and "cancelled" in said, said
        assert not any(is_staging(path.name) for path in out.iterdir())
        stopped = json.loads((out / "summary.json").read_text())
        listed = {row["name"] for row in stopped["recordings"]}
        assert stopped["counts"]["left"] == 12 - len(listed) > 0 and len(listed) >= 1
        assert all((out / f"{name}.npz").exists() for name in listed)
        assert f"stopped: {12 - len(listed)} of 12 recordings are left" in (out / "summary.html").read_text()
    assert main([*words, "--workers", "2", "--resume"]) == 0
    report = json.loads((out / "summary.json").read_text())
    assert report["counts"]["failed"] == 0 and report["counts"]["kept"] >= 1 and report["counts"]["left"] == 0
    assert len(set(tracks(out).values())) == 1 and len(tracks(out)) == 12
    assert len(list(out.glob("*.json"))) == 13

"""`batch --scheduler`: a Dask cluster, a worker that is lost, and what is said where there is none."""

from __future__ import annotations

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

RECORDINGS = 12


@pytest.fixture(scope="module")
def jobs(demo: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a database and, in `r`, copies of a recording."""
    folder = tmp_path_factory.mktemp("jobs")
    assert main(["build-database", str(demo / "walk.bvh"), "-o", str(folder / "db.npz")]) == 0
    (folder / "r").mkdir()
    first = folder / "r" / "0.csv"
    assert main(["simulate-recording", str(demo / "visit.bvh"), "-o", str(first)]) == 0
    for i in range(1, RECORDINGS):
        shutil.copy(first, folder / "r" / f"{i}.csv")
    return folder


def words(jobs: Path, out: Path, *more: str) -> list[str]:
    return [
        *("batch", str(jobs / "r"), "--database", str(jobs / "db.npz"), "--write", "npz"),
        *("--timeout", "120", "-o", str(out), *more),
    ]


def test_without_dask_or_scheduler_one_line_says_so(
    tmp_path: Path, jobs: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert main(words(jobs, tmp_path / "out", "--scheduler", "local")) == 2
    said = capsys.readouterr().err.strip().splitlines()
    assert said == [
        "footwork batch: --scheduler needs Dask: pip install distributed, or leave it out to use this machine alone"
    ]
    assert not (tmp_path / "out").exists()


def test_an_address_where_nobody_answers(
    tmp_path: Path, jobs: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("distributed", reason="Dask is not installed")
    assert main(words(jobs, tmp_path / "out", "--scheduler", "nonsense://x:1")) == 2
    assert "no Dask scheduler answers" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.skipif(os.name == "nt", reason="signals are those of POSIX")
def test_a_lost_worker_costs_nothing(tmp_path: Path, jobs: Path) -> None:
    distributed = pytest.importorskip("distributed", reason="Dask is not installed")
    out, alone = tmp_path / "out", tmp_path / "alone.npz"
    more = {"memory_limit": None, "dashboard_address": None, "silence_logs": 50}
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, **more) as cluster,
        distributed.Client(cluster) as client,
    ):
        victim = sorted(client.run(os.getpid).values())[0]
        command = [sys.executable, "-m", "footwork"]
        command += words(jobs, out, "--scheduler", cluster.scheduler_address)
        process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        deadline = time.monotonic() + 120.0
        while not list(out.glob("*.npz")) and process.poll() is None and time.monotonic() < deadline:
            time.sleep(0.01)
        os.kill(victim, signal.SIGKILL)
        said = process.communicate(timeout=300)[1]
        assert process.returncode == 0, said
        assert victim not in client.run(os.getpid).values()
    report = json.loads((out / "summary.json").read_text())
    assert report["counts"] == {"done": RECORDINGS, "kept": 0, "failed": 0, "left": 0}
    assert sorted(row["name"] for row in report["recordings"]) == sorted(map(str, range(RECORDINGS)))
    assert report["timing"]["workers"] == 2
    bake = ["bake", str(jobs / "r" / "0.csv"), "--database", str(jobs / "db.npz"), "-o", str(alone)]
    assert main(bake) == 0
    assert {path.read_bytes() for path in out.glob("*.npz")} == {alone.read_bytes()}
    assert len(list(out.glob("*.npz"))) == RECORDINGS and len(list(out.glob("*.json"))) == RECORDINGS + 1
    assert not any(is_staging(path.name) for path in out.iterdir())


def test_a_cluster_of_its_own_does_what_the_machine_does(tmp_path: Path, jobs: Path) -> None:
    pytest.importorskip("distributed", reason="Dask is not installed")
    few = tmp_path / "jobs"
    (few / "r").mkdir(parents=True)
    shutil.copy(jobs / "db.npz", few)
    shutil.copy(jobs / "r" / "0.csv", few / "r")
    (few / "r" / "bad.csv").write_text("nothing\n")
    for name, more in (("here", ()), ("dask", ("--scheduler", "local"))):
        command = [sys.executable, "-m", "footwork", *words(few, tmp_path / name, "--workers", "1", *more)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
        assert done.returncode == 4 and done.stderr.count("footwork batch: bad:") == 1, done.stderr
        assert "Traceback" not in done.stderr
    assert (tmp_path / "here" / "0.npz").read_bytes() == (tmp_path / "dask" / "0.npz").read_bytes()

"""Files that are wrong in known ways, through the verbs that read them: code 2, one line, little time and memory."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from footwork.core.database.build import build_database
from footwork.core.database.sidecar import save_database
from footwork.core.jobs import run
from footwork.core.mocap.takes import load_take
from footwork.core.settings import DatabaseSettings

CASES = Path(__file__).parents[2] / "shared" / "cases" / "files"
SECONDS, BYTES = 1.0, 300_000_000

MEASURED = """
import json, os, resource, sys, time
import numpy
import footwork.cli.entry
from footwork.core import pipeline
from footwork.core.database import describe, sidecar
from footwork.core.evaluation import compare
from footwork.core.mocap import takes
from footwork.core.recording import read
from footwork.nn import evaluate, predictor

for arguments in json.loads(sys.argv[1]):
    ours, theirs = os.pipe()
    child = os.fork()
    if child == 0:
        os.dup2(theirs, 2)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        before = resource.getrusage(resource.RUSAGE_SELF)
        code = footwork.cli.entry.main(arguments)
        sys.stderr.flush()
        after = resource.getrusage(resource.RUSAGE_SELF)
        seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        used = (after.ru_maxrss - before.ru_maxrss) * 1024
        os.write(2, b"\\0" + json.dumps([code, seconds, used]).encode())
        os._exit(0)
    os.close(theirs)
    with os.fdopen(ours, "rb") as pipe:
        said, _, figures = pipe.read().decode("utf-8", "replace").rpartition("\\0")
    os.waitpid(child, 0)
    print(json.dumps([said, *json.loads(figures)]))
"""


def verb_of(path: Path, take: Path) -> list[str]:
    """How the command line is brought to read a case, by the beginning of its name."""
    kind = path.name.partition("_")[0]
    verbs = {
        "db": ["database-info", str(path)],
        "pred": ["evaluate-predictor", str(take), "--predictor", str(path)],
        "report": ["compare-reports", str(path), str(path)],
    }
    return verbs.get(kind, ["inspect", str(path)])


def refused(paths: list[Path], take: Path) -> list[str]:
    """What is wrong with how files are refused, a line each."""
    done = subprocess.run(
        [sys.executable, "-c", MEASURED, json.dumps([verb_of(path, take) for path in paths])],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
        env={**os.environ, "OMP_NUM_THREADS": "1"},
    )
    assert done.returncode == 0, done.stderr
    found: list[str] = []
    for path, line in zip(paths, done.stdout.splitlines(), strict=True):
        said, code, seconds, used = json.loads(line)
        # the two reports are the same file and have a fault each
        lines = list(dict.fromkeys(said.splitlines()))
        if code != 2 or len(lines) != 1 or not lines[0].isprintable() or len(lines[0]) > 340:
            found.append(f"{path.name}: code {code}, said {said!r}")
        if seconds > SECONDS or used > BYTES:
            found.append(f"{path.name}: {seconds:.2f} s, {used / 1e6:.0f} MB")
    return found


pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="measures in processes of their own")


def test_the_known_cases(demo: Path) -> None:
    if not CASES.is_dir():
        pytest.skip("no cases beside the project")
    assert refused(sorted(path for path in CASES.iterdir() if path.is_file()), demo / "walk.bvh") == []


def test_a_case_of_each_kind(demo: Path, tmp_path: Path) -> None:
    text = (demo / "walk.bvh").read_text()
    head, _, rows = text.partition("Frame Time: ")
    (tmp_path / "bvh_time.bvh").write_text(f"{head}Frame Time: 1e-310\n{rows.partition(chr(10))[2]}")
    (tmp_path / "bvh_esc\x1b[2J\nname.bvh").write_text("HIERARCHY\nROOT \x1b[31mHips\n{\nMOTION")
    (tmp_path / "aframe_deep.json").write_text('{"poses": 0, "rotation": ' + "[" * 100_000)
    (tmp_path / "layout_deep.json").write_text("[" * 100_000)
    (tmp_path / "csv_version.csv").write_text("# footwork-recording " + "9" * 5000)
    (tmp_path / "bsor_short.bsor").write_bytes(b"\x69\x3d\x2d\x44\x01\x00\xff\xff\xff\x7f")
    (tmp_path / "report_inputs.json").write_text('{"metrics": {"root_error_cm": {"mean": 1.0}}, "inputs": 5}')
    (tmp_path / "report_deep.json").write_text("[" * 100_000)
    np.savez(tmp_path / "pred_text.npz", header=np.frombuffer(b"[" * 9000, np.uint8))
    np.savez(tmp_path / "db_foreign.npz", format=np.array("footwork-motion-database"), schema=np.array(2.5))
    database = run(build_database([load_take(demo / "walk.bvh", 30.0)], DatabaseSettings(fps=30.0), name="w"))
    save_database(tmp_path / "whole.npz", database)
    with np.load(tmp_path / "whole.npz") as arrays:
        np.savez(tmp_path / "db_zero.npz", **{**arrays, "features": arrays["features"] * np.float32(0.0)})
    (tmp_path / "whole.npz").unlink()
    assert refused(sorted(tmp_path.iterdir()), demo / "walk.bvh") == []

"""What stays on the disk when a verb of the command line fails, is full, cancelled or killed."""

from __future__ import annotations

import errno
import importlib.util
import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from footwork.cli import main
from footwork.core.staging import is_staging, recover

if os.name == "nt":
    pytest.skip("signals and full disks are those of POSIX", allow_module_level=True)

WITH_BPY = importlib.util.find_spec("bpy") is not None
CHANGES = {"open", "os.rename", "os.link"}

DRIVER = """
import os, resource, sys
how, at = sys.argv[1], int(sys.argv[2])
count = 0

def hook(event, arguments):
    global count
    if event in {"open", "os.rename", "os.link"} and ".footwork-" in str(arguments[0]):
        count += 1
        if count == at:
            if how.isdigit():
                os.kill(os.getpid(), int(how))
            raise OSError(28, "No space left on device")

sys.addaudithook(hook)
if how == "limit":
    resource.setrlimit(resource.RLIMIT_FSIZE, (at, at))
from footwork.cli import main
code = main(sys.argv[3:])
sys.stdout.flush()
sys.stderr.flush()
os._exit(code)
"""
"""Runs a verb that meets a full disk, a limit of file size or a signal at one of its steps."""

fail_at = [0]
"""Counted down by every step in a staging folder; the step at 1 meets a full disk."""


def _hook(event: str, arguments: tuple[Any, ...]) -> None:
    if fail_at[0] and event in CHANGES and any(map(is_staging, Path(str(arguments[0])).parts)):
        fail_at[0] -= 1
        if fail_at[0] == 0:
            raise OSError(errno.ENOSPC, "No space left on device")


sys.addaudithook(_hook)


@pytest.fixture(scope="module")
def made(demo: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a take, a database, a recording and a report of a bake or evaluation."""
    folder = tmp_path_factory.mktemp("made")
    shutil.copy(demo / "turn.bvh", folder / "take.bvh")
    assert main(["build-database", str(folder / "take.bvh"), "-o", str(folder / "db.npz")]) == 0
    assert main(["simulate-recording", str(folder / "take.bvh"), "-o", str(folder / "r.csv")]) == 0
    metrics = {"metrics": {"root_error_cm": {"mean": 3.0, "std": 1.0, "p95": 5.0, "max": 6.0}}}
    (folder / "report.json").write_text(json.dumps(metrics))
    return folder


QUICK = {
    "inspect": "inspect take.bvh --json out/r.json",
    "build-database": "build-database take.bvh -o out/db.npz --json out/r.json",
    "database-info": "database-info db.npz --json out/r.json",
    "evaluate-predictor": "evaluate-predictor take.bvh --plot out/p.png --json out/r.json",
    "simulate-recording": "simulate-recording take.bvh -o out/r.csv --json out/r.json",
    "compare-reports": "compare-reports report.json report.json --json out/r.json",
    "evaluate": "evaluate take.bvh --database db.npz --true-orientation -o out/new/folder --json out/r.json",
}
BAKE = "bake r.csv --database db.npz --to 1 -o out/b.blend --export out/b.bvh --json out/r.json"


def command(text: str, made: Path, folder: Path) -> list[str]:
    words = [str(made / word) if (made / word).is_file() else word for word in text.split()]
    return [str(folder / word.removeprefix("out/")) if word.startswith("out/") else word for word in words]


def snapshot(folder: Path) -> dict[str, bytes | None]:
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None
        for path in folder.rglob("*")
    }


def fill(text: str, folder: Path) -> None:
    """Older files under the names of all outputs."""
    for word in text.split():
        if word.startswith("out/") and "." in word:
            (folder / word.removeprefix("out/")).write_bytes(b"old " + word.encode())


@pytest.mark.parametrize("verb", QUICK)
def test_a_full_disk_at_any_step_leaves_the_old_files(
    tmp_path: Path, made: Path, verb: str, capsys: pytest.CaptureFixture[str]
) -> None:
    fill(QUICK[verb], tmp_path)
    before = snapshot(tmp_path)
    arguments = command(QUICK[verb], made, tmp_path)
    fail_at[0] = 10_000
    assert main(arguments) == 0
    steps = 10_000 - fail_at[0]
    after = snapshot(tmp_path)
    assert all(after[name] != before[name] for name in before) and steps >= 4
    # slow verbs are not run for each of their many steps
    for step in sorted({1, 2, steps // 3, steps // 2, steps - 1}):
        shutil.rmtree(tmp_path)
        tmp_path.mkdir()
        fill(QUICK[verb], tmp_path)
        capsys.readouterr()
        fail_at[0] = step
        code, lines = main(arguments), capsys.readouterr().err.splitlines()
        fail_at[0] = 0
        if code == 0:  # links are not needed
            assert snapshot(tmp_path).keys() == after.keys()
            continue
        assert code == 2 and snapshot(tmp_path) == before, step
        assert "No space left on device" in lines[-1] and str(tmp_path) in lines[-1]


def run_driver(how: str, at: int, arguments: list[str]) -> subprocess.CompletedProcess[str]:
    driver = [sys.executable, "-c", DRIVER, how, str(at), *arguments]
    return subprocess.run(driver, capture_output=True, text=True, timeout=300, check=False)


@pytest.mark.parametrize(
    ("verb", "number", "steps"),
    [
        ("build-database", signal.SIGKILL, (1, 3, 5, 6, 7)),
        ("build-database", signal.SIGTERM, (1, 5, 7)),
        ("build-database", signal.SIGINT, (5,)),
        ("evaluate", signal.SIGKILL, (5, 14)),
        ("evaluate", signal.SIGTERM, (5, 14)),
    ],
)
def test_a_signal_at_any_step_leaves_the_old_files_or_the_new_ones(
    tmp_path: Path, made: Path, verb: str, number: signal.Signals, steps: tuple[int, ...]
) -> None:
    check_signals(tmp_path, command(QUICK[verb], made, tmp_path), QUICK[verb], number, steps)


@pytest.mark.skipif(not WITH_BPY, reason="bpy is not installed as a module")
def test_a_bake_that_is_killed_or_full_leaves_the_old_files(tmp_path: Path, made: Path) -> None:
    arguments = command(BAKE, made, tmp_path)
    check_signals(tmp_path, arguments, BAKE, signal.SIGKILL, (6, 15))
    check_signals(tmp_path, arguments, BAKE, signal.SIGTERM, (6,))
    before = snapshot(tmp_path)
    plain = [word for word in arguments if word != "--export" and not word.endswith(".bvh")]
    for limit, name, chosen in ((2_000, "b.bvh", arguments), (40_000, "b.blend", plain)):
        done = run_driver("limit", limit, chosen)
        assert done.returncode == 2, done.stderr
        (line,) = [line for line in done.stderr.splitlines() if line.startswith("footwork")]
        assert line.startswith(f"footwork bake: {tmp_path / name}: ") and "free the place" in line
        assert snapshot(tmp_path) == before


TRAIN = "train-predictor take.bvh -o out/p.npz --epochs 1 --keep-worse --json out/r.json"


def test_a_training_that_is_killed_or_full_leaves_the_old_files(
    tmp_path: Path, made: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its checkpoint alone may be there as well, whole: it is what a training goes on from."""
    pytest.importorskip("torch")
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    fill(TRAIN, tmp_path)
    before = snapshot(tmp_path)
    arguments = command(TRAIN, made, tmp_path)
    rounds = [(str(int(number)), at) for number in (signal.SIGKILL, signal.SIGTERM) for at in (3, 8)]
    for how, at in (*rounds, ("full", 8), ("limit", 2_000)):
        done = run_driver(how, at, arguments)
        recover(tmp_path)
        now = snapshot(tmp_path)
        checkpoint = now.pop("p.npz.training", None)
        if done.returncode == 0:
            assert checkpoint is None and all(now[name] != before[name] for name in before)
            shutil.rmtree(tmp_path)
            tmp_path.mkdir()
            fill(TRAIN, tmp_path)
            continue
        assert done.returncode == (-signal.SIGKILL if how == str(int(signal.SIGKILL)) else 2), done.stderr
        assert now == before, (how, at)
        if checkpoint is not None:
            assert main([*arguments, "--resume"]) == 0
            now = snapshot(tmp_path)
            assert sorted(now) == sorted(before) and all(now[name] != before[name] for name in before)
            fill(TRAIN, tmp_path)


def check_signals(
    folder: Path, arguments: list[str], text: str, number: signal.Signals, steps: tuple[int, ...]
) -> None:
    for step in steps:
        shutil.rmtree(folder)
        folder.mkdir()
        fill(text, folder)
        before = snapshot(folder)
        done = run_driver(str(int(number)), step, arguments)
        recover(folder)
        now = snapshot(folder)
        whole = all(now[name] != before[name] for name in before)
        assert whole or now == before, (step, done.stderr)
        if number == signal.SIGKILL:
            assert done.returncode in (0, -signal.SIGKILL)
        else:
            assert done.returncode == (0 if whole else 2), done.stderr
            assert whole or done.stderr.splitlines()[-1].endswith(": cancelled")
        assert not any(is_staging(name) for name in now)


@pytest.mark.parametrize("stream", ["stdout", "stderr"])
def test_a_closed_pipe_loses_no_file(tmp_path: Path, made: Path, stream: str) -> None:
    def run(*more: str) -> int:
        arguments = ["build-database", str(made / "take.bvh"), "-o", str(tmp_path / "db.npz"), *more]
        read, write = os.pipe()
        os.close(read)
        pipes: dict[str, Any] = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE, stream: write}
        done = subprocess.run(
            [sys.executable, "-m", "footwork", *arguments], **pipes, timeout=300, check=False
        )
        os.close(write)
        assert b"Traceback" not in (done.stderr or b"")
        return done.returncode

    for more in ((), ("--json", "-"), ("--json", str(tmp_path / "r.json"))):
        assert run(*more) == 0
        assert (tmp_path / "db.npz").read_bytes() == (made / "db.npz").read_bytes()
        (tmp_path / "db.npz").unlink()
    assert json.loads((tmp_path / "r.json").read_text())["frames"] > 0


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full")
def test_a_report_that_standard_output_cannot_take_leaves_the_old_file(tmp_path: Path, made: Path) -> None:
    (tmp_path / "db.npz").write_bytes(b"old")
    arguments = ["build-database", str(made / "take.bvh"), "-o", str(tmp_path / "db.npz"), "--json", "-"]
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "footwork", *arguments],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            timeout=300,
            check=False,
        )
    assert done.returncode == 2
    assert "standard output: cannot be written (No space left on device)" in done.stderr.splitlines()[-1]
    assert snapshot(tmp_path) == {"db.npz": b"old"}


def test_no_verb_overwrites_an_input(
    tmp_path: Path, made: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(made, tmp_path / "in")
    (tmp_path / "in" / "headset").mkdir()
    shutil.copy(made / "take.bvh", tmp_path / "in" / "p.npz.training")
    monkeypatch.chdir(tmp_path / "in")
    (tmp_path / "folder").symlink_to("in")
    before = snapshot(tmp_path)
    evaluate = "evaluate take.bvh --database db.npz --true-orientation"
    for text in (
        f"{evaluate} -o . --against report.json",
        f"{evaluate} -o ../folder --against ../in/report.json",
        "evaluate take.bvh --database db.npz --predictor headset --train-on report.html -o .",
        "inspect take.bvh --json ../folder/take.bvh",
        "build-database take.bvh --skeleton db.npz -o db.npz",
        "evaluate-predictor take.bvh --predictor p.png --plot p.png",
        "bake r.csv --database db.npz --rig b.blend:Rig -o b.blend",
        "bake r.csv --database db.npz --ground b.blend -o b.blend",
        "bake r.csv --database db.npz -o c.blend --export r.csv",
        "compare-reports report.json report.json --json report.json",
        "train-predictor p.npz.training -o p.npz",
    ):
        assert main(text.split()) == 2, text
        (line,) = capsys.readouterr().err.splitlines()
        assert "is one of the files to read" in line
        assert snapshot(tmp_path) == before


def test_a_figure_may_not_overwrite_an_input_either(
    tmp_path: Path, made: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("matplotlib")
    shutil.copy(made / "report.json", tmp_path / "take.png")
    before = snapshot(tmp_path)
    text = f"evaluate take.bvh --database db.npz --true-orientation -o {tmp_path} --against {tmp_path / 'take.png'}"
    assert main(command(text, made, tmp_path)) == 2
    assert "take.png: is one of the files to read" in capsys.readouterr().err.splitlines()[-1]
    assert snapshot(tmp_path) == before


def test_a_report_with_a_number_that_json_does_not_know_is_our_bug_and_leaves_the_old_files(
    tmp_path: Path, made: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from footwork.core.database import describe

    monkeypatch.setattr(
        describe, "describe_database", lambda database: {"provenance": {"skipped": []}, "x": [float("nan")]}
    )
    fill(QUICK["build-database"], tmp_path)
    before = snapshot(tmp_path)
    arguments = command(QUICK["build-database"], made, tmp_path)
    assert main(arguments) == 1
    assert "x[0] is not finite" in capsys.readouterr().err
    assert snapshot(tmp_path) == before


@pytest.mark.parametrize("verb", ["inspect", "simulate-recording", "build-database", "evaluate"])
def test_no_name_of_a_file_breaks_a_line_or_reaches_the_terminal(
    tmp_path: Path, made: Path, verb: str, capsys: pytest.CaptureFixture[str]
) -> None:
    take = tmp_path / os.fsdecode(b"a\n\x1b[2Jfootwork evaluate: b\xff.bvh")
    shutil.copy(made / "take.bvh", take)
    out = tmp_path / "out"
    out.mkdir()
    arguments = command(QUICK[verb], made, out)
    arguments = [str(take) if word == str(made / "take.bvh") else word for word in arguments]
    assert main(arguments) == 0
    said = capsys.readouterr()
    for line in (*said.out.split("\n"), *said.err.split("\n")):
        assert line.isprintable(), line
    assert not any(line.startswith(("\x1b", "footwork evaluate: b")) for line in said.out.split("\n"))

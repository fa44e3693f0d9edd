"""Training from the panel: which Python does it, its progress, its end, and giving it up."""

from __future__ import annotations

import importlib.util
import json
import os
import sys
import time
from dataclasses import replace
from types import SimpleNamespace

import bpy
import pytest
from footwork.core.errors import InputError
from footwork.core.mocap.answers import NO_ANSWERS
from footwork.nn.settings import TrainSettings
from footwork.nn.weights import read_predictor
from footwork.operators import training
from footwork.operators.predictor import FOOTWORK_OT_train_predictor
from footwork.properties.preferences import ADD_ON

TORCH = importlib.util.find_spec("torch") is not None
needs_torch = pytest.mark.skipif(not TORCH, reason="torch is not installed")
needs_scripts = pytest.mark.skipif(os.name == "nt", reason="stands in for Python by a script")

STAND_IN = """#!{python}
import json, pathlib, sys, time
arguments = sys.argv[1:]
if "-I" in arguments:
    print({lacks!r})
    sys.exit()
for percent, message in ((0, "reading takes"), (40, "loss 0.5000, held out 9.00 degrees, best 9.00"),
                         (90, "loss 0.2500, held out 6.50 degrees, best 6.50")):
    print(f"[{{percent:3d}}%] {{message}}", file=sys.stderr, flush=True)
    time.sleep(0.05)
pathlib.Path(arguments[arguments.index("-o") + 1] + ".arguments").write_text(json.dumps(arguments))
{end}
report = arguments[arguments.index("--json") + 1]
pathlib.Path(report).write_text(json.dumps({{"held_out_error_deg": 6.5, "headset_forward_error_deg": 14.25}}))
"""


@pytest.fixture
def stand_in(tmp_path):
    """Makes a script that behaves like a Python that trains."""

    def make(lacks: str = "", end: str = "") -> str:
        path = tmp_path / "python"
        path.write_text(STAND_IN.format(python=sys.executable, lacks=lacks, end=end))
        path.chmod(0o755)
        training._lacks.cache_clear()
        training._able.clear()
        return str(path)

    return make


@pytest.fixture
def preferences():
    """The add-on's preferences, as they were afterwards."""
    chosen = bpy.context.preferences.addons[ADD_ON].preferences
    yield chosen
    chosen.training_python = ""


@pytest.fixture
def footwork(empty, demo):
    names = [{"name": f"{name}.bvh"} for name in ("walk", "turn", "visit")]
    bpy.ops.footwork.add_takes(directory=str(demo), files=names)
    return empty.footwork


def alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def started(monkeypatch) -> list:
    """The processes that are started from now on."""
    made, real = [], training.subprocess.Popen
    monkeypatch.setattr(
        training.subprocess, "Popen", lambda *args, **options: made.append(real(*args, **options)) or made[-1]
    )
    return made


def test_without_torch_one_line_says_how_to_get_it(footwork, monkeypatch) -> None:
    monkeypatch.setattr(training.importlib.util, "find_spec", lambda name: None)
    missing = training.find_trainer(bpy.context).missing
    assert "pip install torch" in missing and sys.executable in missing and "\n" not in missing
    with pytest.raises(RuntimeError, match="Training needs PyTorch"):
        bpy.ops.footwork.train_predictor()


def test_takes_are_needed(empty) -> None:
    with pytest.raises(RuntimeError, match="Add takes first"):
        bpy.ops.footwork.train_predictor()


@needs_scripts
@pytest.mark.parametrize(
    ("lacks", "says"),
    [
        ("torch", "has no PyTorch; get it with"),
        ("numpy", "has no numpy"),
        ("Python 3.11", "Python 3.11 or newer"),
    ],
)
def test_a_named_python_is_looked_at(preferences, stand_in, lacks: str, says: str) -> None:
    preferences.training_python = stand_in(lacks)
    missing = training.find_trainer(bpy.context).missing
    assert says in missing and str(preferences.training_python) in missing and "\n" not in missing


def test_a_name_that_is_no_python(preferences, tmp_path) -> None:
    preferences.training_python = str(tmp_path / "gone")
    assert "no such file" in training.find_trainer(bpy.context).missing
    (tmp_path / "text").write_text("no program")
    preferences.training_python = str(tmp_path / "text")
    assert "no Python that runs" in training.find_trainer(bpy.context).missing


@needs_scripts
def test_progress_is_told_and_the_result_used(footwork, preferences, stand_in, tmp_path) -> None:
    preferences.training_python = stand_in()
    footwork.train_settings.seed, footwork.train_settings.kind = 7, "causal"
    footwork.train_path = str(tmp_path / "mine.npz")
    footwork.takes[1].use = False
    assert bpy.ops.footwork.train_predictor() == {"FINISHED"}
    assert footwork.predictor == "FILE" and footwork.predictor_path == str(tmp_path / "mine.npz")
    assert footwork.trained == "6.5° mean error on takes held out, the headset's forward 14.2°"
    said = (tmp_path / "mine.npz.arguments").read_text()
    assert '"--seed", "7"' in said and '"--kind", "causal"' in said
    assert "walk.bvh" in said and "turn.bvh" not in said
    # a take's name is never taken for an option
    words = json.loads(said)
    assert all(word.endswith(".bvh") for word in words[words.index("--") + 1 :])
    assert not any(word.endswith(".bvh") for word in words[: words.index("--")])
    told = list(training.train(stand_in(), [("a.bvh", NO_ANSWERS)], tmp_path / "x.npz", TrainSettings()))
    assert (0.9, "loss 0.2500, held out 6.50 degrees, best 6.50") in told
    assert (0.4, "loss 0.5000, held out 9.00 degrees, best 9.00") in told
    assert [fraction for fraction, _ in told] == sorted(fraction for fraction, _ in told)


@needs_scripts
def test_bad_input_of_the_training_is_one_line(footwork, preferences, stand_in, tmp_path) -> None:
    end = 'print("footwork train-predictor: walk.bvh: too short", file=sys.stderr); sys.exit(2)'
    preferences.training_python = stand_in(end=end)
    with pytest.raises(RuntimeError, match=r"Error: walk\.bvh: too short"):
        bpy.ops.footwork.train_predictor(filepath=str(tmp_path / "x.npz"))
    assert footwork.predictor == "SHIPPED" and footwork.trained == ""


@needs_scripts
def test_resume_and_folder_are_looked_at_before(footwork, preferences, stand_in, tmp_path) -> None:
    preferences.training_python = stand_in()
    footwork.train_settings.resume = True
    with pytest.raises(RuntimeError, match="switch Resume off"):
        bpy.ops.footwork.train_predictor(filepath=str(tmp_path / "new.npz"))
    with pytest.raises(RuntimeError, match="no such folder"):
        bpy.ops.footwork.train_predictor(filepath=str(tmp_path / "gone" / "new.npz"))


@needs_scripts
def test_a_checkpoint_is_enough_to_resume(footwork, preferences, stand_in, tmp_path) -> None:
    preferences.training_python = stand_in()
    footwork.train_settings.resume = True
    (tmp_path / "new.npz.training").touch()
    assert bpy.ops.footwork.train_predictor(filepath=str(tmp_path / "new.npz")) == {"FINISHED"}
    assert '"--resume"' in (tmp_path / "new.npz.arguments").read_text()


def test_who_cancels_is_told_what_can_be_gone_on_from(tmp_path) -> None:
    operator = SimpleNamespace(_path=tmp_path / "x.npz")
    told = FOOTWORK_OT_train_predictor.after_cancel
    assert told(operator) == "nothing was changed"
    (tmp_path / "x.npz.training").touch()
    assert told(operator) == "switch Resume on to go on from x.npz.training"


@needs_scripts
def test_giving_up_ends_the_process_and_leaves_nothing(stand_in, tmp_path, monkeypatch) -> None:
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    monkeypatch.setattr(training.tempfile, "tempdir", str(scratch))
    made = started(monkeypatch)
    job = training.train(
        stand_in(end="time.sleep(60)"), [("a.bvh", NO_ANSWERS)], tmp_path / "x.npz", TrainSettings()
    )
    while next(job)[0] < 0.9:
        pass
    assert alive(made[0].pid) and list(scratch.iterdir())
    job.close()
    assert not alive(made[0].pid) and not list(scratch.iterdir()) and not (tmp_path / "x.npz").exists()


@needs_torch
def test_a_predictor_is_trained_and_trained_on_by_a_named_python(footwork, preferences, tmp_path) -> None:
    settings = footwork.train_settings
    settings.epochs, settings.seed, settings.keep_worse = 1, 3, True
    path = tmp_path / "mine.npz"
    assert bpy.ops.footwork.train_predictor(filepath=str(path)) == {"FINISHED"}
    made = read_predictor(path)
    assert made.provenance["settings"]["seed"] == 3 and made.provenance["settings"]["epochs"] == 1
    assert {take["take"] for take in made.provenance["takes"]} == {"walk", "turn", "visit"}
    assert footwork.predictor_path == str(path) and "on takes held out" in footwork.trained
    training._lacks.cache_clear()
    preferences.training_python, settings.resume = sys.executable, True
    assert bpy.ops.footwork.train_predictor(filepath=str(path)) == {"FINISHED"}
    assert read_predictor(path).provenance["settings"]["resume"]


@needs_torch
def test_a_training_given_up_midway_leaves_its_checkpoint(footwork, demo, tmp_path, monkeypatch) -> None:
    made = started(monkeypatch)
    settings = TrainSettings(epochs=10000)
    paths = [str(demo / f"{name}.bvh") for name in ("walk", "turn", "visit")]
    job = training.train(sys.executable, [(path, NO_ANSWERS) for path in paths], tmp_path / "x.npz", settings)
    limit = time.monotonic() + 60
    for _, message in job:
        assert time.monotonic() < limit
        if "degrees" in message:
            break
    job.close()
    assert not alive(made[0].pid) and [path.name for path in tmp_path.iterdir()] == ["x.npz.training"]
    going_on = training.train(
        sys.executable,
        [(path, NO_ANSWERS) for path in paths],
        tmp_path / "x.npz",
        replace(settings, resume=True),
    )
    for _, message in going_on:
        assert time.monotonic() < limit
        if "degrees" in message:
            break
    going_on.close()
    # "step 40 of 530000": the first 20 were not taken again
    assert int(message.split()[1]) > 20


def test_settings_become_flags() -> None:
    assert training.flags_of(TrainSettings()) == []
    flags = training.flags_of(TrainSettings(resume=True, held_out=0.25, kind="paper"))
    assert flags == ["--kind", "paper", "--held-out", "0.25", "--resume"]
    assert training.progress("[  7%] step 3", 0.0, "") == (0.07, "step 3")
    assert training.progress("Warning: x", 0.5, "old") == (0.5, "old")


@needs_scripts
def test_training_faults_say_something(stand_in, tmp_path) -> None:
    job = training.train(stand_in(end="sys.exit(9)"), [], tmp_path / "x.npz", TrainSettings())
    with pytest.raises(InputError, match=r"held out 6\.50|code 9"):
        list(job)

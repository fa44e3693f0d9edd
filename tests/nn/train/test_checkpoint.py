"""Trainings that are cut short go on as if they had not been, and nothing else is gone on with."""

from __future__ import annotations

import importlib.util
import itertools
import json
import pickle
import shutil
import zipfile
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from footwork.core.errors import InputError
from footwork.core.jobs import run
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.take import Take
from footwork.nn.inputs import Scaler
from footwork.nn.network import Network
from footwork.nn.settings import TrainSettings
from footwork.nn.train import fit, learners
from footwork.nn.train import job as training
from footwork.nn.train.checkpoint import (
    Checkpoint,
    Progress,
    checkpoint_path,
    origin_of,
    read_checkpoint,
    write_checkpoint,
)
from footwork.nn.train.job import train_predictor
from footwork.nn.weights import read_predictor

pytestmark = pytest.mark.skipif(importlib.util.find_spec("torch") is None, reason="torch is not installed")

WINDOW = TrainSettings(kind="causal", voters=2, epochs=1, batch=32, patience=4, seed=5, keep_worse=True)
PAPER = TrainSettings(
    kind="paper", iterations=3, epochs=4, batch=64, learning_rate=0.05, seed=5, keep_worse=True
)


@pytest.fixture(scope="module")
def takes() -> list[Take]:
    scripts = ("walk", "turn", "visit")
    return [
        Take(script, f"{script}.bvh", f"{n}" * 64, demo_motion(script, n), {}, ())
        for n, script in enumerate(scripts)
    ]


@pytest.fixture(autouse=True)
def few_measurements(monkeypatch) -> None:
    """So that some yields lie between them."""
    monkeypatch.setattr(fit, "MEASUREMENTS", 6)


def cut_short(job, start: str = "step 40 ") -> None:
    """Cancel at the first message that starts so."""
    for _, said in job:
        if said.startswith(start):
            job.close()
            return
    raise AssertionError("it came to its end")


def trained(path: Path) -> tuple[dict[str, np.ndarray], list]:
    """All that was learnt, and the way there."""
    with np.load(path) as file:
        return {key: file[key] for key in file.files if key != "header"}, read_predictor(path).provenance[
            "losses"
        ]


def assert_same(first: Path, second: Path) -> None:
    (one, way), (other, its_way) = trained(first), trained(second)
    assert one.keys() == other.keys() and way == its_way
    for key in one:
        np.testing.assert_array_equal(one[key], other[key])


@pytest.mark.parametrize("settings", [WINDOW, PAPER], ids=["window", "paper"])
def test_cut_short_and_resumed_is_the_same_to_the_bit(tmp_path, takes, settings) -> None:
    straight, broken, killed = (tmp_path / f"{name}.npz" for name in ("straight", "broken", "killed"))
    going_on = replace(settings, resume=True)
    kept = 0
    for fraction, _ in train_predictor(takes, settings, straight):
        # what a process that is killed leaves, last in the second voter
        if 0.0 < fraction < 0.9:
            shutil.copy(checkpoint_path(straight), checkpoint_path(killed))
            kept += 1
    assert kept > 5 and not checkpoint_path(straight).exists()
    cut_short(train_predictor(takes, settings, broken))
    for fraction in (0.45, 0.8):
        job, done = train_predictor(takes, going_on, broken), 0.0
        while done < fraction:
            done, _ = next(job)
        job.close()
        assert not broken.exists() and checkpoint_path(broken).exists()
    for path in (broken, killed):
        report = run(train_predictor(takes, going_on, path))
        assert report["losses"] == trained(straight)[1]
        assert_same(straight, path)
        assert not checkpoint_path(path).exists()


@pytest.mark.parametrize("best", [0.1 + 0.2, np.inf], ids=["measured", "not yet measured"])
def test_every_part_is_read_as_it_was_written(tmp_path, best: float) -> None:
    rng = np.random.default_rng(0)

    def network() -> Network:
        weights = [rng.normal(size=size).astype(np.float32) for size in ((42, 5), (5, 6), 5, 6)]
        return Network(tuple(weights[:2]), tuple(weights[2:]))

    history = [{"step": 3, "loss": 0.1, "held_out_deg": 1e-17}]
    progress = Progress([network(), network()], history, 7, network(), best, 2, [1 / 3])
    scaler, origin = Scaler(rng.normal(size=42), rng.uniform(1, 2, 42)), origin_of(WINDOW, [], [])
    origin["settings"]["voters"] = 3
    kept = Checkpoint(origin, progress, scaler, network(), network(), {"a": rng.random(3)})
    write_checkpoint(tmp_path / "c", kept)
    read = read_checkpoint(tmp_path / "c", origin)
    for field in ("history", "step", "best_error_deg", "waited", "losses"):
        assert getattr(read.progress, field) == getattr(progress, field)
    pairs = [(read.network, kept.network), (read.start, kept.start), (read.progress.best, progress.best)]
    for one, other in [*pairs, *zip(read.progress.found, progress.found, strict=True)]:
        for x, y in zip((*one.weights, *one.biases), (*other.weights, *other.biases), strict=True):
            np.testing.assert_array_equal(x, y)
    np.testing.assert_array_equal(read.scaler.mean, scaler.mean)
    np.testing.assert_array_equal(read.scaler.deviation, scaler.deviation)
    np.testing.assert_array_equal(read.state["a"], kept.state["a"])


def test_what_began_with_given_weights_goes_on_with_them_for_every_voter(tmp_path, takes) -> None:
    first = tmp_path / "first.npz"
    run(train_predictor(takes, replace(WINDOW, voters=1, seed=9), first))
    straight, broken = tmp_path / "straight.npz", tmp_path / "broken.npz"
    for path in (straight, broken):
        shutil.copy(first, path)
    going_on = replace(WINDOW, resume=True)
    run(train_predictor(takes, going_on, straight))
    cut_short(train_predictor(takes, going_on, broken))
    assert broken.read_bytes() == first.read_bytes()
    # the checkpoint needs the file it began with no more
    broken.unlink()
    run(train_predictor(takes, going_on, broken))
    assert_same(straight, broken)


def test_without_resume_training_starts_anew(tmp_path, takes) -> None:
    one, other = tmp_path / "one.npz", tmp_path / "other.npz"
    run(train_predictor(takes, PAPER, one))
    cut_short(train_predictor(takes, replace(PAPER, seed=6), other))
    run(train_predictor(takes, PAPER, other))
    assert_same(one, other)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one.npz", "other.npz"]


def test_nothing_to_go_on_with_is_said(tmp_path, takes) -> None:
    assert "nor p.npz.training is there" in fault(takes, PAPER, tmp_path / "p.npz")


@pytest.fixture(scope="module")
def left(tmp_path_factory, takes) -> Path:
    """The checkpoint of a paper's training."""
    path = tmp_path_factory.mktemp("left") / "p.npz"
    cut_short(train_predictor(takes, PAPER, path))
    return checkpoint_path(path)


@pytest.fixture
def output(left, tmp_path) -> Path:
    """An output that has only a checkpoint."""
    shutil.copy(left, checkpoint_path(tmp_path / "p.npz"))
    return tmp_path / "p.npz"


def fault(takes, settings, output: Path) -> str:
    """The one line that a resumed training ends with; it leaves everything as it was."""
    before = {path: path.read_bytes() for path in output.parent.iterdir()}
    with pytest.raises(InputError) as caught:
        run(train_predictor(takes, replace(settings, resume=True), output))
    assert {path: path.read_bytes() for path in output.parent.iterdir()} == before
    assert "\n" not in str(caught.value) and str(output) in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"kind": "causal"}, "differs in kind (was paper, now causal); ask"),
        ({"batch": 32, "iterations": 4}, "differs in iterations (was 3, now 4), batch (was 64, now 32); ask"),
        ({"learning_rate": 0.5}, "differs in learning rate (was 0.05, now 0.5); ask"),
        ({"held_out": 0.4}, "differs in held out (was 0.15, now 0.4); ask"),
        ({"seed": 1}, "differs in seed (was 5, now 1); ask"),
    ],
)
def test_other_settings_are_named(output, takes, change, said: str) -> None:
    assert said in fault(takes, replace(PAPER, **change), output)


def test_other_takes_are_named(output, takes) -> None:
    walk, turn, visit = takes
    new = [replace(walk, name=f"new{n}") for n in range(3)]
    for given, said in (
        ([walk, turn], "takes (visit is missing)"),
        ([walk, replace(turn, sha256="f" * 64), visit], "takes (turn has changed)"),
        ([visit, walk, turn], "takes (their order)"),
        ([*takes, *new], "takes (new0 is new, new1 is new, new2 is new);"),
        ([turn, visit, *new], "takes (walk is missing, new0 is new, new1 is new, 1 more)"),
    ):
        assert f"differs in {said}" in fault(given, PAPER, output)
    with pytest.raises(InputError, match=r"held-out takes \(visit is new\)"):
        run(train_predictor(takes, replace(PAPER, resume=True), output, held_out=[visit]))


def test_what_only_says_when_to_stop_may_change(output, takes) -> None:
    run(train_predictor(takes, replace(PAPER, resume=True, voters=2, patience=9, time_limit=200.0), output))
    assert output.exists()


def rewritten(path: Path, **changes) -> None:
    """The checkpoint with other arrays, or without those that are None."""
    with np.load(path) as file:
        arrays = {key: file[key] for key in file.files}
    arrays |= changes
    with path.open("wb") as file:
        np.savez(file, **{key: array for key, array in arrays.items() if array is not None})


DAMAGE = {
    "header": np.frombuffer(b'{"format": "footwork-training", "schema": 1}', np.uint8),
    "mean": np.zeros(3),
    "deviation": np.zeros(42),
    "now_weight_0": np.full((42, 32), np.nan, np.float32),
    "best_bias_1": np.zeros(32),
    "state_order": np.zeros(9, np.int64),
    "state_place": np.array(-1),
    "state_numpy": np.array('{"bit_generator": "PCG64"}'),
    "state_torch": np.zeros(5056, np.uint8),
    "state_exp_avg_0": np.zeros((2, 2), np.float32),
    "state_exp_avg_sq_3": np.array("text"),
    "state_rate": np.zeros(2),
    "state_schedule": np.array(0.5),
    "state_step_0": None,
}


@pytest.mark.parametrize("key", DAMAGE)
def test_damage_is_said_in_one_line(output, takes, key: str) -> None:
    rewritten(checkpoint_path(output), **{key: DAMAGE[key]})
    assert "no complete training to go on with; start anew" in fault(takes, PAPER, output)
    rewritten(checkpoint_path(output), **{key: None})
    assert "no complete training" in fault(takes, PAPER, output)


def test_half_a_file_and_foreign_files_are_said(output, takes) -> None:
    path = checkpoint_path(output)
    data = path.read_bytes()
    for content in (b"", b"text", data[: len(data) // 2], data[:-30]):
        path.write_bytes(content)
        assert "no complete training" in fault(takes, PAPER, output)
    path.unlink()
    path.mkdir()
    with pytest.raises(InputError, match="cannot be read"):
        run(train_predictor(takes, replace(PAPER, resume=True), output))


class Evil:
    """What a pickle could do."""

    def __reduce__(self):
        return Path.touch, (Path("ran"),)


def test_no_pickle_is_ever_opened(output, takes, monkeypatch) -> None:
    monkeypatch.chdir(output.parent)
    path = checkpoint_path(output)
    rewritten(path, state_numpy=np.array([Evil()], dtype=object))
    assert "no complete training" in fault(takes, PAPER, output)
    path.write_bytes(pickle.dumps(Evil()))
    assert "no complete training" in fault(takes, PAPER, output)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("header.npy", pickle.dumps(Evil()))
    assert "no complete training" in fault(takes, PAPER, output)
    assert not Path("ran").exists()


def test_another_version_is_said(output, takes, monkeypatch) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(learners, "PAPER_HIDDEN", (16, 32))
        assert "another version of Footwork" in fault(takes, PAPER, output)
    header = b'{"format": "footwork-training", "schema": 2}'
    rewritten(checkpoint_path(output), header=np.frombuffer(header, np.uint8))
    assert "another version of Footwork" in fault(takes, PAPER, output)


def test_weights_of_another_kind_are_no_start(tmp_path, takes) -> None:
    path = tmp_path / "p.npz"
    run(train_predictor(takes, PAPER, path))
    with pytest.raises(InputError, match="another kind, width or version of network") as caught:
        run(train_predictor(takes, replace(WINDOW, resume=True), path))
    assert "\n" not in str(caught.value)


def test_what_was_no_good_can_be_saved_or_trained_on(tmp_path, takes, monkeypatch) -> None:
    """Each run has the whole time limit, on a clock that ticks when it is looked at."""
    path = tmp_path / "p.npz"
    clock = itertools.count()
    for module in (fit, training):
        monkeypatch.setattr(module, "time", SimpleNamespace(monotonic=lambda: next(clock)))
    monkeypatch.setattr(training, "headset_forward_error_deg", lambda samples: 0.01)
    bad, steps = replace(PAPER, keep_worse=False, time_limit=40.0), [0]
    for resume in (False, True):
        with pytest.raises(InputError, match="with resume and keep-worse"):
            run(train_predictor(takes, replace(bad, resume=resume), path))
        with np.load(checkpoint_path(path)) as file:
            steps.append(json.loads(file["header"].tobytes())["step"])
        assert not path.exists()
    assert 25 < steps[1] < 40 and 25 < steps[2] - steps[1] < 40
    with pytest.raises(InputError, match="keep-worse"):
        run(train_predictor(takes, replace(bad, resume=True, time_limit=1e4), path))
    said = []
    run(train_predictor(takes, replace(PAPER, resume=True), path), lambda _, message: said.append(message))
    # nothing was left to learn
    assert len(said) == 3 and "going on after step" in said[1] and path.exists()
    assert list(tmp_path.iterdir()) == [path]

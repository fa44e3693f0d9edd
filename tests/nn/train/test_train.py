"""Training: torch and numpy agree, takes are never mixed up, and nothing bad is written."""

from __future__ import annotations

import importlib.util
from dataclasses import replace

import numpy as np
import pytest
from footwork.core.database.virtual_root import virtual_root
from footwork.core.errors import InputError
from footwork.core.jobs import run
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.take import Take
from footwork.core.recording.windows import LOOK_AHEAD
from footwork.nn.inputs import INPUTS, headings, sixd_to_yaw, tracker_inputs, turn_sixd, yaw_to_sixd
from footwork.nn.network import Network
from footwork.nn.predictor import run_recurrent
from footwork.nn.settings import TrainSettings
from footwork.nn.train import job as training
from footwork.nn.train.job import train_predictor
from footwork.nn.train.samples import Sample, samples_of
from footwork.nn.weights import read_predictor

needs_torch = pytest.mark.skipif(importlib.util.find_spec("torch") is None, reason="torch is not installed")


def _take(script: str, seed: int) -> Take:
    motion = demo_motion(script, seed)
    return Take(f"{script}{seed}", f"{script}.bvh", "0" * 64, motion, {}, ())


@pytest.fixture(scope="module")
def takes() -> list[Take]:
    return [_take("walk", 0), _take("turn", 1), _take("visit", 2)]


@pytest.fixture(scope="module")
def samples(takes) -> list[Sample]:
    return samples_of(takes)[0]


def test_samples_hold_the_trackers_and_the_true_yaw(takes, samples):
    motion = takes[0].motion
    head = motion.skeleton.joint("head")
    positions, rotations = motion.forward()
    np.testing.assert_allclose(samples[0].positions[:, 0], positions[:, head], atol=1e-9)
    np.testing.assert_allclose(np.abs(np.sum(samples[0].rotations[:, 0] * rotations[:, head], axis=-1)), 1.0)
    np.testing.assert_allclose(samples[0].yaws, virtual_root(motion)[1])
    # people at ease stand a little lower than in T-pose
    assert samples[0].head_height == pytest.approx(motion.skeleton.tpose_positions()[head, 2], rel=0.03)


@needs_torch
def test_numpy_and_torch_forward_agree():
    import torch
    from footwork.nn.train.torch_networks import build_mlp, from_torch, load_weights

    torch.manual_seed(1)
    model = build_mlp(INPUTS, (32, 32), 6)
    x = np.random.default_rng(1).normal(size=(500, INPUTS)).astype(np.float32)
    expected = model(torch.from_numpy(x)).detach().numpy()
    network = from_torch(model)
    np.testing.assert_allclose(network.forward(x), expected, atol=1e-5)
    other = build_mlp(INPUTS, (32, 32), 6)
    load_weights(other, network)
    np.testing.assert_array_equal(other(torch.from_numpy(x)).detach().numpy(), expected)


@needs_torch
def test_r_steps_in_training_are_r_steps_in_use(samples):
    """Fifty predictions unrolled in torch equal the plain loop over the paper's inputs in numpy."""
    import torch
    from footwork.nn.train.paper import RecurrentLearner

    learner = RecurrentLearner(
        samples, iterations=50, hidden=(32, 32), batch=64, learning_rate=3e-4, decay=0.035, seed=3
    )
    predictor, scaler = learner.predictor(), learner.scaler
    sample, first = samples[0], 40
    x = tracker_inputs(sample.positions, sample.rotations, 60.0)
    head = headings(sample.rotations)
    direction = yaw_to_sixd(sample.yaws[first - 1] - head[first - 1])
    for t in range(first, first + 50):
        direction = turn_sixd(direction, head[t - 1] - head[t])
        answer = predictor.networks[0].forward(scaler.apply(np.concatenate([x[t], direction])))
        direction = answer * scaler.deviation[36:] + scaler.mean[36:]
    found = learner.unroll(torch.tensor([first]), learner.truth[[first - 1]]).detach().numpy()[0]
    np.testing.assert_allclose(found * scaler.deviation[36:] + scaler.mean[36:], direction, atol=1e-5)
    # and the loop that users run, begun at the same place, says the same
    rest = np.s_[first - 1 : first + 50]
    start = replace(sample, positions=sample.positions[rest], rotations=sample.rotations[rest])
    assert len(run_recurrent(predictor, start.positions, start.rotations)) == 51


@needs_torch
def test_the_loop_in_use_feeds_back_its_own_answer(samples):
    """A network that copies its previous orientation holds the world direction it was started with."""
    from footwork.nn.inputs import Scaler
    from footwork.nn.weights import Predictor

    big = 10.0
    copy = np.zeros((INPUTS, 12), np.float32)
    copy[36:, :6], copy[36:, 6:] = np.eye(6), -np.eye(6)
    back = np.concatenate([np.eye(6), -np.eye(6)]).astype(np.float32)
    network = Network((copy, back), (np.zeros(12, np.float32), np.zeros(6, np.float32)))
    scaler = Scaler(np.full(INPUTS, 0.2), np.full(INPUTS, big))
    predictor = Predictor("copy", (network,), scaler, None, 0.0, {})
    yaws = run_recurrent(predictor, samples[1].positions, samples[1].rotations, start=0.9)
    np.testing.assert_allclose(yaws, 0.9, atol=1e-3)
    assert np.ptp(headings(samples[1].rotations)) > 1.0
    assert sixd_to_yaw(yaw_to_sixd(0.9)) == pytest.approx(0.9)


@needs_torch
def test_no_stretch_crosses_from_one_take_into_another(samples):
    from footwork.nn.train.paper import RecurrentLearner
    from footwork.nn.train.window import WindowLearner

    settings = {"batch": 64, "learning_rate": 1e-3, "decay": 0.0, "seed": 0}
    recurrent = RecurrentLearner(samples, iterations=50, hidden=(8,), **settings)
    owner = np.repeat(np.arange(len(samples)), [len(s) for s in samples])
    assert np.all(owner[recurrent.starts - 1] == owner[recurrent.starts + 49])
    window = WindowLearner(samples, LOOK_AHEAD, hidden=(8,), steps=10, **settings)
    np.testing.assert_array_equal(owner[window.first], owner)
    np.testing.assert_array_equal(owner[window.last], owner)


@needs_torch
@pytest.mark.parametrize("kind", ["look-ahead", "causal", "paper"])
def test_a_short_training_learns_and_says_what_it_did(tmp_path, takes, kind):
    path = tmp_path / "p.npz"
    settings = TrainSettings(kind=kind, iterations=5, epochs=4 if kind == "paper" else 8, batch=128, seed=7)
    messages: list[tuple[float, str]] = []
    report = run(train_predictor(takes, settings, path), lambda *message: messages.append(message))
    assert report["held_out_error_deg"] < report["headset_forward_error_deg"]
    assert report["losses"][-1]["loss"] < 0.8 * report["losses"][0]["loss"]
    fractions = [fraction for fraction, _ in messages]
    assert fractions == sorted(fractions)
    assert any("held out" in message for _, message in messages)
    predictor = read_predictor(path)
    assert (predictor.name, predictor.causal) == ("p", kind != "look-ahead")
    origin = predictor.provenance
    assert origin["settings"]["seed"] == 7
    for key in ("held_out_error_deg", "headset_forward_error_deg"):
        assert origin[key] == report[key]
    assert [take["take"] for take in origin["takes"]] == [take.name for take in takes]
    assert set(origin["held_out"]) < {take.name for take in takes}


@needs_torch
def test_same_seed_same_weights_and_resuming_goes_on(tmp_path, takes):
    settings = TrainSettings(kind="look-ahead", epochs=2, batch=128, keep_worse=True)
    for name in ("a", "b"):
        run(train_predictor(takes, settings, tmp_path / f"{name}.npz"))
    first, second = (read_predictor(tmp_path / f"{name}.npz").networks[0] for name in ("a", "b"))
    for one, other in zip(first.weights, second.weights, strict=True):
        np.testing.assert_array_equal(one, other)
    before = read_predictor(tmp_path / "a.npz").provenance["losses"][0]["loss"]
    run(train_predictor(takes, replace(settings, resume=True), tmp_path / "a.npz"))
    assert read_predictor(tmp_path / "a.npz").provenance["losses"][0]["loss"] < before


@needs_torch
def test_what_is_worse_than_the_headset_is_not_written(tmp_path, takes, monkeypatch):
    path = tmp_path / "p.npz"
    settings = TrainSettings(kind="paper", iterations=1, epochs=1, batch=4096)
    monkeypatch.setattr(training, "headset_forward_error_deg", lambda samples: 0.01)
    with pytest.raises(InputError, match="keep-worse"):
        run(train_predictor(takes, settings, path))
    assert not path.exists()
    run(train_predictor(takes, replace(settings, keep_worse=True), path))
    assert path.exists()


@needs_torch
def test_a_cancelled_training_writes_only_its_checkpoint(tmp_path, takes):
    job = train_predictor(takes, TrainSettings(epochs=1), tmp_path / "p.npz")
    next(job)
    next(job)
    assert list(tmp_path.iterdir()) == [tmp_path / "p.npz.training"]
    job.close()
    assert list(tmp_path.iterdir()) == [tmp_path / "p.npz.training"]


def test_without_torch_one_line_says_how_to_get_it(tmp_path, takes, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(InputError, match="pip install torch") as caught:
        run(train_predictor(takes, TrainSettings(), tmp_path / "p.npz"))
    assert "\n" not in str(caught.value)


@needs_torch
def test_too_little_to_learn_from_is_said(tmp_path, takes):
    motion = takes[0].motion
    short = replace(motion, positions=motion.positions[:200], rotations=motion.rotations[:200])
    with pytest.raises(InputError, match="ten seconds"):
        run(train_predictor([replace(takes[0], motion=short)], TrainSettings(), tmp_path / "p.npz"))

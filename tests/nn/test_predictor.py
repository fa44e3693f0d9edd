"""Predictors in use: what they must not depend on, and that those which ship do their work."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.errors import InputError
from footwork.core.maths import angles, quat
from footwork.core.measure.measures import yaw_errors
from footwork.core.mocap.demo import demo_motion
from footwork.core.recording.mounts import DEVICE_MOUNTS
from footwork.core.recording.recording import Recording
from footwork.core.recording.resample import resample
from footwork.core.recording.simulate import simulate_recording
from footwork.core.recording.targets import joint_targets, scale
from footwork.nn.inputs import INPUTS, RATE, Scaler
from footwork.nn.network import Network
from footwork.nn.predictor import headset_forward, predict, run_recurrent, shipped_predictors
from footwork.nn.weights import Predictor

SHIPPED = shipped_predictors()
each_shipped = pytest.mark.parametrize("name", SHIPPED)


@pytest.fixture(scope="module")
def body() -> tuple[Recording, np.ndarray]:
    """A demo recording and the body's true yaw."""
    motion = demo_motion("turn", seed=1)
    return simulate_recording(motion, "turn"), quat.heading(motion.rotations[:, 0])


def _turned(recording: Recording, yaw: float) -> Recording:
    turn = quat.from_yaw(yaw)
    return replace(
        recording,
        positions=quat.rotate(turn, recording.positions) + np.array([2.0, -1.0, 0.0]),
        rotations=quat.multiply(turn, recording.rotations),
    )


def test_headset_forward_is_where_the_headset_looks():
    motion = demo_motion("walk", seed=3)
    recording = simulate_recording(motion, "walk", mounts=DEVICE_MOUNTS)
    _, rotations = motion.forward()
    matrix = quat.to_matrix(rotations[:, motion.skeleton.joint("head")])
    expected = np.arctan2(-matrix[:, 0, 1], matrix[:, 1, 1])
    np.testing.assert_allclose(angles.wrap(headset_forward(recording).yaws - expected), 0.0, atol=1e-9)


@each_shipped
def test_turning_and_moving_the_recording_turns_the_answer(name, body):
    recording, _ = body
    before = predict(SHIPPED[name], recording).yaws
    after = predict(SHIPPED[name], _turned(recording, 2.5)).yaws
    np.testing.assert_allclose(angles.wrap(after - before - 2.5), 0.0, atol=2e-3)


@each_shipped
@pytest.mark.parametrize("factor", [0.85, 1.15])
def test_the_size_of_the_body_does_not_matter(name, factor, body):
    recording, _ = body
    before = predict(SHIPPED[name], recording).yaws
    after = predict(SHIPPED[name], scale(recording, factor)).yaws
    assert np.mean(yaw_errors(after, before)) < np.radians(0.5)


@each_shipped
@pytest.mark.parametrize("fps", [72.0, 90.0, 120.0])
def test_the_rate_of_the_recording_does_not_matter(name, fps, body):
    recording, _ = body
    other = resample(recording, fps)
    slow = np.interp(recording.times, other.times, predict(SHIPPED[name], other).yaws)
    assert np.mean(yaw_errors(slow, predict(SHIPPED[name], recording).yaws)) < np.radians(0.5)


@each_shipped
def test_mounts_of_other_devices_do_not_matter(name):
    motion = demo_motion("visit", seed=2)
    one, other = simulate_recording(motion, "a"), simulate_recording(motion, "a", mounts=DEVICE_MOUNTS)
    found = predict(SHIPPED[name], one).yaws, predict(SHIPPED[name], other).yaws
    np.testing.assert_allclose(found[0], found[1], atol=1e-4)


@pytest.mark.parametrize("name", [name for name in SHIPPED if SHIPPED[name].causal])
def test_causal_answers_do_not_change_when_the_future_does(name, body):
    recording, _ = body
    whole = predict(SHIPPED[name], recording).yaws
    half = len(recording) // 2
    cut = replace(
        recording,
        times=recording.times[:half],
        positions=recording.positions[:half],
        rotations=recording.rotations[:half],
        valid=recording.valid[:half],
    )
    np.testing.assert_allclose(predict(SHIPPED[name], cut).yaws, whole[:half], atol=1e-6)


@each_shipped
@pytest.mark.parametrize("lost", [(1,), (2,), (1, 2)])
def test_lost_controllers_leave_a_finite_and_less_certain_answer(name, lost, body):
    recording, truth = body
    valid = recording.valid.copy()
    positions = recording.positions.copy()
    valid[100:, lost] = False
    positions[100:, lost] = positions[100, lost]
    crippled = predict(SHIPPED[name], replace(recording, positions=positions, valid=valid))
    assert np.all(np.isfinite(crippled.yaws))
    assert np.all(np.isfinite(crippled.doubt))
    if SHIPPED[name].layout is not None:
        assert np.mean(crippled.doubt[200:]) > np.mean(predict(SHIPPED[name], recording).doubt[200:])
        assert np.mean(yaw_errors(crippled.yaws, truth)) < np.radians(30.0)


def test_the_papers_network_forgets_a_wrong_start():
    """The only one with a memory; windows hold nothing older than themselves."""
    motion = demo_motion("walk", seed=1)
    recording = resample(simulate_recording(motion, "walk"), RATE)
    positions, rotations = joint_targets(recording)
    right = run_recurrent(SHIPPED["paper"], positions, rotations)
    wrong = run_recurrent(SHIPPED["paper"], positions, rotations, start=right[0] + np.pi)
    apart_deg = np.degrees(yaw_errors(wrong, right))
    assert apart_deg[0] > 20.0
    assert np.max(apart_deg[int(RATE) :]) < 45.0
    assert np.max(apart_deg[int(2 * RATE) :]) < 5.0


def test_two_frames_are_enough(body):
    recording, _ = body
    short = replace(
        recording,
        times=recording.times[:2],
        positions=recording.positions[:2],
        rotations=recording.rotations[:2],
        valid=recording.valid[:2],
    )
    for predictor in SHIPPED.values():
        assert np.all(np.isfinite(predict(predictor, short).yaws))


@each_shipped
def test_shipped_predictors_beat_the_headset_on_real_takes_never_trained_on(name, data):
    from footwork.core.mocap.takes import load_take
    from footwork.nn.evaluate import evaluate_predictors

    files = ["walk1_subject1_walk2", "obstacles2_subject2_walk2", "pushAndStumble1_subject2_run"]
    takes = [load_take(data / "takes" / "lafan1" / f"{file}_filtered.bvh") for file in files]
    assert not {take.name for take in takes} & {t["take"] for t in SHIPPED[name].provenance["takes"]}
    report = evaluate_predictors(takes, {name: SHIPPED[name]})["predictors"]
    assert report[name]["mean"] < report["headset"]["mean"]


@each_shipped
def test_shipped_predictors_name_the_licence_of_every_take(name):
    takes = SHIPPED[name].provenance["takes"]
    assert len(takes) > 10
    for take in takes:
        assert len(take["sha256"]) == 64
        assert take["licence"].startswith(("MIT", "CC BY 4.0", "CMU"))


def test_a_network_that_runs_away_is_told() -> None:
    rng = np.random.default_rng(2)
    sizes = ((INPUTS, 8), (8, 6))
    network = Network(
        tuple(rng.normal(size=size).astype(np.float32) * 100.0 for size in sizes),
        tuple(rng.normal(size=size[1]).astype(np.float32) for size in sizes),
    )
    wild = Predictor("wild", (network,), Scaler(np.zeros(INPUTS), np.ones(INPUTS)), None, 0.1, {})
    recording = simulate_recording(demo_motion("walk"), "walk")
    with (
        np.errstate(all="ignore"),
        pytest.raises(InputError, match="predictor wild: its answers are not finite"),
    ):
        predict(wild, recording)

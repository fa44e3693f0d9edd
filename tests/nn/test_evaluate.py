"""Errors of predictors: figures against closed forms, and the report's shape."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from footwork.core.body.motion import Motion
from footwork.core.maths import quat
from footwork.core.measure.measures import yaw_errors
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.take import Take
from footwork.core.recording.simulate import simulate_recording
from footwork.nn.evaluate import errors_in_words, evaluate_predictors, hands_and_head, summary_deg
from footwork.nn.predictor import shipped_predictors


def test_summary_by_minute():
    errors = np.concatenate([np.full(600, 2.0), np.full(600, 8.0), np.full(300, 5.0)])
    found = summary_deg(np.radians(errors), 10.0)
    assert found["per_minute"] == pytest.approx([2.0, 8.0, 5.0])
    assert found["mean"] == pytest.approx(5.0)
    assert found["std"] == pytest.approx(np.sqrt((600 * 9 + 600 * 9) / 1500))
    assert found["p95"] == pytest.approx(8.0)


def looking_aside(motion: Motion) -> np.ndarray:
    """Degrees between the ways that head and hips face."""
    _, rotations = motion.forward()
    aside = quat.heading(rotations[:, motion.skeleton.joint("head")]) - quat.heading(rotations[:, 0])
    return np.degrees(np.abs((aside + np.pi) % (2 * np.pi) - np.pi))


def test_pooled_takes_follow_one_another_a_second_counting_the_same():
    motions = [demo_motion(script, seed) for seed, script in enumerate(("visit", "walk", "visit", "turn"))]
    motions[1] = replace(motions[1], fps=motions[1].fps / 2)
    takes = [Take(f"{i}", f"{i}.bvh", "0" * 64, motion, {}, ()) for i, motion in enumerate(motions)]
    row = evaluate_predictors(takes, {})["predictors"]["headset"]
    errors = np.concatenate([looking_aside(motion)[:: round(motion.fps / 30)] for motion in motions])
    assert len(errors) > 1800
    parts = np.split(errors, np.arange(1800, len(errors), 1800))
    assert row["per_minute"] == pytest.approx([part.mean() for part in parts])
    assert row["mean"] == pytest.approx(errors.mean())
    assert row["percentiles"][0] == pytest.approx(errors.min())
    assert row["percentiles"][50] == pytest.approx(np.median(errors))
    assert row["percentiles"][95] == pytest.approx(row["p95"])
    assert row["percentiles"][100] == pytest.approx(errors.max())


def test_report_of_a_take():
    motion = demo_motion("turn", seed=4)
    take = Take("turn", "turn.bvh", "0" * 64, motion, {}, ())
    predictors = shipped_predictors()
    report = json.loads(json.dumps(evaluate_predictors([take], predictors)))
    assert list(report["predictors"]) == ["headset", "hands-and-head", *predictors]
    for name, row in report["predictors"].items():
        assert set(row) == {"mean", "std", "p95", "per_minute", "percentiles", "causal", "doubt", "parts"}
        assert row["causal"] is (name != "look-ahead")
    found = report["takes"][0]["predictors"]["headset"]["mean"]
    assert found == pytest.approx(looking_aside(motion).mean())
    words = "\n".join(errors_in_words(report))
    assert "headset" in words
    assert f"{report['predictors']['causal']['mean']:.2f}" in words


def test_the_heuristic_is_square_to_the_hands_of_a_body_at_ease():
    motion = demo_motion("turn", seed=4)
    recording = simulate_recording(motion, "turn")
    turned = quat.multiply(quat.from_yaw(0.5), recording.rotations[:, 0])
    recording.rotations[:, 0] = turned
    found, truth = hands_and_head(recording).yaws, quat.heading(motion.rotations[:, 0])
    assert np.mean(yaw_errors(found, truth)) < np.mean(yaw_errors(quat.heading(turned), truth))


def test_predictors_are_less_sure_and_err_more_without_controllers():
    takes = [
        Take(name, f"{name}.bvh", "0" * 64, demo_motion(name, seed=6), {}, ())
        for name in ("walk", "turn", "visit")
    ]
    predictors = {name: shipped_predictors()[name] for name in ("causal", "look-ahead")}
    rows = [
        evaluate_predictors(takes, predictors, lost)["predictors"]
        for lost in ((), ("left",), ("left", "right"))
    ]
    for name in predictors:
        assert rows[0][name]["doubt"] < rows[2][name]["doubt"]
        assert rows[0][name]["mean"] < rows[1][name]["mean"] < rows[2][name]["mean"]
    # the headset is there all the same, and has no notion of doubt
    assert len({row["headset"]["mean"] for row in rows}) == 1 and rows[0]["headset"]["doubt"] is None

"""Errors of predictors: figures against closed forms, and the report's shape."""

from __future__ import annotations

import json

import numpy as np
import pytest
from footwork.core.maths import quat
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.skeleton import Take
from footwork.core.recording.simulate import simulate_recording
from footwork.nn.evaluate import errors_in_words, evaluate_predictors, hands_and_head, summary, yaw_errors
from footwork.nn.predictor import shipped_predictors


def test_errors_are_the_short_way_round():
    np.testing.assert_allclose(
        yaw_errors(np.radians([179.0, 10.0, 370.0]), np.radians([-179.0, 40.0, 5.0])), [2, 30, 5]
    )


def test_summary_by_minute():
    errors = np.concatenate([np.full(600, 2.0), np.full(600, 8.0), np.full(300, 5.0)])
    found = summary(errors, 10.0)
    assert found["per_minute"] == [2.0, 8.0, 5.0]
    assert found["mean"] == pytest.approx(5.0)
    assert found["std"] == pytest.approx(np.sqrt((600 * 9 + 600 * 9) / 1500))
    assert found["p95"] == 8.0


def test_report_of_a_take():
    motion = demo_motion("turn", seed=4)
    take = Take("turn", "turn.bvh", "0" * 64, motion, {}, ())
    predictors = shipped_predictors()
    report = json.loads(json.dumps(evaluate_predictors([take], predictors)))
    assert list(report["predictors"]) == ["hmd-forward", "hands-and-head", *predictors]
    for name, row in report["predictors"].items():
        assert set(row) == {"mean", "std", "p95", "causal"}
        assert row["causal"] is (name != "look-ahead")
    _, rotations = motion.forward()
    aside = quat.heading(rotations[:, motion.skeleton.joint("head")]) - quat.heading(rotations[:, 0])
    expected = np.degrees(np.abs((aside + np.pi) % (2 * np.pi) - np.pi))
    assert report["takes"][0]["predictors"]["hmd-forward"]["mean"] == pytest.approx(expected.mean())
    words = errors_in_words(report)
    assert "hmd-forward" in words
    assert f"{report['predictors']['causal']['mean']:.2f}" in words


def test_the_heuristic_is_square_to_the_hands_of_a_body_at_ease():
    motion = demo_motion("turn", seed=4)
    recording = simulate_recording(motion, "turn")
    turned = quat.multiply(quat.from_yaw(0.5), recording.rotations[:, 0])
    recording.rotations[:, 0] = turned
    found, truth = hands_and_head(recording), quat.heading(motion.rotations[:, 0])
    assert np.mean(yaw_errors(found, truth)) < np.mean(yaw_errors(quat.heading(turned), truth))

"""Errors of the parts of an estimate that is wrong by known amounts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.body.edit import cut
from footwork.core.body.standing import standing_head_height
from footwork.core.evaluation.true_estimate import true_estimate
from footwork.core.mocap.demo import demo_motion
from footwork.core.recording.body_estimate import BodyEstimate, Part
from footwork.nn.part_errors import PARTS, part_errors, pooled
from scipy.spatial.transform import Rotation

USER = cut(demo_motion("visit", 3, 30.0), 20, 200)
SIZE = standing_head_height(USER)
TRUTH = true_estimate(USER, SIZE)


def test_the_truth_has_none() -> None:
    found = pooled([part_errors(TRUTH, TRUTH, SIZE)])
    assert found.keys() == PARTS.keys() and found["within"] == 1.0
    assert max(value for name, value in found.items() if name != "within") < 1e-4
    empty = part_errors(BodyEstimate(TRUTH.yaws), TRUTH, SIZE)
    assert empty == {} and set(pooled([empty]).values()) == {None}


def test_known_shifts_and_turns_come_out() -> None:
    shift = np.array([0.03, -0.02, 0.06]) / SIZE
    turn = Rotation.from_rotvec([0.2, -0.1, 0.15])
    chest = (Rotation.from_rotvec(TRUTH.chest.mean) * turn).as_rotvec()
    lean = Rotation.from_rotvec([0.0, 0.0, 0.4])
    elbows = lean.apply(TRUTH.elbows.mean.reshape(-1, 3)).reshape(TRUTH.elbows.mean.shape)
    standing = TRUTH.standing.copy()
    standing[::4, 0] = 1.0 - standing[::4, 0]
    wrong = replace(
        TRUTH,
        hips=Part(TRUTH.hips.mean + shift, np.full(len(USER), 0.04 / SIZE)),
        feet=Part(TRUTH.feet.mean - 2.0 * shift, np.full(TRUTH.feet.spread.shape, 0.05 / SIZE)),
        chest=Part(chest, TRUTH.chest.spread),
        elbows=Part(elbows, TRUTH.elbows.spread),
        standing=standing,
    )
    found = pooled([part_errors(wrong, TRUTH, SIZE)])
    assert found["hips_cm"] == pytest.approx(7.0)
    assert found["ankles_cm"] == pytest.approx(14.0)
    assert found["standing_wrong"] == pytest.approx(0.125)
    assert found["chest_deg"] == pytest.approx(np.degrees(turn.magnitude()), rel=1e-6)
    level = np.linalg.norm(TRUTH.elbows.mean[..., :2], axis=-1)
    swung = 2.0 * np.arcsin(level * np.sin(0.2))
    assert found["elbows_deg"] == pytest.approx(np.degrees(swung).mean(), rel=1e-6)
    # upwards nothing is within its spread; over the ground by how the body is turned
    yaw = TRUTH.yaws[:, None]
    ground = np.stack(
        [np.cos(yaw) * 0.03 + np.sin(yaw) * 0.02, np.sin(yaw) * 0.03 - np.cos(yaw) * 0.02], axis=-1
    )
    inside = [(np.abs(ground) <= 0.04).mean(), (np.abs(2.0 * ground) <= 0.05).mean()]
    assert found["within"] == pytest.approx((inside[0] * 2 / 3 + 2 * inside[1] * 2 / 3) / 3.0, abs=1e-9)


def test_a_wrong_direction_counts_for_hips_and_ankles() -> None:
    turned = replace(TRUTH, yaws=TRUTH.yaws + 0.5)
    found = part_errors(turned, TRUTH, SIZE)
    away = np.linalg.norm(TRUTH.hips.mean[:, :2], axis=-1) * SIZE * 2.0 * np.sin(0.25) * 100.0
    np.testing.assert_allclose(found["hips_cm"], away, atol=1e-6)
    away = np.linalg.norm(TRUTH.feet.mean[:, :, 0, :2], axis=-1) * SIZE * 2.0 * np.sin(0.25) * 100.0
    np.testing.assert_allclose(found["ankles_cm"], away, atol=1e-6)

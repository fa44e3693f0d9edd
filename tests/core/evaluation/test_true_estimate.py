"""The perfect body estimate puts every part back where the true body has it."""

from __future__ import annotations

import numpy as np
from footwork.core.body.skeleton import SIDES
from footwork.core.body.toes import toe_positions
from footwork.core.evaluation.true_estimate import true_estimate
from footwork.core.mocap.demo import demo_motion
from scipy.spatial.transform import Rotation

HEAD_HEIGHT = 1.55


def test_parts_put_together_are_the_body() -> None:
    motion = demo_motion("visit", 5)
    positions, rotations = motion.forward()
    found = true_estimate(motion, HEAD_HEIGHT)
    joint = motion.skeleton.joint
    assert found.hips and found.feet and found.chest and found.elbows
    body = Rotation.from_euler("z", found.yaws[:, None])

    floor = positions[:, joint("head")] * [1.0, 1.0, 0.0]
    hips = floor + HEAD_HEIGHT * body.apply(found.hips.mean)
    np.testing.assert_allclose(hips, positions[:, 0], atol=1e-9)
    for i, side in enumerate(SIDES):
        ankle, toe = (hips + HEAD_HEIGHT * body.apply(found.feet.mean[:, i, k]) for k in range(2))
        np.testing.assert_allclose(ankle, positions[:, joint(f"foot.{side}")], atol=1e-9)
        np.testing.assert_allclose(toe, toe_positions(motion)[:, i], atol=1e-9)
        forearm = positions[:, joint(f"forearm.{side}")] - positions[:, joint(f"hand.{side}")]
        shown = np.linalg.norm(forearm, axis=-1, keepdims=True) * body.apply(found.elbows.mean[:, i])
        np.testing.assert_allclose(shown, forearm, atol=1e-9)
    chest = body * Rotation.from_rotvec(found.chest.mean)
    true = Rotation.from_quat(rotations[:, joint("chest")], scalar_first=True)
    np.testing.assert_allclose((chest.inv() * true).magnitude(), 0.0, atol=1e-7)


def test_hips_forward_faces_the_body() -> None:
    motion = demo_motion("turn", 2)
    found = true_estimate(motion, HEAD_HEIGHT)
    forward = Rotation.from_quat(motion.rotations[:, 0], scalar_first=True).apply([0.0, 1.0, 0.0])
    true = np.arctan2(-forward[:, 0], forward[:, 1])
    np.testing.assert_allclose(np.angle(np.exp(1j * (found.yaws - true))), 0.0, atol=1e-9)
    assert found.standing is not None and found.doubt is not None
    assert set(np.unique(found.standing)) <= {0.0, 1.0}

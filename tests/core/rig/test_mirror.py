"""Rigs on objects with a negative scale: Blender shows them mirrored, and so they are keyed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.mocap.demo import demo_skeleton
from footwork.core.rig.fit import fit_rig, rig_from_skeleton
from footwork.core.rig.keys import to_bone_tracks
from footwork.core.rig.mirror import unmirrored
from footwork.core.rig.rig import Rig
from scipy.spatial.transform import Rotation

SKELETON = demo_skeleton(1.71)


def mirrored_rig(scale: tuple[float, float, float]) -> Rig:
    """A rig with tilted bones whose object has this scale, a turn and a place."""
    rig = rig_from_skeleton(SKELETON, "rig")
    rest = rig.rest.copy()
    rest[:, :3, :3] = Rotation.random(len(rest), random_state=np.random.default_rng(2)).as_matrix()
    world = np.eye(4)
    world[:3, :3] = Rotation.from_euler("z", 40.0, degrees=True).as_matrix() @ np.diag(scale)
    world[:3, 3] = [1.0, -2.0, 0.0]
    return replace(rig, rest=rest, world=world)


@pytest.mark.parametrize("scale", [(-1.0, 1.0, 1.0), (1.0, -1.0, 1.0), (-0.5, 0.5, 0.5)])
def test_keys_show_the_motion_on_a_mirrored_object(scale, random_pose) -> None:
    rig = mirrored_rig(scale)
    fit = fit_rig(unmirrored(rig))
    # what is named left is seen on the right
    assert fit.skeleton.roles[fit.skeleton.names.index("LeftWrist")] == "hand.R"
    motion = random_pose(fit.skeleton, 3)
    tracks = to_bone_tracks(motion, fit, motion.fps)
    positions, _ = motion.forward()
    for frame in range(3):
        poses: list[np.ndarray] = []
        for name, parent, rest in zip(rig.bones, rig.parents.tolist(), rig.rest, strict=True):
            basis = np.eye(4)
            turn = tracks.rotations[frame, tracks.bones.index(name)]
            basis[:3, :3] = Rotation.from_quat(np.roll(turn, -1)).as_matrix()
            if name == tracks.bones[0]:
                basis[:3, 3] = tracks.locations[frame]
            above = poses[parent] @ np.linalg.inv(rig.rest[parent]) if parent >= 0 else np.eye(4)
            poses.append(above @ rest @ basis)
            shown = (rig.world @ poses[-1])[:3, 3]
            wanted = positions[frame, fit.skeleton.names.index(name)]
            np.testing.assert_allclose(shown, wanted, atol=1e-9)


def test_an_ordinary_rig_stays_as_it_is() -> None:
    rig = replace(mirrored_rig((-1.0, -1.0, 1.0)))
    assert unmirrored(rig) is rig

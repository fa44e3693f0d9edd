"""Mirror images of a body whose sides differ in every length, and of the database that is made of it."""

from __future__ import annotations

import numpy as np
import pytest
from footwork.core.database.build import build_database
from footwork.core.database.contacts import find_contacts, toe_positions
from footwork.core.jobs import run
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.edit import mirror
from footwork.core.mocap.skeleton import Motion, Skeleton, Take
from footwork.core.rig.retarget import retarget
from footwork.core.settings import DatabaseSettings
from scipy.spatial.transform import Rotation

MIRROR = np.diag([-1.0, 1.0, 1.0])


def partner(role: str) -> str:
    """The same joint on the other side."""
    return role[:-1] + {"L": "R", "R": "L"}[role[-1]] if role[-2:-1] == "." else role


def points(motion: Motion, role: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A joint, the end of its bone, and its rotation as matrices."""
    positions, rotations = motion.forward()
    joint = motion.skeleton.joint(role)
    turn = Rotation.from_quat(np.roll(rotations[:, joint], -1, axis=-1))
    return (
        positions[:, joint],
        positions[:, joint] + turn.apply(motion.skeleton.tips[joint]),
        turn.as_matrix(),
    )


@pytest.fixture(scope="module")
def tumbling(unequal, tumble) -> Motion:
    skeleton = unequal()
    hips = np.random.default_rng(7).normal(size=(30, 3))
    return Motion(skeleton, 60.0, hips, tumble(30, 60.0, count=len(skeleton), seed=4))


def test_every_joint_and_every_tip_is_the_reflection_of_its_partner(tumbling: Motion) -> None:
    image = mirror(tumbling)
    for role in tumbling.skeleton.roles:
        place, tip, turn = points(image, role)
        place_before, tip_before, turn_before = points(tumbling, partner(role))
        np.testing.assert_allclose(place, place_before @ MIRROR, atol=1e-12)
        np.testing.assert_allclose(tip, tip_before @ MIRROR, atol=1e-12)
        np.testing.assert_allclose(turn, MIRROR @ turn_before @ MIRROR, atol=1e-12)


def test_bones_keep_their_lengths_and_change_sides(tumbling: Motion) -> None:
    body, image = tumbling.skeleton, mirror(tumbling).skeleton

    def lengths(skeleton: Skeleton, role: str) -> np.ndarray:
        joint = skeleton.joint(role)
        return np.linalg.norm([skeleton.offsets[joint], skeleton.tips[joint]], axis=-1)

    for role in body.roles:
        np.testing.assert_allclose(lengths(image, role), lengths(body, partner(role)), atol=1e-12)
    assert not np.allclose(lengths(image, "toe.L"), lengths(body, "toe.L"), atol=1e-3)


def test_a_mirrored_database_has_contacts_and_features_of_the_other_side(unequal) -> None:
    body = retarget(demo_motion("sidestep", 2), unequal())
    take = Take("sidestep", "sidestep.bvh", "0" * 64, body, {}, ())
    made = run(build_database([take], DatabaseSettings(mirror=True), name="unequal"))
    plain, image = (slice(clip.start, clip.stop) for clip in made.clips)
    assert [clip.mirrored for clip in made.clips] == [False, True]
    contacts = find_contacts(toe_positions(body), 60.0)
    np.testing.assert_array_equal(made.poses.contacts[plain], contacts)
    np.testing.assert_array_equal(made.poses.contacts[image], contacts[:, ::-1])
    assert (contacts[:, 0] != contacts[:, 1]).mean() > 0.1
    values = made.features.values * made.features.deviation + made.features.mean
    path, turned = values[plain, :6].reshape(-1, 3, 2), values[image, :6].reshape(-1, 3, 2)
    # on a body whose thighs are not opposite each other the hips move by millimetres
    np.testing.assert_allclose(turned, path * [-1.0, 1.0], atol=0.01)
    # side-steps go to one side and back: the image is another path
    assert np.abs(path[..., 0]).max() > 0.2

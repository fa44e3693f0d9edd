"""How the feet of clips stand, whatever pitch their suit gave them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from footwork.core.body.edit import cut
from footwork.core.body.legs import legs_of
from footwork.core.body.motion import Motion
from footwork.core.body.pose import with_world_rotations, world_poses
from footwork.core.database.build import build_database
from footwork.core.database.motion_database import MotionDatabase
from footwork.core.database.soles import sole_pitches, sole_pitches_at
from footwork.core.jobs import run
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.take import Take
from footwork.core.settings import DatabaseSettings
from scipy.spatial.transform import Rotation


def pitched(motion: Motion, degrees: tuple[float, float]) -> Motion:
    """The motion with its left and right heel up by an angle in the foot's own axes, the toes left where they point."""
    legs = legs_of(motion.skeleton)
    _, turns = world_poses(motion, [leg.end for leg in legs])
    wanted = {}
    for leg, angle in zip(legs, degrees, strict=True):
        own = Rotation.from_quat(np.roll(turns[leg.foot], -1, axis=-1))
        up = own * Rotation.from_euler("x", -angle, degrees=True)
        wanted[leg.foot] = np.roll(up.as_quat(), 1, axis=-1)
        wanted[leg.end] = turns[leg.end]
    return with_world_rotations(motion, wanted)


def database_of(*motions: Motion) -> MotionDatabase:
    takes = [Take(f"take{i}", f"take{i}.bvh", "", motion, {}, ()) for i, motion in enumerate(motions)]
    return run(build_database(takes, DatabaseSettings(), name="soles"))


def test_a_clip_that_stands_with_its_heels_up_says_by_how_much() -> None:
    still = cut(demo_motion("visit", 4), 0, 300)
    database = database_of(still, pitched(still, (7.0, -4.0)))
    found = np.degrees(sole_pitches(database))
    np.testing.assert_allclose(found[1] - found[0], [7.0, -4.0], atol=0.6)
    first, last = database.clips[0], database.clips[-1]
    rows = np.array([last.start + 5, first.start + 3, last.stop - 2])
    np.testing.assert_allclose(np.degrees(sole_pitches_at(database, rows)), found[[-1, 0, -1]])


def test_a_clip_that_never_stands_takes_the_others_word() -> None:
    still = cut(demo_motion("visit", 4), 0, 300)
    standing = pitched(still, (5.0, 5.0))
    way = np.linspace(0.0, 5.0, len(still))[:, None] * np.array([0.3, 1.0, 0.0])
    database = database_of(standing, replace(still, positions=still.positions + way))
    found = sole_pitches(database)
    np.testing.assert_allclose(found[1], found[0], atol=1e-9)

"""Glitches and drift in motions that are made to have them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.body.motion import Motion
from footwork.core.database.build import build_database
from footwork.core.jobs import run
from footwork.core.maths import quat
from footwork.core.mocap import checks
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.take import Take
from footwork.core.settings import DatabaseSettings


def thrown(motion: Motion, role: str, at: int) -> Motion:
    """One joint is turned for two frames."""
    rotations = motion.rotations.copy()
    joint = motion.skeleton.joint(role)
    rotations[at : at + 2, joint] = quat.multiply(
        rotations[at : at + 2, joint], quat.from_rotation_vector(np.array([1.2, 0.2, -1.3]))
    )
    return replace(motion, rotations=rotations)


@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0])
@pytest.mark.parametrize("script", ["walk", "turn", "crouch", "visit"])
def test_people_do_not_glitch(script: str, fps: float) -> None:
    assert not checks.glitches(demo_motion(script, 4, fps)).any()


@pytest.mark.parametrize("role", ["thigh.L", "thigh.R", "shin.R", "upper_arm.L", "upper_arm.R"])
def test_a_thrown_limb_is_found_with_a_tenth_of_a_second_around(role: str) -> None:
    motion = demo_motion("walk", 4, 60.0)
    found = checks.glitches(thrown(motion, role, 200))
    frames = np.flatnonzero(found)
    assert frames[0] == 199 - 6 and frames[-1] == 202 + 6 and found[frames[0] : frames[-1] + 1].all()


def test_databases_leave_glitches_out_and_say_so() -> None:
    motion = demo_motion("walk", 4, 60.0)
    whole = Take("walk", "walk.bvh", "", motion, {}, ())
    torn = replace(whole, motion=thrown(motion, "thigh.L", 300))
    clean, cut = (
        run(build_database([take], DatabaseSettings(mirror=False), name="w")) for take in (whole, torn)
    )
    assert len(clean.clips) == 1 and len(cut.clips) == 2
    assert len(clean) - len(cut) == 308 + 1 - 293
    assert "walk:4.883-5.15: a limb moves as no limb does" in cut.provenance["skipped"]
    assert "limb" not in clean.provenance["skipped"]


@pytest.mark.parametrize(
    ("degrees", "drifts"),
    [
        ((3, -5, 2, 4, -1, 38), False),  # one long look at the end
        ((-6, -4, 7, 8, -15, 41), False),
        ((2, 40, -3, 1, 0, 4), False),
        ((-39, -39, -38, -36, -37, -37), True),
        ((-5, 4, 27, 42, 62, 74), True),
        ((-43, -1, 3, 31, 17, 27), True),
        ((0, -19, 4, 67, 59, 54), True),
        ((13, -14, -29, 20, 19, 17), False),
    ],
)
def test_drift_is_judged_over_the_whole_take(degrees: tuple[float, ...], drifts: bool) -> None:
    parts = np.radians(degrees)
    found = checks.drifted(parts)
    assert found.any() == drifts
    assert not (found & (np.abs(parts) <= checks.DRIFT)).any()

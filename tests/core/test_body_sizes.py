"""Rigs of other sizes: what is baked on a body is baked on one as large as a child's toy or a giant, only larger."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.body.edit import cut
from footwork.core.body.motion import Motion
from footwork.core.body.skeleton import Skeleton
from footwork.core.database.build import build_database
from footwork.core.database.motion_database import MotionDatabase
from footwork.core.database.virtual_root import virtual_root
from footwork.core.jobs import run
from footwork.core.maths import quat
from footwork.core.mocap.demo import demo_motion, demo_skeleton
from footwork.core.mocap.take import Take
from footwork.core.pipeline import BakeResult, bake, scale_ground
from footwork.core.recording.body_estimate import BodyEstimate
from footwork.core.recording.simulate import simulate_recording
from footwork.core.rig.fit import rig_from_skeleton
from footwork.core.rig.rig import Rig
from footwork.core.settings import BakeSettings, DatabaseSettings

FPS = 30.0
SIZES = (0.3, 0.61, 1.76)
UNITLESS = {"skating_ratio", "transitions_per_s", "poses_used", "clamped_fraction", "unreachable_fraction"}


@pytest.fixture(scope="module")
def walking() -> MotionDatabase:
    takes = [
        Take(name, f"{name}.bvh", name.encode().hex().ljust(64, "0"), demo_motion(name, 3, FPS), {}, ())
        for name in ("walk", "turn", "crouch")
    ]
    return run(build_database(takes, DatabaseSettings(fps=FPS), name="walking"))


@pytest.fixture(scope="module")
def user() -> Motion:
    return cut(demo_motion("visit", 5, FPS, height=1.58), 0, 240)


def rig_of(body: Skeleton, size: float) -> Rig:
    """The same rig, as large as an object's scale makes it."""
    rig = rig_from_skeleton(body, "rig")
    world = np.array(rig.world)
    world[:3, :3] *= size
    return replace(rig, world=world)


def baked(user: Motion, walking: MotionDatabase, size: float, ground=None, **settings) -> BakeResult:
    yaws = virtual_root(user, 0.0)[1]
    body = demo_skeleton(height=1.71)
    recording = simulate_recording(user, "user")
    options = BakeSettings(**settings)
    job = bake(recording, [walking], lambda _: BodyEstimate(yaws), rig_of(body, size), options, ground=ground)
    return run(job)


def bumps(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A hilly ground."""
    x, y = points.T
    heights = 0.06 * np.sin(1.3 * x + 0.4) * np.cos(0.9 * y)
    slopes = np.stack(
        [
            -0.078 * np.cos(1.3 * x + 0.4) * np.cos(0.9 * y),
            0.054 * np.sin(1.3 * x + 0.4) * np.sin(0.9 * y),
            np.ones_like(x),
        ],
        axis=-1,
    )
    return heights, slopes / np.linalg.norm(slopes, axis=-1, keepdims=True)


# alpha bounds a giant's root in metres, so that only one that does not bind moves it alike
@pytest.mark.parametrize(("size", "alpha"), [(0.3, 0.05), (0.61, 0.05), (0.3, 0.3), (0.61, 0.3), (1.76, 1.0)])
def test_the_same_movement_at_every_size(user, walking, size: float, alpha: float) -> None:
    usual, other = (baked(user, walking, factor, alpha=alpha) for factor in (1.0, size))
    apart = quat.multiply(quat.conjugate(usual.tracks.rotations), other.tracks.rotations)
    # a knee that is nearly straight turns far for little
    assert np.abs(quat.to_rotation_vector(apart)).max() < 2e-3
    np.testing.assert_allclose(other.motion.positions, size * usual.motion.positions, atol=1e-4 * size)
    np.testing.assert_allclose(other.tracks.locations, usual.tracks.locations, atol=1e-4)
    assert (other.contacts == usual.contacts).all()


@pytest.mark.parametrize("size", SIZES)
def test_figures_grow_with_the_body(user, walking, size: float) -> None:
    usual, other = (baked(user, walking, factor, alpha=1.0).report["metrics"] for factor in (1.0, size))
    seen = 0
    for name, figure in usual.items():
        lengths = name.endswith(("_cm", "_cm_s", "_m_s3")) or name == "jitter"
        for part in ("mean", "p95", "max") if isinstance(figure, dict) else ():
            wanted = figure[part] * (size if lengths else 1.0)
            assert other[name][part] == pytest.approx(wanted, rel=2e-3, abs=2e-3), (name, part)
            seen += wanted > 0.1
        if name in UNITLESS:
            assert other[name] == pytest.approx(figure, abs=1e-9), name
    assert seen > 15


@pytest.mark.parametrize("size", SIZES)
def test_ground_of_the_same_shape_is_walked_alike(user, walking, size: float) -> None:
    usual = baked(user, walking, 1.0, ground=bumps, alpha=1.0)
    other = baked(user, walking, size, ground=scale_ground(bumps, size), alpha=1.0)
    apart = quat.multiply(quat.conjugate(usual.tracks.rotations), other.tracks.rotations)
    assert np.abs(quat.to_rotation_vector(apart)).max() < 1e-3
    assert np.ptp(usual.motion.positions[:, 2]) > 0.01


@pytest.mark.parametrize(
    ("size", "told"), [(0.16, True), (0.19, False), (1.7, False), (1.85, True), (100.0, True)]
)
def test_bodies_that_are_none_are_told_of_in_one_line(user, walking, size: float, told: bool) -> None:
    lines = [line for line in baked(cut(user, 0, 40), walking, size).warnings if "tall" in line]
    assert len(lines) == told
    if told:
        height = float(lines[0].removeprefix("rig is ").partition(" m tall")[0])
        assert height == pytest.approx(1.71 * size, rel=0.02) and "unit scale" in lines[0]

"""Motions whose roots, contacts and features are known in closed form."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from footwork.core.body.motion import Motion
from footwork.core.database.build import build_database
from footwork.core.database.motion_database import MotionDatabase
from footwork.core.jobs import run
from footwork.core.maths import quat
from footwork.core.mocap.demo import demo_motion, demo_skeleton
from footwork.core.mocap.take import Take
from footwork.core.settings import DatabaseSettings

Glide = Callable[..., Motion]
AsTake = Callable[..., Take]


@pytest.fixture(scope="session")
def glide() -> Glide:
    """A body in T-pose that slides along a path: `glide(positions (T, 2), yaws (T,), fps)`."""

    def make(positions: np.ndarray, yaws: np.ndarray, fps: float = 60.0) -> Motion:
        skeleton = demo_skeleton()
        rotations = np.tile(quat.IDENTITY, (len(yaws), len(skeleton), 1))
        rotations[:, 0] = quat.from_yaw(yaws)
        heights = np.full(len(yaws), skeleton.offsets[0, 2])
        return Motion(skeleton, fps, np.column_stack([positions, heights]), quat.continuous(rotations))

    return make


@pytest.fixture(scope="session")
def as_take() -> AsTake:
    def make(motion: Motion, name: str = "walk") -> Take:
        return Take(name, f"takes/{name}.bvh", name.encode().hex().ljust(64, "0"), motion, {}, ())

    return make


@pytest.fixture(scope="session")
def small(as_take: AsTake) -> MotionDatabase:
    """A small mirrored database of demo takes."""
    takes = [as_take(demo_motion(name), name) for name in ("turn", "sidestep")]
    settings = DatabaseSettings(mirror=True, height_low=0.8, height_high=1.1)
    return run(build_database(takes, settings, name="small", tags=("demo", "päivä")))

"""Bodies for tests of core: a demo walk, and skeletons with fewer or other joints."""

from __future__ import annotations

import numpy as np
import pytest
from footwork.core.body.motion import Motion
from footwork.core.body.skeleton import Skeleton
from footwork.core.mocap.demo import demo_motion, demo_skeleton
from scipy.spatial.transform import Rotation


def _without(skeleton: Skeleton, *parts: str) -> Skeleton:
    """The same body with some joints left out, their children hung from what is left above them."""
    keep = [j for j, role in enumerate(skeleton.roles) if role.split(".")[0] not in parts]
    places = skeleton.tpose_positions()
    parents, offsets = [], []
    for joint in keep:
        above = int(skeleton.parents[joint])
        while above >= 0 and above not in keep:
            above = int(skeleton.parents[above])
        parents.append(keep.index(above) if above >= 0 else -1)
        offsets.append(places[joint] - (places[above] if above >= 0 else 0.0))
    return Skeleton(
        names=tuple(skeleton.names[j] for j in keep),
        parents=np.array(parents, np.intp),
        offsets=np.array(offsets),
        roles=tuple(skeleton.roles[j] for j in keep),
        tips=skeleton.tips[keep],
    )


def _random_pose(skeleton: Skeleton, frames: int, seed: int = 0) -> Motion:
    """Any rotation at any joint."""
    rng = np.random.default_rng(seed)
    rotations = rng.normal(size=(frames, len(skeleton), 4))
    rotations /= np.linalg.norm(rotations, axis=-1, keepdims=True)
    return Motion(skeleton, 60.0, rng.normal(size=(frames, 3)), rotations)


def _turns(quaternions: np.ndarray) -> Rotation:
    """scipy rotations of `[w, x, y, z]`."""
    return Rotation.from_quat(np.roll(quaternions.reshape(-1, 4), -1, axis=-1))


def _degrees_between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Angles between two arrays of quaternions, by scipy."""
    return np.degrees((_turns(a) * _turns(b).inv()).magnitude()).reshape(a.shape[:-1])


def _world(motion: Motion, role: str) -> tuple[np.ndarray, np.ndarray]:
    """World positions and rotations of one joint."""
    positions, rotations = motion.forward()
    joint = motion.skeleton.joint(role)
    return positions[:, joint], rotations[:, joint]


@pytest.fixture(scope="session")
def without():
    return _without


@pytest.fixture(scope="session")
def random_pose():
    return _random_pose


@pytest.fixture(scope="session")
def turns():
    return _turns


@pytest.fixture(scope="session")
def degrees_between():
    return _degrees_between


@pytest.fixture(scope="session")
def world():
    return _world


@pytest.fixture(scope="session")
def walk() -> Motion:
    return demo_motion("walk")


@pytest.fixture(scope="session")
def visit() -> Motion:
    return demo_motion("visit", seed=3)


@pytest.fixture(scope="session")
def small() -> Skeleton:
    return demo_skeleton(1.55)

"""Fixtures for all tests: where the real takes, recordings and rigs are."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from footwork.core.body.skeleton import Skeleton
from footwork.core.mocap.bvh import write_bvh
from footwork.core.mocap.demo import demo_motion, demo_skeleton
from footwork.core.mocap.export import to_bvh
from footwork.core.presets import VARIABLE

DATA = Path(os.environ.get("FOOTWORK_DATA", Path(__file__).parents[2] / "shared" / "data"))


@pytest.fixture(scope="session", autouse=True)
def no_own_presets(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """The presets of whoever runs the tests do not count."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(VARIABLE, str(tmp_path_factory.mktemp("presets")))
        yield


@pytest.fixture(scope="session")
def data() -> Path:
    """The folder with real takes, recordings and rigs; tests that need it are skipped where it is absent."""
    if not (DATA / "takes").is_dir():
        pytest.skip("no motion data beside the project (set FOOTWORK_DATA)")
    return DATA


@pytest.fixture(scope="session")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with procedural takes: walk, turn, sidestep, crouch and visit `.bvh`."""
    folder = tmp_path_factory.mktemp("demo")
    for seed, script in enumerate(("walk", "turn", "sidestep", "crouch", "visit")):
        write_bvh(folder / f"{script}.bvh", to_bvh(demo_motion(script, seed), script))
    return folder


@pytest.fixture(scope="session")
def unequal() -> Callable[..., Skeleton]:
    """A body of which no two measures are the same: `unequal(height)` in metres, 1.75 by default.

    The sides differ in every length, no bone lies along an axis, and each leaf has a tip of its own.
    """

    def make(height: float = 1.75) -> Skeleton:
        body = demo_skeleton()
        rng = np.random.default_rng(12)
        offsets, tips = body.offsets.copy(), body.tips.copy()
        offsets[1:] *= 1.0 + 0.12 * rng.uniform(-1.0, 1.0, (len(body) - 1, 1))
        offsets[1:] += 0.012 * rng.uniform(-1.0, 1.0, (len(body) - 1, 3))
        leaf = tips.any(axis=1)
        tips[leaf] += 0.02 * rng.uniform(-1.0, 1.0, (int(leaf.sum()), 3))
        size = height / 1.75
        return Skeleton(body.names, body.parents, offsets * size, body.roles, tips * size)

    return make


@pytest.fixture(scope="session")
def tumble() -> Callable[..., np.ndarray]:
    """Rotations about axes that change all the time: `tumble(frames, fps, count, seed)`, `(T, count, 4)`.

    As w x y z: smooth curves around any point of the sphere of unit quaternions, up to 130 degrees from it.
    """

    def make(frames: int, fps: float = 60.0, count: int = 1, seed: int = 0) -> np.ndarray:
        rng = np.random.default_rng(seed)
        times = np.arange(frames)[:, None, None] / fps
        start = rng.normal(size=(count, 4))
        start /= np.linalg.norm(start, axis=-1, keepdims=True)
        rate, phase = rng.uniform(0.2, 0.8, (2, count, 4)), rng.uniform(0.0, 2.0 * np.pi, (2, count, 4))
        wave = np.sum(np.sin(2.0 * np.pi * rate[:, None] * times + phase[:, None]), axis=0)
        out = start + 0.9 / np.sqrt(16.0) * wave
        return out / np.linalg.norm(out, axis=-1, keepdims=True)

    return make
